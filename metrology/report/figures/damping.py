"""Decay rate against amplitude: constant for viscous, proportional for quadratic, hyperbolic for dry damping."""

from __future__ import annotations

from metrology.decay import DecayFinding
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import scale
from metrology.message import said
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BLUE, GREY, HALF, INK, MARKERS, ORANGE, Plot

_RATE = Pen(stroke=INK, width=0.6, dash=(2.4, 1.2))


def draw(finding: DecayFinding, title: str, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """Decay rate of every release against amplitude with its u, and the rate of the decrement as a line."""
    plot = Sketch((HALF, 46.0), (14.5, 9.5, 1.5, 3.0), label=label, language=language)
    factor, unit = scale(max((max(r.amplitude, default=0.0) for r in finding.records), default=0.0), finding.unit)
    sizes = [size / factor for record in finding.records for size in record.amplitude]
    plot.window(_seen(sizes), _seen(_heights(finding)))
    for index, record in enumerate(finding.records):
        colour = (BLUE, ORANGE, GREY)[index % 3]
        amplitude = [size / factor for size in record.amplitude]
        plot.errors(amplitude, record.rate, record.rate_u, Pen(stroke=colour, width=0.4))
        plot.dots(amplitude, record.rate, Mark(MARKERS[index % len(MARKERS)], colour, 2.4))
        plot.level(record.decay_rate[0], _RATE)
    plot.x_axis(said("amplitude / {unit}", unit=unit), 6)
    plot.y_axis(said("decay rate / s⁻¹"), 5)
    text = "{title}: decay rate against amplitude for {count} releases. {damping}"
    alt = said(text, title=title, count=len(finding.records), damping=finding.damping)
    return plot.finish(alt, said(_CAPTION))


def _heights(finding: DecayFinding) -> list[float]:
    """Rates to be seen: of the decrement, and of every point; error bars as far as they are no longer than most."""
    found = [record.decay_rate[0] for record in finding.records]
    pairs = [pair for record in finding.records for pair in zip(record.rate, record.rate_u, strict=True)]
    usual = sorted(u for _, u in pairs)[len(pairs) // 2] if pairs else 0.0
    return found + [rate + sign * min(u, 2 * usual) for rate, u in pairs for sign in (1, -1)]


def _seen(values: list[float]) -> tuple[float, float]:
    low, high = min(values, default=0.0), max(values, default=1.0)
    margin = 0.05 * (high - low)
    return low - margin, high + margin


_CAPTION = (
    "Decay rate against amplitude, with standard uncertainties; dashed: the rate of the decrement. "
    "Level points mean viscous damping, points "
    "that rise in proportion to the amplitude quadratic, points that rise towards small amplitudes dry."
)
