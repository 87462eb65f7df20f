"""Line types of MoorDyn v2: a section that its input file takes as it is.

Columns and units: MoorDyn's documentation, "The V2 Input File", "Line Types" (moordyn.readthedocs.io).
"""

from __future__ import annotations

from collections.abc import Sequence

from metrology.errors import Fault, MetrologyError
from metrology.export.line import Line, heading, lines, sources
from metrology.findings import Findings

_COLUMNS = ("TypeName", "Diam", "Mass/m", "EA", "BA/-zeta", "EI", "Cd", "Ca", "CdAx", "CaAx")
_UNITS = ("(name)", "(m)", "(kg/m)", "(N)", "(N-s/-)", "(N-m^2)", "(-)", "(-)", "(-)", "(-)")
_UNMEASURED = "EI and the coefficients of a fluid: not measured, 0 is a line that does not resist bending, in vacuum"


def line_types(findings: Findings, use: Sequence[str] = ()) -> bytes:
    """The section LINE TYPES, a row a sample: EA = k·L, BA = c·L, diameter of the same area, mass per length.

    Parameters
    ----------
    findings : Findings
    use : sequence of str
        Full names of results, for a quantity that several tests give.

    Raises
    ------
    MetrologyError
        For every sample that lacks c, length, section or mass per length.
    """
    found = lines(findings, use)
    rows: list[str] = []
    faults: list[Fault] = []
    for line in found:
        try:
            rows.append(_row(line))
        except MetrologyError as error:
            faults += error.faults
    if faults:
        raise MetrologyError(*faults)
    remarks = [*heading(findings, "Line types for MoorDyn v2"), *(text for line in found for text in sources(line))]
    # Three hyphens in a row would begin a section.
    head = [f"# {text.replace('--', '- -')}" for text in [*remarks, _UNMEASURED]]
    title = f"{' LINE TYPES ':-^80}"
    return "\n".join([*head, title, " ".join(_COLUMNS), " ".join(_UNITS), *rows, ""]).encode()


def _row(line: Line) -> str:
    numbers = (line.diameter, line.mass_per_length, line.axial_stiffness, line.axial_damping)
    u = ", ".join(f"u({name}) = {one.s:.2g}" for name, one in zip(_COLUMNS[1:5], numbers, strict=True))
    name = "-".join(line.name.split())
    return f"{name} {' '.join(repr(one.n) for one in numbers)} 0 0 0 0 0 # {u.replace('BA/-zeta', 'BA')}"
