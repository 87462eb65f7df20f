"""Normal distributions of what lies between bounds, such as a size that is not negative."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import log_ndtr

from metrology.diagnostics.subject import Array

FAR = 6.0
"""Standard deviations within which a bound matters: the part beyond it, 1e-9, moves no digit that is printed."""
NARROW = 1e-4
"""Width, over the standard deviation, of what is as good as uniform: the formula would lose its digits below."""
OUTSIDE = 100.0
"""Standard deviations from which on a mean outside counts as no farther: what is inside keeps its digits."""
SWEEPS = 100
CLOSE = 1e-6


@dataclass(frozen=True)
class Within:
    """What bounds add to a normal distribution: as a normal of each variable by itself (a site of the propagation).

    `precision`, `shift`: shape (p,), 1/variance and mean/variance of each; 0 where no bound matters.
    """

    precision: Array
    shift: Array

    def gain(self, covariance: Array) -> Array:
        """Return (1 + Σ·τ)⁻¹: what a change without the bounds, shape (p,), is with them."""
        return np.asarray(np.linalg.inv(np.eye(len(covariance)) + covariance * self.precision))


def within(mean: Array, covariance: Array, low: Array, high: Array) -> Within:
    """Normal distribution with the mean and covariance of another one between bounds.

    Of one variable it is exact. Of several, each is cut in turn and the others follow by their correlation, until
    nothing changes (expectation propagation: Minka, Proc. Uncertainty in Artificial Intelligence 17 (2001) 362).

    Parameters
    ----------
    mean, low, high : ndarray, shape (p,)
        Bounds may be infinite.
    covariance : ndarray, shape (p, p)
        A variable without variance is left as it is.

    Returns
    -------
    Within
        Without effect where no bound is near.
    """
    sites = Within(np.zeros(len(mean)), np.zeros(len(mean)))
    u = np.sqrt(np.diag(covariance))
    near = np.flatnonzero((u > 0) & ((mean - low < FAR * u) | (high - mean < FAR * u))).tolist()
    here, spread = mean, covariance
    for _ in range(SWEEPS if len(near) else 0):
        before = np.diag(spread)[near]
        for at in near:
            sites = _cut(sites, at, (here[at], spread[at, at]), (low[at], high[at]))
            gain = sites.gain(covariance)
            spread = gain @ covariance
            here = mean + spread @ (sites.shift - sites.precision * mean)
        if np.all(np.abs(np.diag(spread)[near] - before) <= CLOSE * before):
            break
    return sites


def _cut(sites: Within, at: int, now: tuple[float, float], bounds: tuple[float, float]) -> Within:
    """Replace what the bounds of one variable add, beside what those of the others do."""
    mean, variance = now
    precision = 1.0 / variance - sites.precision[at]
    if precision <= 0:
        return sites
    centre, alone = (mean / variance - sites.shift[at]) / precision, 1.0 / precision
    inside, left = truncated(centre, alone, *bounds)
    precisions, shifts = sites.precision.copy(), sites.shift.copy()
    precisions[at] = max(1.0 / left - precision, 0.0)
    shifts[at] = inside / left - centre * precision
    return replace(sites, precision=precisions, shift=shifts)


def truncated(mean: float, variance: float, low: float, high: float) -> tuple[float, float]:
    """Mean and variance of a normal variable between two bounds (Johnson, Kotz & Balakrishnan 1994, 13.10.1)."""
    size = math.sqrt(variance)
    a, b = (low - mean) / size, (high - mean) / size
    if b - a < NARROW:
        return 0.5 * (low + high), (high - low) ** 2 / 12.0
    if b < -OUTSIDE * (1.0 + 1e-9):
        return truncated(high + OUTSIDE * size, variance, low, high)
    if a > 0:  # where the logarithm of the part has its digits
        inside, left = truncated(-mean, variance, -high, -low)
        return -inside, left
    part = float(log_ndtr(b)) + math.log1p(-math.exp(float(log_ndtr(a) - log_ndtr(b))))
    at_a, at_b = (math.exp(-0.5 * z * z - part) / math.sqrt(2.0 * math.pi) if math.isfinite(z) else 0.0 for z in (a, b))
    ends = (a * at_a if at_a else 0.0) - (b * at_b if at_b else 0.0)
    return mean + size * (at_a - at_b), variance * (1.0 + ends - (at_a - at_b) ** 2)
