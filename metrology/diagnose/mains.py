"""Mains that no record shows by itself: one line of all records together, each with its own phase."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from metrology.decay.separation import Separated
from metrology.diagnose.subject import Array
from metrology.timeseries import on_grid

WIDTH = 0.5
"""Hz about a multiple of the mains frequency, or as far as a short record cannot tell."""
ASIDE = 8.0
"""Hz beside it that tell the level of the noise."""
HARMONICS = 5
"""Multiples of the decay's own frequency at which a bent restoring force makes lines of its own."""
FINER = 3.0
"""Looks for each frequency that a record can tell apart: the largest of a fine grid counts."""
MULTIPLES = 4
"""Multiples of the mains frequency that are looked at."""


def shared(records: Sequence[Separated], mains: float, false_alarm: float) -> tuple[float, float] | None:
    """Frequency / Hz and amplitude / m of a line at the mains in what all fits leave; None where there is none.

    The powers of n records at one frequency over that of the noise beside it, summed, are χ² with 2n degrees of
    freedom; the look among many frequencies counts. The phase of the mains is another in each record.
    """
    from scipy.special import gammaincc

    longest, rate = max(float(one.t[-1]) for one in records), min(1 / one.free.step for one in records)
    width, step = max(WIDTH, 1.5 / longest), 0.25 / longest
    aside = 2 * width + max(ASIDE, 8 / longest)
    own = [part * one.fit.main.frequency for one in records for part in range(1, HARMONICS + 1)]
    # Not where a short record cannot tell the mains from anything, nor beside what a bent spring makes by itself.
    orders = [
        order
        for order in range(1, MULTIPLES + 1)
        if width < 0.25 * mains
        and order * mains + aside < 0.5 * rate
        and all(abs(order * mains - line) > 2 * width for line in own)
    ]
    spectra = [_spectrum(one) for one in records]
    best, least = None, false_alarm
    for order in orders:
        near = order * mains + np.arange(-width, width + step, step)
        ratio, size = np.zeros(len(near)), np.zeros(len(near))
        for one, (grid, power) in zip(records, spectra, strict=True):
            away = np.abs(grid - order * mains)
            # Beside it a short record has too few frequencies to tell the noise alone.
            level = max(float(power[(away > 2 * width) & (away < aside)].mean()), one.noise**2)
            seen = np.interp(near, grid, power)
            ratio += 2 * seen / max(level, 1e-300)
            size += 4 * np.maximum(seen - level, 0.0) / len(one.t) / len(records)
        at = int(np.argmax(ratio))
        looks = len(orders) * FINER * max(2 * width * longest, 1.0)
        p = looks * float(gammaincc(len(records), ratio[at] / 2))
        if p < least:
            best, least = (float(near[at]), math.sqrt(float(size[at]))), p
    return best


def _spectrum(one: Separated) -> tuple[Array, Array]:
    """Frequencies / Hz, and |Σ r·e^{−iωt}|²/n of what the fit of a record leaves: the variance, for white noise."""
    count, even = len(one.fit.residual), on_grid(one.t, one.fit.residual, one.free.step)
    size = 4 * 2 ** math.ceil(math.log2(len(even)))
    power: Array = np.abs(np.fft.rfft(even, size)) ** 2 / count
    grid = np.asarray(np.fft.rfftfreq(size, one.free.step), dtype=np.float64)
    return grid, power
