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
        seen = estimate(readings)
        bias = rounding_bias(min(noise, seen.u) if seen else noise, step) if step > 0 else math.inf
        for first, last in _at_rest(readings[at], step):
            number = last - first
            kept = max(math.ceil(number / (1 + number * (bias / noise) ** 2)), 1)
            used[at[first:last]] = False
            used[at[first + (2 * np.arange(kept) + 1) * number // (2 * kept)]] = True
        count += len(at) - int(used.sum())
        use[channel] = used
    return (replace(measured, use=use), count) if count else (measured, 0)


def _at_rest(readings: Array, step: float) -> list[tuple[int, int]]:
    """Begin and end of each stretch of `REPEATED` readings or more that are within one division of one another."""
    found, first, low, high = [], 0, math.inf, -math.inf
    for at, value in enumerate([*readings.tolist(), math.nan]):
        low, high = min(low, value), max(high, value)
        if not (value <= low + 1.01 * step and value >= high - 1.01 * step):
            if at - first >= REPEATED:
                found.append((first, at))
            first, low, high = at, value, value
    return found
