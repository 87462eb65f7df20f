"""How far a simulated channel is from a measured one: each metric sees another thing, and none decides alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rms(measured: Array, simulated: Array) -> float:
    """Root mean square of S − D, in the unit of the channel."""
    return float(np.sqrt(np.mean((simulated - measured) ** 2)))


def r_squared(measured: Array, simulated: Array) -> float:
    """Coefficient of determination 1 − Σ(S − D)²/Σ(D − D̄)²; NaN for readings that do not vary."""
    spread = float(np.sum((measured - measured.mean()) ** 2))
    return 1.0 - float(np.sum((simulated - measured) ** 2)) / spread if spread > 0 else math.nan


def peak_error(measured: Array, simulated: Array) -> float:
    """Largest |S| over largest |D|, minus 1; NaN for readings that are all zero."""
    peak = float(np.abs(measured).max())
    return float(np.abs(simulated).max()) / peak - 1.0 if peak > 0 else math.nan


def magnitude(measured: Array, simulated: Array) -> float:
    """Sprague–Geers magnitude M = √(ΣS²/ΣD²) − 1: positive where the model is too large, whatever its phase.

    Sprague & Geers, Int. J. Numer. Meth. Engng 60 (2004) 2467.

    Examples
    --------
    >>> magnitude(np.array([1.0, -1.0]), np.array([-1.1, 1.1]))
    0.10000000000000009
    """
    energy = float(measured @ measured)
    return math.sqrt(float(simulated @ simulated) / energy) - 1.0 if energy > 0 else math.nan


def phase_error(measured: Array, simulated: Array) -> float:
    """Sprague–Geers phase P = arccos(ΣSD/√(ΣS²·ΣD²))/π: 0 in phase, 1 in antiphase, whatever the magnitude."""
    sizes = math.sqrt(float(measured @ measured)), math.sqrt(float(simulated @ simulated))
    if min(sizes) <= 0:
        return math.nan
    a, b = measured / sizes[0], simulated / sizes[1]
    # By the chord: of an angle that is nearly zero, its cosine keeps half of the digits.
    return 2 * math.atan2(float(np.linalg.norm(a - b)), float(np.linalg.norm(a + b))) / math.pi


def combined(measured: Array, simulated: Array) -> float:
    """Sprague–Geers combined error C = √(M² + P²)."""
    return math.hypot(magnitude(measured, simulated), phase_error(measured, simulated))


METRICS: dict[str, Callable[[Array, Array], float]] = {
    "rms": rms,
    "r_squared": r_squared,
    "peak_error": peak_error,
    "magnitude": magnitude,
    "phase": phase_error,
    "combined": combined,
}
"""Every metric by its name in the results."""


GROWTH = 50.0
"""Logarithm of the largest growth of a swing over its record that is computed: e⁵⁰ has no reading beside its end."""
FINISHING = 30
"""Steps at most that carry the fit of a swing to its last digit; each is a tenth of the last, or less."""


@dataclass(frozen=True)
class Ringing:
    """Frequency / (rad/s) and decay rate / (1/s) of a taut line's swing, each with its standard uncertainty."""

    omega: float
    omega_u: float
    rate: float
    rate_u: float


def ringing(t: Array, y: Array, omega: float) -> Ringing | None:
    """Swing of a channel over one taut stretch, y = a + e^(−λt)·(b·cos ωt + d·sin ωt); None where it shows none.

    Separable least squares (Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413): a, b, d follow from λ and ω.

    Parameters
    ----------
    t, y : ndarray, shape (n,)
        Times / s and readings.
    omega : float
        Where to look first, rad/s.
    """
    from scipy.optimize import least_squares

    if len(t) < 20 or t[-1] - t[0] < 1.5 * 2 * math.pi / omega or not np.ptp(y) > 0:
        return None
    s = t - t[0]

    def basis(rate: float, omega: float) -> Array:
        # A search that runs away to growing swings stays finite, and its fit is no better than none.
        swing = np.exp(np.minimum(-rate * s, GROWTH))
        return np.column_stack([np.ones_like(s), swing * np.cos(omega * s), swing * np.sin(omega * s)])

    def alone(values: Array) -> Array:
        columns = basis(*values)
        found: Array = columns @ np.linalg.lstsq(columns, y, rcond=None)[0] - y
        return found

    def together(values: Array) -> Array:
        return np.asarray(basis(*values[:2]) @ values[2:] - y)

    def slopes(values: Array) -> Array:
        columns, (_, b, d) = basis(*values[:2]), values[2:]
        _, cosine, sine = columns.T
        return np.column_stack([-s * (b * cosine + d * sine), s * (d * cosine - b * sine), columns])

    start = [0.05 * omega, omega]
    found = least_squares(alone, start, "3-point", x_scale=start, xtol=1e-9, ftol=None, gtol=None)
    values = np.array([*found.x, *np.linalg.lstsq(basis(*found.x), y, rcond=None)[0]])
    # Steps of Gauss and Newton by exact derivatives end at the last digit, the same on every processor.
    before = math.inf
    for _ in range(FINISHING):
        tangent = slopes(values)
        if not np.isfinite(tangent).all():
            return None
        step = np.linalg.lstsq(tangent, -together(values), rcond=None)[0]
        length = float(np.linalg.norm(tangent @ step))
        if not length < before:
            break
        values, before = values + step, length
    variance = float(np.sum(together(values) ** 2)) / (len(t) - 5)
    runaway = -values[0] * s[-1] >= GROWTH
    if not found.success or runaway or values[1] <= 0 or variance > 0.5 * float(np.var(y)):
        return None
    spread = np.linalg.norm(np.linalg.pinv(slopes(values)), axis=1) * math.sqrt(variance)
    return Ringing(float(values[1]), float(spread[1]), float(values[0]), float(spread[0]))
