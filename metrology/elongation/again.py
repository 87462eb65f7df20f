"""An elongation test made again: readings drawn about their means, rounded to the division, and averaged anew."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from metrology.elongation.line import Floats, Layout, Means

Bools = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


@dataclass(frozen=True)
class Again:
    """Repetitions of the readings of an elongation test.

    The scatter that rounding adds to the readings is no scatter of the test: s² holds d²/12 of a division d. Where on
    its division each load comes to lie is another one in each repetition.

    Parameters
    ----------
    layout : Layout
        Load and repeat of each reading.
    means : Means
        Of the readings.
    rounding : float
        Standard uncertainty d/√12 of the rounding of one reading, in m; 0 where nothing is known of it.
    """

    layout: Layout
    means: Means
    rounding: float

    def __call__(self, generator: np.random.Generator, size: int) -> tuple[Floats, Floats, Floats]:
        """Errors of the mean readings, s² over that of the test, and u² of rounding over that of the test."""
        means, division = self.means, sqrt(12.0) * self.rounding
        design = self._design()
        scatter = sqrt(max(means.variance - self.rounding**2, 0.0))
        place = means.values[:, None] + division * (generator.random((len(means.values), size)) - 0.5)
        readings = place[self.layout.loads] + scatter * generator.standard_normal((len(design), size))
        if division:
            readings = division * np.rint(readings / division)
        centre = readings.mean(axis=0)
        solution = np.linalg.pinv(design) @ (readings - centre)
        leftover = readings - centre - design @ solution
        variance = (leftover**2).sum(axis=0) / means.dof
        errors = solution[: len(place)] + centre - place
        counts = np.bincount(self.layout.loads)[:, None]
        averaged = np.where(self._averages(variance), 1.0 / counts, 1.0)
        stated = 1.0 / counts if self._averages(means.variance) else np.ones_like(counts, dtype=float)
        return errors, variance / means.variance, averaged / stated

    def _design(self) -> Floats:
        levels = self.layout.level_columns()
        return np.hstack([levels, self.layout.repeat_columns()]) if self.means.zero_each else levels

    def _averages(self, variance: Floats | float) -> Bools:
        """Whether readings scatter by half a division or more, so that rounding averages out."""
        return np.asarray(np.sqrt(variance) >= sqrt(3.0) * self.rounding)
