"""Decay rate and frequency of a free decay against its amplitude, and the forces that they suggest."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from metrology.diagnose.subject import Array

LEAST = 4
"""Windows of a record, a quarter of a period apart, that its decay rate is told from."""
STEPS = 10
"""Points that a record gives at most: slopes over so many parts of it."""
FAINT = 10.0
"""Amplitude over its u below which a window is noise."""


def rates(t: Array, y: Array, u: Array, omega: float) -> Array:
    """Return rows of amplitude, decay rate, its u, frequency, its u: slopes of ln|z| and arg z over parts of a record.

    z is y·e^{−iωt} averaged with a Hann window over two periods, every quarter of a period.
    """
    step = float(np.median(np.diff(t)))
    hop = max(1, round(math.pi / 2 / omega / step))
    window = np.hanning(8 * hop + 1)
    window = 2 * window / window.sum()
    if len(y) < 2 * len(window):
        return np.empty((0, 5))
    z = np.convolve((y - y.mean()) * np.exp(-1j * omega * t), window, mode="valid")[::hop]
    at = t[4 * hop :: hop][: len(z)]
    sigma = float(np.median(u))
    faint = np.abs(z) < FAINT * sigma * math.sqrt(float(np.sum(window**2)) / 2)
    last = int(np.argmax(faint)) if faint.any() else len(z)
    log, turn = np.log(np.abs(z)), np.unwrap(np.angle(z))
    rows = []
    for part in np.array_split(np.arange(last), min(STEPS, last // LEAST)) if last >= LEAST else []:
        own = at[part] - at[part].mean()
        own = own / float(own @ own)
        # The slope is linear in the noise of the readings: its weights are the windows, summed.
        spread = np.zeros((len(part) - 1) * hop + 1, dtype=complex)
        spread[::hop] = own / z[part]
        weights = np.convolve(spread, window) * np.exp(-1j * omega * step * np.arange(len(spread) + 8 * hop))
        u_slope = sigma * math.sqrt(float(np.sum(np.abs(weights) ** 2)) / 2)
        slopes = [float(own @ column[part]) for column in (log, turn)]
        frequency = (omega + slopes[1]) / (2 * math.pi)
        rows.append((float(np.abs(z[part]).mean()), -slopes[0], u_slope, frequency, u_slope / (2 * math.pi)))
    return np.array(rows) if rows else np.empty((0, 5))


def suggested(rows: Array, mass: float, effects: Sequence[str]) -> dict[str, float]:
    """Stiffness, damping and the sizes of effects, fitted to rates and frequencies by least squares.

    Harmonic balance (Nayfeh & Mook, Nonlinear Oscillations, 1979, ch. 2 and 3): ω² = (k + 3·k₃·A²/4)/m, and a rate of
    (c + 4·F_c/(π·ω·A) + 8·b₂·ω·A/(3π) + 4·c₁·A/(3π))/(2m).

    Parameters
    ----------
    rows : ndarray, shape (n, 5)
        From `rates`.
    mass : float
        kg.
    effects : sequence of str
        Those of the model; others than the four are passed over.

    Returns
    -------
    dict
        By name of parameter; empty where the rows are too few.
    """
    A, w = rows[:, 0], 2 * math.pi * rows[:, 3]
    columns = {
        "friction": ("friction.force", 4 / (math.pi * w * A)),
        "quadratic drag": ("drag.quadratic", 8 * w * A / (3 * math.pi)),
        "damping": ("damping.amplitude", 4 * A / (3 * math.pi)),
    }
    slowing = [columns[name] for name in effects if name in columns]
    bending = [("cubic.stiffness", 0.75 * A**2)] if "cubic" in effects else []
    if len(rows) < 2 + max(len(slowing), len(bending)):
        return {}
    return {**_fitted("c", 2 * mass * rows[:, 1], slowing), **_fitted("k", mass * w**2, bending)}


def _fitted(name: str, y: Array, columns: Sequence[tuple[str, Array]]) -> dict[str, float]:
    """Coefficients of a constant and some columns."""
    table = np.column_stack([np.ones(len(y)), *(column for _, column in columns)])
    size = np.linalg.norm(table, axis=0)
    found = np.linalg.lstsq(table / size, y, rcond=None)[0] / size
    return dict(zip((name, *(one for one, _ in columns)), found.tolist(), strict=True))
