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
        design = self.layout.mean_columns(zero_each=means.zero_each)
        scatter = sqrt(max(means.variance - self.rounding**2, 0.0))
        # Readings whose scatter is that about the line are drawn about a line, which lies as a whole on the division.
        places = self._on_line() if means.about_line else means.values
        apart = 1 if means.about_line else len(places)
        place = places[:, None] + division * (generator.random((apart, size)) - 0.5)
        readings = place[self.layout.loads] + scatter * generator.standard_normal((len(design), size))
        if division:
            readings = division * np.rint(readings / division)
        centre = readings.mean(axis=0)
        solution = np.linalg.pinv(design) @ (readings - centre)
        leftover = readings - centre
        leftover -= means.columns @ (np.linalg.pinv(means.columns) @ leftover)
        variance = (leftover**2).sum(axis=0) / means.dof
        errors = solution[: len(place)] + centre - place
        counts = np.bincount(self.layout.loads)[:, None]
        averaged = np.where(averages(variance, self.rounding), 1.0 / counts, 1.0)
        stated = np.where(averages(means.variance, self.rounding), 1.0 / counts, 1.0)
        return errors, variance / means.variance, averaged / stated

    def _on_line(self) -> Floats:
        """Points of the line through the means, one a load."""
        first = np.unique(self.layout.loads, return_index=True)[1]
        straight = self.means.columns[first, :2]
        return np.asarray(straight @ (np.linalg.pinv(straight) @ self.means.values))


def averages(variance: Floats | float, rounding: float) -> Bools:
    """Whether rounding errors of readings at one load average out: s ≥ √3·u(rounding), half a division.

    Readings that scatter by the standard deviation σ before they are rounded to the division d keep a common rounding
    error of the standard uncertainty d/(π√2)·exp(−2π²σ²/d²) (first harmonic of the sawtooth), while the rest averages
    like noise. At s = d/2, which holds σ² = s² − d²/12, the common part is 3 % of d/√12; with no scatter it is the
    whole.
    """
    return np.asarray(np.sqrt(variance) >= sqrt(3.0) * rounding) & (rounding > 0)
