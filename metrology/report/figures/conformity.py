"""Results against limits: value with its coverage interval, tolerance limits, acceptance limits and guard band."""

from __future__ import annotations

from metrology.findings import Conformity
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import symbol
from metrology.message import said
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, BLUE, FULL, INK, PALE, Plot, plain
from metrology.units import unit_text

_LIMIT, _ACCEPTED = Pen(stroke=INK, width=1.0), Pen(stroke=INK, width=0.6, dash=(1.8, 1.2))


def draw(conformity: Conformity, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """One requirement on one axis: what lies outside the limits is grey, the guard band pale."""
    from metrology.units import convert

    unit = conformity.display_unit
    entries = (conformity.lower, conformity.upper, conformity.acceptance_lower, conformity.acceptance_upper)
    marks = [None if mark is None else convert(mark, unit) for mark in entries]
    value = convert(conformity.value, unit)
    # Results of an earlier version hold no interval; the value is drawn alone then.
    ends = [convert(end, unit) for end in (conformity.low, conformity.high) if end is not None]
    shown = [mark for mark in marks if mark is not None] + [2 * end - value for end in ends]
    reach = max(abs(mark - value) for mark in shown) * 1.25 or 1.0
    plot = Sketch((FULL, 25.0), (15.0, 9.0, 1.5, 6.0), label=label, language=language)
    plot.window((value - reach, value + reach), (-1.0, 1.0))
    _side(plot, marks[0], marks[2], value - reach)
    _side(plot, marks[1], marks[3], value + reach)
    if len(ends) == 2:
        plot.interval(ends[0], ends[1], 0.0, Pen(stroke=BLUE, width=1.2))
    plot.dots((value,), (0.0,), Mark("o", BLUE, 4.5))
    name, text = plain(symbol(conformity.quantity).replace("_n", "ₙ")), unit_text(unit)
    plot.x_axis(f"{name} / {text}" if text else name, 8)
    return plot.finish(_alt(conformity), said(_CAPTION))


def _side(plot: Sketch, limit: float | None, acceptance: float | None, edge: float) -> None:
    """Shade what lies beyond a limit, tint its guard band, and name the limit above the axes."""
    if limit is None:
        return
    plot.shade(min(limit, edge), max(limit, edge), PALE)
    if acceptance is not None and acceptance != limit:
        plot.shade(min(limit, acceptance), max(limit, acceptance), BAND)
        plot.upright(acceptance, _ACCEPTED)
    plot.upright(limit, _LIMIT)
    name, align = (said("lower limit"), 1.0) if edge < limit else (said("upper limit"), 0.0)
    plot.text(name, (limit, 1.3), align=align)


def _alt(conformity: Conformity) -> str:
    text = (
        "Requirement {requirement}: the value of {symbol} with its coverage interval against its limits and guard "
        "band. Verdict: {verdict}. {sentence}"
    )
    return said(
        text, requirement=plain(conformity.requirement),
        symbol=plain(symbol(conformity.quantity).replace("_n", "ₙ")), verdict=conformity.verdict,
        sentence=conformity.sentence,
    )  # fmt: skip


_CAPTION = "Value with its coverage interval; grey: beyond the limit; pale: guard band; dashed: acceptance limit."
