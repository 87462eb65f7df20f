"""The readings in use with the fit to them, as every check takes them, and the line of each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from metrology.check import Check
from metrology.elongation.line import Floats, Layout, Means, slope
from metrology.elongation.test import Reading
from metrology.message import said


@dataclass(frozen=True)
class Evidence:
    """The readings in use with the fit to them, as every check takes them.

    Parameters
    ----------
    readings : tuple of Reading
        Those in use.
    values : ndarray, shape (n,)
        Corrected readings in m.
    layout : Layout
        Load and repeat of each.
    forces : ndarray, shape (L,)
        Force of each load in N.
    means : Means
        Fit of the means.
    declared : ndarray, shape (L,)
        Standard uncertainty in m of the mean at each load that is not repeatability: resolution, indicator, mass.
    significance : float
        Rate at which each check may fail on data with nothing wrong in them.
    resolution : float
        Smallest difference in m that the indicator shows, as stated.
    """

    readings: tuple[Reading, ...]
    values: Floats
    layout: Layout
    forces: Floats
    means: Means
    declared: Floats
    significance: float
    resolution: float

    @property
    def s(self) -> float:
        """Scatter of one reading, in m."""
        return sqrt(self.means.variance)

    @property
    def floor(self) -> float:
        """Scatter in m below which readings count as all the same."""
        return 1e-12 * float(np.abs(self.values).max() + 1e-6)

    def plain(self) -> Floats:
        """Columns of the model that the scatter is about with one zero for all: one mean a load, or the line."""
        if self.means.about_line:
            return self.layout.straight_columns(self.forces, zero_each=False)
        return self.layout.level_columns()


def untested(name: str, reason: str) -> Check:
    """Check that these readings cannot be put to, and why."""
    return Check(name, None, None, None, said("Not tested: {reason}.", reason=reason))


def runs(evidence: Evidence) -> Sequence[tuple[str, str, float, float, float]]:
    """Repeat, direction, stiffness with its u, and zero shift of each run that holds at least two loads."""
    forces, b = evidence.forces[evidence.layout.loads], slope(evidence.forces, evidence.means)
    zeros = evidence.values - b * forces
    keys = [(reading.repeat, reading.direction) for reading in evidence.readings]
    lines: list[tuple[str, str, float, float, float]] = []
    first: float | None = None
    for key in dict.fromkeys(keys):
        chosen = np.array([other == key for other in keys])
        away = forces[chosen] - forces[chosen].mean()
        zero = float(zeros[chosen].mean())
        first = zero if first is None else first
        spread = float(away @ away)
        own = float(away @ evidence.values[chosen]) / spread if spread > 0 else 0.0
        if own > 0:
            lines.append((*key, 1 / own, evidence.s / sqrt(spread) / own**2, zero - first))
    return lines
