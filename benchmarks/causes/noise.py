"""Noise of a channel: white, coloured, narrow-band, quantised, heavy-tailed; spikes and gaps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

Rng = np.random.Generator
WARM = 400
"""Readings before the first one, so that a filter has forgotten its start."""


def white(count: int, rng: Rng) -> np.ndarray:
    """Independent and normal."""
    return rng.standard_normal(count)


def ar1(count: int, rng: Rng) -> np.ndarray:
    """n_i = φ·n_{i−1} + √(1 − φ²)·w_i, φ from 0.1 to 0.5."""
    phi = rng.uniform(0.1, 0.5)
    return lfilter([np.sqrt(1 - phi**2)], [1, -phi], rng.standard_normal(count + WARM))[WARM:]


def narrow(count: int, rng: Rng) -> np.ndarray:
    """Four tenths of the variance in a band of about a hundredth of the rate, the rest white."""
    angle, pole = rng.uniform(0.6, 2.6), 0.97
    w = rng.standard_normal(count + WARM)
    band = lfilter([1.0], [1, -2 * pole * np.cos(angle), pole**2], w)[WARM:]
    # Variance of this filter for white input of variance 1 (Box, Jenkins & Reinsel, Time Series Analysis, 3.2.4).
    a, b = 2 * pole * np.cos(angle), -(pole**2)
    variance = (1 - b) / ((1 + b) * ((1 - b) ** 2 - a**2))
    return np.sqrt(0.4 / variance) * band + np.sqrt(0.6) * rng.standard_normal(count)


def heavy(count: int, rng: Rng) -> np.ndarray:
    """Student's t of 3 to 5 degrees of freedom, scaled to a standard deviation of 1."""
    dof = rng.uniform(3, 5)
    return rng.standard_t(dof, count) * np.sqrt((dof - 2) / dof)


KINDS: dict[str, Callable[[int, Rng], np.ndarray]] = {
    "white": white,
    "ar1": ar1,
    "narrow": narrow,
    "heavy": heavy,
    "dithered": white,
    "bare": white,
}
STEP = {"dithered": 1.2, "bare": 5.0}
"""Step of a quantised channel over the standard deviation of what is quantised."""


@dataclass(frozen=True)
class Sensor:
    """What one channel does to what it measures; `sigma` and `digit` in the unit of the channel."""

    kind: str
    sigma: float
    digit: float
    spikes: int = 0
    gaps: int = 0

    @property
    def step(self) -> float:
        """Step of the readings."""
        return max(self.digit, STEP.get(self.kind, 0.0) * self.sigma)

    @property
    def u(self) -> float:
        """Standard deviation of noise and rounding together."""
        return float(np.hypot(self.sigma, self.step / np.sqrt(12)))

    def read(self, true: np.ndarray, rng: Rng) -> np.ndarray:
        """Readings, NaN where there is none."""
        found = true + self.sigma * KINDS[self.kind](len(true), rng)
        for _ in range(self.spikes):
            found[rng.integers(len(true))] += rng.choice([-1, 1]) * rng.uniform(20, 60) * self.u
        found = np.round(found / self.step) * self.step
        for _ in range(self.gaps):
            first = int(rng.integers(0.2 * len(true), 0.9 * len(true)))
            found[first : first + int(rng.integers(4, 30))] = np.nan
        return found
