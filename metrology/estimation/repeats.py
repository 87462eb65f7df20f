"""Readings at rest of which rounding makes one: how many of them count."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from metrology.estimation.measured import MeasuredRun
from metrology.estimation.noise import estimate, resolution
from metrology.estimation.problem import Array
from metrology.timeseries.white_noise import rounding_bias

REPEATED = 8
"""Readings in a row within one division from which on the rounding of all is one. With noise of 0.4 divisions, which
leaves no bias of rounding (Widrow & Kollár, Quantization Noise, 2008, 4), one in seven stretches at rest is as long;
with 0.3, which leaves a fifth of the noise, half of them are."""
EVEN = 0.5
"""Noise in divisions, rounding included, from which on the mean of readings at rest is off by less than a hundredth of
a division (Widrow & Kollár, 5.4)."""
MOVED = 0.25
"""Part of a division by which two halves of a stretch differ that is no rest: one that passes a division evenly differs
by a whole one."""


def without_repeats(measured: MeasuredRun) -> tuple[MeasuredRun, int]:
    """Return the run with as many readings of each stretch at rest as say what it says, and how many are left out.

    A stretch is of readings within one division. Rounding is the same for all of them: n with noise σ, which rounding
    leaves off by b, say no more than n/(1 + n·b²/σ²), which are taken evenly, whatever they are. Without noise that is
    one, the middle one: the motion was within half a division. So it is for equal readings that are not rounded.

    Parameters
    ----------
    measured : MeasuredRun
        A run.

    Returns
    -------
    tuple of MeasuredRun and int
        The same run and 0 where no stretch has `REPEATED` readings that say less.
    """
    use, count = dict(measured.use), 0
    for channel in measured.channels:
        used = measured.used(channel).copy()
        at, readings = np.flatnonzero(used), measured.readings(channel)
        step, noise = resolution(readings), measured.noise[channel]
        bias = rounding_bias(_noise(readings, noise, step), step) if step > 0 else math.inf
        for first, last in _at_rest(readings[at], step):
            number = last - first
            kept = max(math.ceil(number / (1 + number * (bias / noise) ** 2)), 1)
            used[at[first:last]] = False
            used[at[first + (2 * np.arange(kept) + 1) * number // (2 * kept)]] = True
        count += len(at) - int(used.sum())
        use[channel] = used
    return (replace(measured, use=use), count) if count else (measured, 0)


def _noise(readings: Array, stated: float, step: float) -> float:
    """Noise that evens rounding out: where it is said to do so, no more than the readings show."""
    seen = estimate(readings) if stated > EVEN * step else None
    return stated if seen is None else min(stated, seen.u)


def _at_rest(readings: Array, step: float) -> list[tuple[int, int]]:
    """Begin and end of each stretch of `REPEATED` readings or more that are within one division of one another.

    Where the second half of it lies off the first the motion passes a division, whose rounding is another at each
    reading: there, each stretch of equal ones.
    """
    found = []
    for first, last in _stretches(readings, 1.01 * step):
        middle = (first + last) // 2
        moved = abs(float(readings[middle:last].mean() - readings[first:middle].mean()))
        alike = [(0, last - first)] if moved <= MOVED * step else _stretches(readings[first:last], 0.0)
        found += [(first + a, first + b) for a, b in alike]
    return found


def _stretches(readings: Array, reach: float) -> list[tuple[int, int]]:
    found, first, low, high = [], 0, math.inf, -math.inf
    for at, value in enumerate([*readings.tolist(), math.nan]):
        low, high = min(low, value), max(high, value)
        if not (value <= low + reach and value >= high - reach):
            if at - first >= REPEATED:
                found.append((first, at))
            first, low, high = at, value, value
    return found
