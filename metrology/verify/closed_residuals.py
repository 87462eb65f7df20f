"""Residuals of a run with its own inputs re-estimated, over their noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from metrology.estimation import MeasuredRun, beside_contact
from metrology.noise import colour, outlying
from metrology.verify.judge import FEWEST, excess
from metrology.verify.prediction import Prediction

Array = NDArray[np.float64]

PARTS = 16
"""Parts of a run over whose median the size of the noise is taken."""


@dataclass(frozen=True)
class Closed:
    """Residuals of one channel with the run's own inputs re-estimated, over the noise; the same white; which count.

    `alike`: sum of the squares of their autocorrelation over all lags.
    """

    residuals: Array
    white: Array
    used: NDArray[np.bool_]
    alike: float

    def within(self, inside: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Both of them in a part of the run."""
        kept = inside & self.used
        return self.residuals[kept], self.white[kept]


def closed_residuals(measured: MeasuredRun, behind: Prediction, name: str) -> Closed:
    """Residuals without single readings far off, over their noise, and white: what noise does is no misfit.

    The noise may be more than what is stated, or than neighbouring readings, which are alike in it, let see: it is that
    of its colour of short memory (`noise.colour`), which systematic residuals hardly change, and that of most parts of
    the run, which systematic residuals at a contact do not change.
    """
    used = measured.used(name)
    if name == "T":
        used = used & ~beside_contact(measured, behind.motion, clock=behind.rig.value("clock.T"))
    off = (measured.readings(name) - getattr(behind.motion, name)) / measured.noise[name]
    residuals = np.where(used, np.nan_to_num(off), 0.0)
    used = used & ~outlying(residuals)
    residuals = np.where(used, residuals, 0.0)
    noise = colour([residuals])
    size = max(1.0, noise.deviation, _typical(residuals[used]))
    return Closed(residuals / size, noise.whitened(residuals), used, _alike(residuals))


def _typical(residuals: Array) -> float:
    """Standard deviation of most parts of a run."""
    length = len(residuals) // PARTS
    if length < FEWEST:
        return 0.0
    parts = residuals[: length * PARTS].reshape(PARTS, length)
    # The median of χ²(ν)/ν is (1 − 2/(9·ν))³ (Wilson & Hilferty, PNAS 17 (1931) 684).
    return math.sqrt(float(np.median(np.mean(parts**2, axis=1))) / (1.0 - 2.0 / (9.0 * length)) ** 3)


def _alike(residuals: Array) -> float:
    """Sum of the squares of the autocorrelation over all lags (Parseval); a periodogram scatters as χ²(2)."""
    power = np.abs(np.fft.rfft(residuals)[1:]) ** 2
    return max(1.0, 0.5 * float(np.mean(power**2)) / max(float(np.mean(power)) ** 2, 1e-300))


def slow_part(residuals: Array, white: Array) -> float:
    """Slow part of residuals: what neither white noise does nor that of their colour, which one run tells roughly."""
    return min(excess(residuals), excess(white))
