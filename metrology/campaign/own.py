"""Effects of the laboratory's own: Python files that a campaign names, hashed as they are read, run only on request."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from metrology.declaration.columns import SourceFile, source_file
from metrology.declaration.entry import Refusal
from metrology.errors import Fault, MetrologyError
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from types import TracebackType

    from metrology.campaign.schema import Campaign
    from metrology.rig.own import OwnEffect

MAX_BYTES = 256 * 1024
SUFFIX = ".py"
FLAG = "--allow-code"


class Code:
    """The files of one campaign that declare effects: their bytes as they were read, and what is wrong with them."""

    def __init__(self, campaign: Campaign) -> None:
        self.folder = campaign.folder
        self.contents: dict[str, bytes] = {}
        self.refusals: list[Refusal] = []
        for index, file in enumerate(campaign.diagnosis.effects):
            place = ("diagnosis", "effects", index)
            reason = "named twice" if file in self.contents else _refused(self.folder, file)
            if reason:
                self.refusals.append(
                    Refusal(place, quoted(file), "a .py file in the campaign's folder, each once", reason)
                )
                continue
            self.contents[file] = (self.folder / file).read_bytes()

    @property
    def files(self) -> tuple[SourceFile, ...]:
        """Every file with its hash."""
        return tuple(source_file(Path(name).as_posix(), raw) for name, raw in self.contents.items())

    def run(self) -> tuple[OwnEffect, ...]:
        """Execute the files, the very bytes that were hashed, and return what they declare.

        Raises
        ------
        MetrologyError
            With file and line: Python that does not run, a file that declares nothing, a name that is taken.
        """
        found: dict[str, OwnEffect] = {}
        for name, raw in self.contents.items():
            path = str(self.folder / name)
            for effect in _declared(path, raw):
                if effect.name in found or effect.name in _taken():
                    got = f"effect '{effect.name}', a name that is taken"
                    raise MetrologyError(Fault(_first(path, raw, effect.name), got, "a name that no other effect has"))
                found[effect.name] = effect
        return tuple(found.values())


def _refused(folder: Path, file: str) -> str:
    """Why a file may not be read; empty where it may."""
    path = Path(file)
    if path.is_absolute() or any(letter in file for letter in "\\:\0") or ".." in path.parts:
        return "write the path from the campaign's folder, with '/'"
    if not file.endswith(SUFFIX):
        return "the name ends in .py"
    full = folder / path
    if not full.is_file():
        return "there is no such file"
    if not full.resolve().is_relative_to(folder.resolve()):
        return "a link leads out of the campaign's folder"
    return "it is larger than 256 KiB" if full.stat().st_size > MAX_BYTES else ""


def _taken() -> set[str]:
    from metrology.diagnostics.candidate import ELONGATION, RESPONSE

    return set(ELONGATION) | set(RESPONSE)


def _declared(path: str, raw: bytes) -> list[OwnEffect]:
    from metrology.rig.own import OwnEffect

    module = ModuleType(Path(path).stem)
    try:
        exec(compile(raw, path, "exec"), module.__dict__)  # noqa: S102 - the user asked for it, by name of the flag
    except SyntaxError as error:
        raise MetrologyError(Fault(f"{path}:{error.lineno or 1}", f"{error.msg}", "a file of Python")) from None
    except MetrologyError as error:
        at = _line(path, error.__traceback__)
        faults = (Fault(f"{at} {fault.where}", fault.got, fault.expected, fault.fix) for fault in error.faults)
        raise MetrologyError(*faults) from None
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever the code of others may raise
        got = f"{type(error).__name__}: {error}"
        raise MetrologyError(Fault(_line(path, error.__traceback__), got, "a file that runs")) from None
    found = [value for value in vars(module).values() if isinstance(value, OwnEffect)]
    if not found:
        raise MetrologyError(Fault(f"{path}:1", "no effect", "a variable that holds an OwnEffect (docs/extend.md)"))
    return found


def _line(path: str, trace: TracebackType | None) -> str:
    """File and the last of its lines in a trace."""
    line = 1
    while trace is not None:
        line = trace.tb_lineno if trace.tb_frame.f_code.co_filename == path else line
        trace = trace.tb_next
    return f"{path}:{line}"


def _first(path: str, raw: bytes, text: str) -> str:
    """File and the first line that holds a text in quotes."""
    lines = raw.decode("utf-8", "replace").splitlines()
    return f"{path}:{next((at for at, line in enumerate(lines, 1) if repr(text)[1:-1] in line), 1)}"


def check_allowed(campaign: Campaign) -> None:
    """Refuse to evaluate a campaign whose code was not run: that has to be an explicit choice.

    Raises
    ------
    MetrologyError
        Naming the flag.
    """
    if campaign.diagnosis.effects and not campaign.own:
        files = ", ".join(campaign.diagnosis.effects)
        fix = f"read {files}, then give {FLAG} to run, report, diagnose or batch"
        where = campaign.at("diagnosis", "effects")
        raise MetrologyError(Fault(where, f"Python code of the campaign's own ({files})", "leave to run it", fix))
