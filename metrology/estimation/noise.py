"""Noise of a channel from its own readings: what differs from one sample to the next faster than the motion can."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from metrology.estimation.problem import Array

ORDERS = (3, 4, 5, 6, 7)
"""Orders of difference that are tried; the smallest estimate is taken, since motion can only add to it."""
ENOUGH = 30
"""Readings below which no estimate is made."""
QUANTILES = (0.4, 0.5, 0.6, 0.7)
HALF_NORMAL = (0.5244005127, 0.6744897502, 0.8416212336, 1.0364333895)
"""Quantiles of the absolute value of a standard normal variable at `QUANTILES`."""
GOLDEN = 0.6180339887498949


@dataclass(frozen=True)
class Noise:
    """Standard uncertainty of one reading: `u`, and how it was found."""

    u: float
    sentence: str


def estimate(readings: Array) -> Noise | None:
    """Noise of equally spaced readings, NaN where there is none; None where too few are left.

    s = (quantile of |Δⁿy|) / (the same of a normal variable) / √C(2n, n), averaged over four middle quantiles, at the
    lowest n = 3 … 7 that comes within 5 % of the smallest: the n-th difference removes any motion that is a polynomial
    of degree n − 1 over n + 1 samples, and middle quantiles ignore snatches and outliers (Gasser, Sroka &
    Jennen-Steinmetz, Biometrika 73 (1986) 625; Hampel, JASA 69 (1974) 383). Never below the rounding of the readings,
    q/√12 (JCGM 100, F.2.2.1).

    Parameters
    ----------
    readings : ndarray, shape (n,)
        In the unit of the channel.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> t = np.arange(4000) / 200
    >>> found = estimate(3.0 * np.sin(30.0 * t) + 0.02 * rng.standard_normal(4000))
    >>> round(found.u, 3)
    0.021
    """
    if int(np.isfinite(readings).sum()) < ENOUGH:
        return None
    step = resolution(readings)
    found = [value for order in ORDERS if (value := _difference_noise(readings, order, step)) is not None]
    if not found:
        return None
    floor = step / math.sqrt(12)
    # The lowest order that agrees with the best one wastes the fewest readings.
    noise = next(value for value in found if value <= 1.05 * min(found))
    if noise < floor:
        return Noise(floor, f"rounding to {step:.3g} hides the noise: u = step/√12 = {floor:.3g}")
    return Noise(noise, f"from differences of neighbouring readings: u = {noise:.3g}")


def _difference_noise(readings: Array, order: int, step: float) -> float | None:
    differences = np.diff(readings, order)
    differences = differences[np.isfinite(differences)]
    if differences.size < ENOUGH // 2:
        return None
    # Rounded readings give rounded differences: spread them over the step, evenly, before quantiles are taken.
    spread = np.abs(differences + step * (np.arange(differences.size) * GOLDEN % 1.0 - 0.5))
    return float(np.mean(np.quantile(spread, QUANTILES) / HALF_NORMAL)) / math.sqrt(math.comb(2 * order, order))


def resolution(readings: Array) -> float:
    """Step to which readings were rounded, 0 where none shows."""
    distinct = np.unique(readings[np.isfinite(readings)])
    if len(distinct) < 2:
        return 0.0
    gaps = np.diff(distinct)
    step = float(gaps[gaps > 1e-9 * max(float(np.abs(distinct).max()), 1e-300)].min(initial=math.inf))
    if not math.isfinite(step):
        return 0.0
    multiples = gaps / step
    on_grid = np.abs(multiples - np.round(multiples)) < 0.02
    return step if on_grid.mean() > 0.98 and len(distinct) < 0.9 * np.isfinite(readings).sum() else 0.0
