"""A reading that wanders slowly, in each run by itself: drift of a sensor, a step, a hop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from metrology.coordinate import Quantity
from metrology.diagnostics.direction import STRAIGHT, Direction
from metrology.diagnostics.families import hats
from metrology.diagnostics.subject import Array, Fit
from metrology.estimation import MeasuredRun

WANDER = "wander"
"""What such a family is, where others are a force."""
KNOTS = 9
"""Places over the time of a run: the shortest smooth law (`families.SMOOTH`) changes over an eighth of it."""
AMOUNT = 0.1
"""Unit of its amounts, over the noise of one reading."""


def wanders(runs: Sequence[MeasuredRun], fit: Fit, words: Mapping[str, Quantity]) -> list[Direction]:
    """Families of slow errors of the readings, a hat over the time of one run a column.

    A steady error is a start, a taut position or a zero of the cell that is off; a steady drift of the cell is listed:
    `cell drift`. One that is neither, as of an amplifier by the temperature of the room, was taken for a curve of the
    tension, by which k was 8 u off.
    """
    found = []
    for channel in ("x", "v", "T"):
        if not all(channel in run.channels for run in runs):
            continue
        names = {f"{channel} {at}@{knot}": float(knot) for at in range(len(runs)) for knot in range(KNOTS)}
        rows = tuple(_rows(run, fit, (at, len(runs)), channel) for at, run in enumerate(runs))
        amount = AMOUNT * float(np.mean([run.noise[channel] for run in runs]))
        family = f"{WANDER} of {words[channel].word}"
        found.append(Direction(family, names, amount, rows, ways=tuple(names), listed=STRAIGHT))
    return found


def _rows(run: MeasuredRun, fit: Fit, place: tuple[int, int], channel: str) -> Array:
    """Columns of one run, zero for those of the others."""
    at, many = place
    rows = np.zeros((len(fit.residuals[at]), many * KNOTS))
    segment = next(one for one in fit.problem.blocks[at].segments if one.name == channel)
    t = run.stamps(channel)
    knots = np.linspace(t[0], t[-1], KNOTS)
    own = fit.used[at][segment.first : segment.last]
    rows[segment.first : segment.last, at * KNOTS : (at + 1) * KNOTS] = -AMOUNT * hats(t, knots) * own[:, None]
    return rows
