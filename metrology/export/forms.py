"""The forms in which simulations and other estimators read results, and how each is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from metrology.errors import Fault, MetrologyError
from metrology.export import moordyn, mujoco, parameters, petab
from metrology.findings import Findings
from metrology.report import staging

Make = Callable[[Findings, Sequence[str]], bytes | dict[str, bytes]]
FORMS: Mapping[str, Make] = MappingProxyType(
    {
        "moordyn": moordyn.line_types,
        "mujoco": mujoco.tendons,
        "table": parameters.files,
        "petab": petab.files,
    }
)
"""What makes each form: one file, or several by name."""


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
    if form not in FORMS:
        raise MetrologyError(Fault("form", f"'{form}'", f"one of {', '.join(FORMS)}"))
    made = FORMS[form](findings, use)
    if isinstance(made, bytes):
        staging.replace_file(path, made)
        return
    for name, content in made.items():
        staging.replace_file(path / name, content)
