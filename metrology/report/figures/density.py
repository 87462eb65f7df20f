"""What Monte Carlo found: the density of the result with the interval of the law and the one by Monte Carlo."""

from __future__ import annotations

from math import exp, pi, sqrt

from metrology.findings import Result
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import estimate, symbol
from metrology.message import said
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BLUE, HALF, INK, ORANGE, PALE, Plot, plain
from metrology.units import unit_text

_FILL, _CURVE = Pen(fill=PALE), Pen(stroke=ORANGE, width=0.9)
_LAW, _DRAWN = Pen(stroke=INK, width=1.6, dash=(6.4, 2.4)), Pen(stroke=BLUE, width=1.6)


def draw(result: Result, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """Histogram of the draws, the normal density of the GUM uncertainty framework, both coverage intervals beneath."""
    from metrology.units import convert, factor

    trials, unit = result.monte_carlo, result.display_unit
    edges = [convert(edge, unit) for edge in trials.edges]
    density = [height * factor(unit) for height in trials.density]
    top = max(density, default=0.0) or 1.0
    plot = Sketch((HALF, 42.0), (8.0, 10.0, 2.5, 8.5), label=label, language=language)
    plot.window((edges[0], edges[-1]), (-0.25 * top, 1.12 * top))
    steps = [
        (x, y) for left, right, y in zip(edges, edges[1:], density, strict=False) for x, y in ((left, y), (right, y))
    ]
    plot.line([edges[0], *(x for x, _ in steps), edges[-1]], [0.0, *(y for _, y in steps), 0.0], _FILL)
    _normal(plot, edges[0], edges[-1], convert(result.framework.value, unit), result.framework.u / factor(unit))
    intervals = (
        (_LAW, (result.coverage.low, result.coverage.high), -0.07),
        (_DRAWN, trials.interval, -0.16),
    )
    for pen, (low, high), at in intervals:
        if low is not None and high is not None:
            plot.interval(convert(low, unit), convert(high, unit), at * top, pen)
    name, text = plain(symbol(result.quantity).replace("_n", "ₙ")), unit_text(unit)
    plot.x_axis(f"{name} / {text}" if text else name)
    plot.y_title(said("probability density"))
    kind = said("shortest interval") if trials.reported == "shortest" else said("symmetric interval")
    names = (said("Monte Carlo"), said("GUM (normal)"), said("GUM interval"), kind)
    plot.legend(zip(names, (_FILL, _CURVE, _LAW, _DRAWN), strict=True))
    owner = plain(result.test or result.name)
    caption = said("{symbol}, {owner}: density and coverage intervals.", symbol=name, owner=owner)
    return plot.finish(_alt(result), caption)


def _normal(plot: Sketch, low: float, high: float, value: float, u: float) -> None:
    if u <= 0:
        return
    xs = [low + (high - low) * i / 120 for i in range(121)]
    plot.line(xs, [exp(-0.5 * ((x - value) / u) ** 2) / (u * sqrt(2 * pi)) for x in xs], _CURVE)


def _alt(result: Result) -> str:
    trials = result.monte_carlo
    law = estimate(
        result.framework.value, result.framework.u, result.display_unit, (result.coverage.low, result.coverage.high)
    )
    drawn = estimate(trials.mean, trials.u, result.display_unit, trials.interval)
    text = (
        "Density of {symbol} from {trials} Monte Carlo trials with two {percent:g} % intervals: by the GUM framework "
        "{low:figures} to {high:figures} {unit}, by Monte Carlo {least:figures} to {most:figures} {unit}. "
        "{verdict}"
    )
    return said(
        text, symbol=plain(symbol(result.quantity).replace("_n", "ₙ")), trials=trials.trials, percent=100 * trials.p,
        low=law.low, high=law.high, unit=law.unit, least=drawn.low, most=drawn.high, verdict=trials.verdict,
    )  # fmt: skip
