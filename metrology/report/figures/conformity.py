"""Results against limits: value with its expanded interval, tolerance limits, acceptance limits and guard band."""

from __future__ import annotations

from typing import Any

from metrology.findings import Conformity
from metrology.report.display import symbol, unit_text
from metrology.report.figures.style import BAND, BLUE, FULL, INK, PALE, Plot, canvas, finish, place, plain


def draw(conformity: Conformity, *, label: str = "") -> Plot:
    """One requirement on one axis: what lies outside the limits is grey, the guard band pale."""
    from metrology.units import convert

    unit = conformity.display_unit

    def shown(value: float | None) -> float | None:
        return None if value is None else convert(value, unit)

    figure = canvas(FULL, 25.0, label=label)
    axes = place(figure, (15.0, 9.0, 1.5, 6.0))
    value, high = convert(conformity.value, unit), convert(conformity.value + 2 * conformity.u, unit)
    half = high - value
    marks = [
        shown(conformity.lower),
        shown(conformity.upper),
        shown(conformity.acceptance_lower),
        shown(conformity.acceptance_upper),
    ]
    known = [mark for mark in marks if mark is not None]
    span = max([*(abs(mark - value) for mark in known), 2 * half]) * 1.25 or 1.0
    axes.set_xlim(value - span, value + span)
    axes.set_ylim(-1.0, 1.0)
    _side(axes, marks[0], marks[2], -1)
    _side(axes, marks[1], marks[3], 1)
    axes.errorbar([value], [0.0], xerr=[half], fmt="o", color=BLUE, ms=4, elinewidth=1.2, capsize=3)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    text = unit_text(unit)
    axes.set_xlabel(
        f"{plain(symbol(conformity.quantity).replace('_n', 'ₙ'))} / {text}"
        if text
        else plain(symbol(conformity.quantity).replace("_n", "ₙ"))
    )
    return finish(figure, _alt(conformity), _CAPTION)


def _side(axes: Any, limit: float | None, acceptance: float | None, sign: int) -> None:
    """Shade what lies beyond a limit, tint its guard band, and name the limit above the axes."""
    if limit is None:
        return
    edge = axes.get_xlim()[0 if sign < 0 else 1]
    axes.axvspan(*sorted((limit, edge)), color=PALE, lw=0)
    axes.axvline(limit, color=INK, lw=1.0)
    name = "lower limit" if sign < 0 else "upper limit"
    align = "right" if sign < 0 else "left"
    axes.annotate(name, (limit, 1.0), (sign * 2, 2), textcoords="offset points", ha=align, va="bottom", fontsize=6)
    if acceptance is not None and acceptance != limit:
        axes.axvspan(*sorted((limit, acceptance)), color=BAND, lw=0)
        axes.axvline(acceptance, color=INK, lw=0.6, ls=(0, (3, 2)))


def _alt(conformity: Conformity) -> str:
    return (
        f"Requirement {plain(conformity.requirement)}: the value of "
        f"{plain(symbol(conformity.quantity).replace('_n', 'ₙ'))} with an interval of ±2 standard uncertainties "
        f"against its limits and guard band. Verdict: {conformity.verdict}. {conformity.sentence}"
    )


_CAPTION = "Value with ±2 standard uncertainties; grey: beyond the limit; pale: guard band; dashed: acceptance limit."
