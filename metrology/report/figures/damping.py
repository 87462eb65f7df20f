"""Decay rate against amplitude: constant for viscous, proportional for quadratic, hyperbolic for dry damping."""

from __future__ import annotations

import numpy as np

from metrology.decay import DecayFinding
from metrology.report.display import scale
from metrology.report.figures.style import BLUE, GREY, HALF, INK, MARKERS, ORANGE, Plot, canvas, finish, place


def draw(finding: DecayFinding, title: str, *, label: str = "") -> Plot:
    """Decay rate of every release against amplitude with its u, and the rate of the decrement as a line."""
    figure = canvas(HALF, 50.0, label=label)
    axes = place(figure, (14.5, 9.0, 1.5, 3.0))
    factor, unit = scale(max((max(r.amplitude, default=0.0) for r in finding.records), default=0.0), "m")
    for index, record in enumerate(finding.records):
        colour = (BLUE, ORANGE, GREY)[index % 3]
        axes.errorbar(
            np.array(record.amplitude) / factor,
            record.rate,
            yerr=record.rate_u,
            fmt=MARKERS[index % len(MARKERS)],
            color=colour,
            ms=2.4,
            mew=0.5,
            elinewidth=0.4,
        )
        axes.axhline(record.zeta_decrement * record.omega_decrement, color=INK, lw=0.6, ls=(0, (4, 2)))
    axes.set_xlabel(f"amplitude / {unit}")
    axes.set_ylabel("decay rate / s⁻¹")
    axes.set_ylim(bottom=0.0)
    return finish(
        figure,
        f"{title}: decay rate against amplitude for {len(finding.records)} releases. {finding.damping}",
        _CAPTION,
    )


_CAPTION = (
    "Decay rate against amplitude, with standard uncertainties; dashed: the rate of the decrement. "
    "Level points mean viscous damping, points "
    "that rise in proportion to the amplitude quadratic, points that rise towards small amplitudes dry."
)
