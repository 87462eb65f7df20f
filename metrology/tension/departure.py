"""How far a record departs from its line, and what of that noise excuses."""

from __future__ import annotations

from math import sqrt

import numpy as np

from metrology.tension.lines import Lines
from metrology.tension.passage import excused
from metrology.tension.slope import Array, scatter
from metrology.tension.test import TensionTest

FAR = 3.0
"""Standard uncertainties from which on a bow contradicts: by chance in 1 of 300 records of 20 degrees of freedom."""
PARTS = 10
"""Parts of a record whose means are compared with its line."""


def excused_bow(one: Lines, tolerance: float) -> float:
    """Bow over the range that noise excuses at most, by the reading that tells the stiffness."""
    rows = one.passage.rows
    return excused(one.mounting.force[rows], _tells(one)[rows], tolerance)


def off_line(test: TensionTest, one: Lines) -> float:
    """How far the mean of a tenth of the readings is off the line, over the range; less scatter and rounding."""
    rows, line = one.passage.rows, one.main
    force, reading = one.mounting.force[rows], _tells(one)[rows]
    seen = np.isfinite(reading)
    force, left = force[seen], (reading - line.intercept - line.value * one.mounting.force[rows])[seen]
    size = abs(line.value) * float(np.ptp(force))
    if len(left) < 2 * PARTS or not size > 0:
        return 0.0
    means = np.array([part.mean() for part in np.array_split(left, PARTS)])
    key = "strain" if one.strain is not None else "crosshead"
    rounded = test.division.get(key, 0.0) + abs(line.value) * test.division.get("force", 0.0)
    return (float(np.abs(means).max()) - FAR * scatter(left) * sqrt(PARTS / len(left)) - rounded / 2) / size


def _tells(one: Lines) -> Array:
    """The reading that tells the stiffness."""
    reading = one.mounting.strain if one.strain is not None else one.mounting.crosshead
    assert reading is not None
    return reading
