"""Decay rate against amplitude: constant for viscous, proportional for quadratic, hyperbolic for dry damping."""

from __future__ import annotations

from metrology.decay import DecayFinding
from metrology.report.display import scale
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Mark, Sketch
from metrology.report.figures.style import BLUE, GREY, HALF, INK, MARKERS, ORANGE, Plot

_RATE = Pen(stroke=INK, width=0.6, dash=(2.4, 1.2))


def draw(finding: DecayFinding, title: str, *, label: str = "") -> Plot:
    """Decay rate of every release against amplitude with its u, and the rate of the decrement as a line."""
    plot = Sketch((HALF, 50.0), (14.5, 9.0, 1.5, 3.0), label=label)
    factor, unit = scale(max((max(r.amplitude, default=0.0) for r in finding.records), default=0.0), "m")
    sizes = [size / factor for record in finding.records for size in record.amplitude]
    tops = [r + u for record in finding.records for r, u in zip(record.rate, record.rate_u, strict=True)]
    middle = max((record.zeta_decrement * record.omega_decrement for record in finding.records), default=1.0)
    plot.window((0.0, 1.04 * max(sizes, default=1.0)), (0.0, 1.05 * min(max([middle, *tops]), 2.5 * middle)))
    for index, record in enumerate(finding.records):
        colour = (BLUE, ORANGE, GREY)[index % 3]
        amplitude = [size / factor for size in record.amplitude]
        plot.errors(amplitude, record.rate, record.rate_u, Pen(stroke=colour, width=0.4))
        plot.dots(amplitude, record.rate, Mark(MARKERS[index % len(MARKERS)], colour, 2.4))
        plot.level(record.zeta_decrement * record.omega_decrement, _RATE)
    plot.x_axis(f"amplitude / {unit}", 6)
    plot.y_axis("decay rate / s⁻¹", 5)
    alt = f"{title}: decay rate against amplitude for {len(finding.records)} releases. {finding.damping}"
    return plot.finish(alt, _CAPTION)


_CAPTION = (
    "Decay rate against amplitude, with standard uncertainties; dashed: the rate of the decrement. "
    "Level points mean viscous damping, points "
    "that rise in proportion to the amplitude quadratic, points that rise towards small amplitudes dry."
)
