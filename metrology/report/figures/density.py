"""What Monte Carlo found: the density of the result with the interval of the law and the shortest one."""

from __future__ import annotations

from typing import Any

import numpy as np

from metrology.findings import Result
from metrology.report.display import estimate, symbol, unit_text
from metrology.report.figures.style import BLUE, HALF, INK, ORANGE, PALE, Plot, canvas, finish, place, plain


def draw(result: Result, *, label: str = "") -> Plot:
    """Histogram of the draws as a density, the law's normal density over it, both coverage intervals beneath."""
    from metrology.units import convert, factor

    trials, unit = result.monte_carlo, result.display_unit
    figure = canvas(HALF, 50.0, label=label)
    axes = place(figure, (13.0, 9.0, 1.5, 8.0))
    size = factor(unit)
    edges = np.array([convert(edge, unit) for edge in trials.edges])
    density = np.array(trials.density) * size
    axes.stairs(density, edges, fill=True, color=PALE, label="Monte Carlo")
    _normal(axes, edges, convert(result.value, unit), result.u / size)
    top = float(np.max(density, initial=0.0)) or 1.0
    intervals = (
        ("interval by the law", INK, (0, (4, 1.5)), (result.coverage.low, result.coverage.high), -0.07),
        ("shortest interval", BLUE, "-", (trials.shortest_low, trials.shortest_high), -0.16),
    )
    for name, colour, dash, (low, high), at in intervals:
        if low is not None and high is not None:
            ends = [convert(low, unit), convert(high, unit)]
            axes.plot(ends, [at * top] * 2, color=colour, lw=1.6, ls=dash, label=name)
            axes.plot(ends, [at * top] * 2, "|", color=colour, ms=5, mew=1.0)
    axes.set_ylim(-0.25 * top, 1.12 * top)
    text = unit_text(unit)
    axes.set_xlabel(
        f"{plain(symbol(result.quantity).replace('_n', 'ₙ'))} / {text}"
        if text
        else plain(symbol(result.quantity).replace("_n", "ₙ"))
    )
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_ylabel("probability density")
    axes.xaxis.get_major_locator().set_params(nbins=5)  # type: ignore[call-arg]
    axes.legend(loc="lower left", bbox_to_anchor=(-0.14, 1.0), ncols=2, fontsize=6)
    return finish(figure, _alt(result), _CAPTION)


def _normal(axes: Any, edges: Any, value: float, u: float) -> None:
    if u <= 0 or not edges.size:
        return
    x = np.linspace(edges[0], edges[-1], 120)
    axes.plot(
        x, np.exp(-0.5 * ((x - value) / u) ** 2) / (u * np.sqrt(2 * np.pi)), color=ORANGE, lw=0.9, label="law (normal)"
    )


def _alt(result: Result) -> str:
    trials = result.monte_carlo
    law = estimate(result.value, result.u, result.display_unit, (result.coverage.low, result.coverage.high))
    drawn = estimate(trials.mean, trials.u, result.display_unit, (trials.shortest_low, trials.shortest_high))
    return (
        f"Density of {plain(symbol(result.quantity).replace('_n', 'ₙ'))} from {trials.trials} Monte "
        f"Carlo trials with two {100 * trials.p:g} % intervals: by the "
        f"law {law.low} to {law.high} {law.unit}, shortest by Monte Carlo {drawn.low} to {drawn.high} "
        f"{drawn.unit}. {trials.verdict}"
    )


_CAPTION = (
    "Density of the Monte Carlo draws with the normal density of the law of propagation and both coverage intervals."
)
