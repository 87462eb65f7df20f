"""A draft campaign from files of readings that nobody described, with every guess marked as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from metrology.draft.pairs import paired
from metrology.draft.runs import found_in
from metrology.draft.survey import NO_PARTS
from metrology.draft.writing import Draft, write
from metrology.errors import Fault, MetrologyError

__all__ = ["Draft", "draft", "place"]


def draft(
    files: Sequence[Path], given: Mapping[str, str], output: Path | None = None, parts: Mapping[str, str] = NO_PARTS
) -> tuple[Path, Draft]:
    """Look at files and return a draft campaign, and where it goes; nothing is written.

    Parameters
    ----------
    files : sequence of Path
        Files of readings of one test, all in one folder or below it; each may hold several runs.
    given : mapping of str to str
        Values that the files do not have, such as ``mass``.
    output : Path, optional
        The campaign file; beside the first file and named after it where nothing is said.
    parts : mapping of str to str
        What of each file is read, its `member`, `sheet`, `group`, `dataset` or `channel`; the whole where nothing is
        said.

    Raises
    ------
    MetrologyError
        For a file that cannot be read, that holds nothing known, or that lies outside the folder of the campaign file.
    """
    if given.get("decimal", "point") not in ("point", "comma"):
        raise MetrologyError(Fault("--set decimal", f"'{given['decimal']}'", "'point' or 'comma'"))
    parts = {**parts, **{key: value for key, value in given.items() if key == "decimal"}}
    path = output or files[0].with_name(f"{files[0].name.partition('.')[0]}.yaml")
    for file in files:
        if wrong := sorted(set(file.name) & set(":\\")):
            got, expected = f"'{wrong[0]}' in the name of a file", "a name that a campaign can have"
            raise MetrologyError(Fault(str(file), got, expected, "rename the file"))
        if not file.resolve().is_relative_to(path.parent.resolve()):
            expected = f"a file in {path.parent}, the folder of the campaign file, or below it"
            raise MetrologyError(Fault(str(file), "a file elsewhere", expected, "copy it there"))
    return path, write(paired([run for file in files for run in found_in(file, parts)]), path, given)


def place(path: Path, made: Draft) -> None:
    """Write a draft where no file stands.

    Raises
    ------
    MetrologyError
        Where there is one.
    """
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(made.text)
    except FileExistsError:
        fix = "name another with --output"
        raise MetrologyError(Fault(str(path), "a file that exists", "a new one: nothing is overwritten", fix)) from None
    except OSError as error:
        raise MetrologyError(Fault(str(path), f"no place to write ({error.strerror})", "a folder")) from None
