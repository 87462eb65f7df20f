"""The forms in which simulations and other estimators read results, and how each is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

from metrology.errors import Fault, MetrologyError

if TYPE_CHECKING:
    from pathlib import Path

    from metrology.findings import Findings


@dataclass(frozen=True)
class Form:
    """A form: what it is, the function of this folder that makes it, and whether that makes one file or several."""

    title: str
    module: str
    function: str
    alone: bool = False

    def __call__(self, findings: Findings, use: Sequence[str]) -> bytes | dict[str, bytes]:
        """Return the file, or the files by name; `use` as for `write`."""
        # Only here: the command line asks for the titles at every start.
        module = import_module(f"metrology.export.{self.module}")
        made: bytes | dict[str, bytes] = getattr(module, self.function)(findings, use)
        return made


FORMS: Mapping[str, Form] = MappingProxyType(
    {
        "moordyn": Form("line types for MoorDyn v2", "moordyn", "line_types", alone=True),
        "mujoco": Form("tendons for MuJoCo", "mujoco", "tendons", alone=True),
        "table": Form(
            "parameters and time series as CSV and JSON, for Simulink, Modelica and others", "parameters", "files"
        ),
        "petab": Form("a problem for other estimators, in the tables of PEtab", "petab", "files"),
    }
)


def write(form: str, findings: Findings, path: Path, *, use: Sequence[str] = ()) -> None:
    """Write results in a form, as a file or as a folder of files.

    Parameters
    ----------
    form : str
        A key of `FORMS`.
    findings : Findings
    path : Path
        The file, or the folder, which is made where it is missing.
    use : sequence of str
        Full names of results: those that are wanted, or of several that give one quantity the one that is meant.

    Raises
    ------
    MetrologyError
        For another form, for everything that it needs and the results do not have, and where it cannot be written.
    """
    from metrology.report import staging

    if form not in FORMS:
        raise MetrologyError(Fault("form", f"'{form}'", f"one of {', '.join(FORMS)}"))
    made = FORMS[form](findings, use)
    if isinstance(made, bytes):
        staging.replace_file(path, made)
        return
    for name, content in made.items():
        staging.replace_file(path / name, content)
