"""Readings of a hold that are far off among good neighbours: misread, transmitted wrongly, knocked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from metrology.message import counted
from metrology.noise import OUTLYING, spikes
from metrology.relaxation.blocks import Array, blocks
from metrology.relaxation.course import Course
from metrology.relaxation.levels import levels
from metrology.relaxation.test import Mounting, RelaxationTest

BESIDE = 3
"""Readings at either end of a hold that are kept whatever they are: next to a ramp the last one is a peak."""
NAMED = 6
"""Outliers whose times are given."""


def without(test: RelaxationTest, one: Mounting, imposed: Course) -> tuple[Mounting, str]:
    """Return a specimen without the outliers of what answered, and a sentence on them; empty where there are none.

    Parameters
    ----------
    test : RelaxationTest
        Which of the channels answered.
    one : Mounting
        The specimen.
    imposed : Course
        Of what was imposed on it.

    Returns
    -------
    tuple of Mounting and str
        The same specimen and no sentence where no reading is an outlier.
    """
    _, y = test.shown(one)
    t = one.time - one.time[0]
    steps = np.abs(np.diff(y))
    # One division from the next is no outlier among equal readings.
    division = float(steps[steps > 0].min(initial=np.inf))
    far = np.zeros(len(t), dtype=bool)
    for held in levels(blocks(t, imposed.at(t), y, imposed.first), imposed).held:
        inside = np.flatnonzero((t > held.start) & (t < held.stop))
        if len(inside) > 4 * BESIDE:
            far[inside[BESIDE:-BESIDE]] = spikes(y[inside], division)[BESIDE:-BESIDE]
    if not far.any():
        return one, ""
    sentence = counted(
        "{specimen}: {count} outlier, a single reading more than {limit:g} standard uncertainties off among good "
        "neighbours, is left out: at {times} s",
        "{specimen}: {count} outliers, single readings more than {limit:g} standard uncertainties off among good "
        "neighbours, are left out: at {times} s",
        int(far.sum()), specimen=one.name, limit=OUTLYING, times=_times(one.time[far]),
    )  # fmt: skip
    kept = ~far
    return replace(one, time=one.time[kept], force=one.force[kept], shown=one.shown[kept]), sentence


def _times(times: Array) -> str:
    first = ", ".join(f"{time:.6g}" for time in times[:NAMED].tolist())
    return first if len(times) <= NAMED else f"{first}, …"
