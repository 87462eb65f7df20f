"""Stiffness of every loading of a record that goes up and down, by mean load and amplitude."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from metrology.tension.finding import Loading
from metrology.tension.lines import Lines
from metrology.tension.slope import LEAST, slope

SWING = 0.1
"""Part of the largest force by which the force turns, so that it counts: less is noise, or a hold."""
FINE = 2000
"""Means of a record in which its turns are sought."""


def loadings(one: Lines) -> tuple[Loading, ...]:
    """Each loading of a specimen from a valley to a peak; none of a record with one loading.

    What goes beyond the highest force so far is a first loading, what stays below it a repeated one: a line that
    remembers its highest tension has two stiffnesses there.
    """
    ends = list(_turns(one.mounting.force))
    if len(ends) < 2:
        return ()
    return tuple(row for number, (first, last, highest) in enumerate(ends, start=1)
                 for row in _rows(one, number, (first, last), highest))  # fmt: skip


def _turns(force: np.ndarray) -> Iterator[tuple[int, int, float]]:
    """First and last reading of each rise by `SWING` or more, and the highest force before it."""
    each = -(-len(force) // FINE)
    means = force[: len(force) // each * each].reshape(-1, each).mean(axis=1)
    least, highest = SWING * float(means.max()), 0.0
    valley = peak = 0
    for at in range(1, len(means) + 1):
        value = float(means[at]) if at < len(means) else -np.inf
        has_turned = means[peak] - value >= least or at == len(means)
        if value > means[peak]:
            peak = at
        elif has_turned and means[peak] - means[valley] >= least:
            yield valley * each, (peak + 1) * each, highest
            highest = max(highest, float(means[peak]))
            valley = peak = at
        elif value < means[valley]:
            valley = peak = at


def _rows(one: Lines, number: int, ends: tuple[int, int], highest: float) -> Iterator[Loading]:
    """The part below the highest force so far, and the part beyond it."""
    mounting = one.mounting
    part = slice(*ends)
    force, reading = mounting.force[part], (mounting.strain if one.strain is not None else mounting.crosshead)
    assert reading is not None
    time = mounting.time[part] if mounting.time is not None else None
    over = np.flatnonzero(force > highest)
    split = int(over[0]) if len(over) else len(force)
    for first, rows in ((False, slice(0, split)), (True, slice(split, len(force)))):
        F, y = force[rows], reading[part][rows]
        if len(F) < LEAST or np.ptp(F) < SWING * float(mounting.force.max()) or not np.isfinite(y).all():
            continue
        line = slope(F, y)
        low, high = float(F[0]), float(F[-1])
        stiff = 1 / line.value
        yield Loading(
            mounting.name, number, first, (low + high) / 2, (high - low) / 2, highest or None,
            None if time is None else float(np.ptp(time[rows])), stiff, stiff**2 * line.u,
        )  # fmt: skip
