"""Whether what is stated speaks against a cause of a discrepancy, and stated sizes as they are written."""

from __future__ import annotations

from metrology.diagnosis import Judgement
from metrology.diagnostics.discrepancy_setting import Known
from metrology.gum.rounding import significant
from metrology.message import said

BEYOND = 3.0
"""Standard uncertainties beyond which something stated or measured speaks against a cause."""


def judged(tension: float | None, *, data: bool = False) -> Judgement:
    """Whether a cause is allowed that is so many standard uncertainties from what is stated, or from the data."""
    if tension is None or abs(tension) <= BEYOND:
        return "allowed"
    return "against these data" if data else "against what is stated"


def stated_size(one: Known, unit: str) -> str:
    """What is stated of a length or an area, in mm or mm²; without a standard uncertainty where none is."""
    size, text = (1e-6, "mm²") if unit == "m²" else (1e-3, "mm")
    if one.u is None or not one.u > 0:
        return said("stated is {value:.5g} {unit}, without an uncertainty", value=one.value / size, unit=text)
    stated = f"{' ± '.join(significant(one.value / size, one.u / size))} {text}"
    return said("stated is {stated:figures}", stated=stated)


def sized(value: float, unit: str) -> str:
    """Length or area in mm or mm²."""
    return f"{value / 1e-6:.4g} mm²" if unit == "m²" else f"{value / 1e-3:.4g} mm"


def rounded(one: Known) -> str:
    """A value to the last digit that its uncertainty leaves."""
    return significant(one.value, one.u)[0] if one.u else f"{one.value:.5g}"
