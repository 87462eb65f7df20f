"""A dial whose error repeats itself with every turn of the pointer."""

import math
from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size, choice

TURNS = (1e-3, 0.5e-3, 0.2e-3, 0.1e-3)
"""Measuring spindle's way for a turn of the pointer / m: of dials that show 10, 5, 2 or 1 µm."""
PHASES = 4
"""Phases that are tried over half a turn; beyond it the error has the other sign."""


def reading(seen: Readings, phase: float, which: float):
    """sin(2π·y/p + φ), y the reading."""
    return np.sin(2 * math.pi * seen.value / TURNS[round(which)] + phase)


def turns(seen: Readings) -> list[int]:
    """Turns that the readings can show: one at least within their range, and two loads at least in each.

    Of a shorter one, readings at a few loads show another, slower error (aliasing); a longer one does not repeat.
    """
    middles = np.sort([np.mean(seen.value[seen.force == force]) for force in np.unique(seen.force)])
    return [at for at, turn in enumerate(TURNS) if 2 * np.diff(middles).max() <= turn <= np.ptp(middles)]


def shapes(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """Every such turn in some phases."""
    return [
        {"periodic.phase": math.pi * at / PHASES, "periodic.turn": float(which)}
        for which in turns(seen) for at in range(PHASES)
    ]  # fmt: skip


EFFECT = Effect(
    name="periodic",
    title="Periodic error of the dial",
    equation="y = … + a·sin(2π·y/p + φ), p a turn of the pointer",
    sign="residuals go up and down with the reading, once with every turn of the pointer, in every repeat",
    source="ISO 463:2006, mechanical dial gauges: errors of indication within a revolution",
    acts="reading",
    causes=(
        Cause(
            "elongation", "periodic",
            (
                Size("periodic.amplitude", "m", 0.0, -INF, INF, 1e-6),
                # Half a turn beyond those tried to either side: a phase at the end of its range would be no phase.
                Size("periodic.phase", "rad", 0.0, -math.pi, 2 * math.pi, 0.1, True, apart=6),
                choice("periodic.turn", len(TURNS)),
            ),
            consequence="k and E are off by the amplitude over the range of extension at most",
            advice="calibrate the dial within a turn, and give its correction; extend the sample by whole turns",
            separate="gauge blocks in steps of a tenth of a turn; the same loads with the dial set back by half a turn",
            pictures=("load",), needs=("turns",), amount=lambda seen: seen.u, shapes=shapes, reading=reading,
        ),
    ),
)  # fmt: skip
