"""The ramp to a single level: whether the answer is proportional there, and the record without its readings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from metrology.relaxation.blocks import LEAST, Array, Integers, Where
from metrology.relaxation.course import Course
from metrology.relaxation.fit import Fitted
from metrology.relaxation.forms import Scene
from metrology.relaxation.levels import Levels
from metrology.relaxation.noise import Colours
from metrology.relaxation.test import Mounting
from metrology.relaxation.unlike import several, unlike

READ = 4
"""Means on a ramp from which on its course is judged."""
CHANGE = 0.05
"""Relative change of the stiffness from rest to the level from which on a ramp is left out."""


@dataclass(frozen=True)
class Bend:
    """A ramp on which the answer may not be proportional: against one on which it is, by a Bayes factor.

    Parameters
    ----------
    odds : float
        ln of the Bayes factor.
    whole : float
        Relative change of what answers, from rest to the level.
    read, linear : float
        Part of the answer at the end of the ramp that was read where half of the input was imposed, and that of the
        most probable form.
    """

    odds: float
    whole: float
    read: float
    linear: float


def bend(scene: Scene, best: Fitted, noise: Colours, levels: Levels, time: Array) -> Bend | None:
    """Weigh a stiffness that changes along the ramp; None where several levels, or too few readings, do not tell.

    Parameters
    ----------
    scene : Scene
        The record.
    best : Fitted
        The most probable form.
    noise : Colours
        In whose metric it was fitted.
    levels : Levels
        What was held.
    time : ndarray, shape (readings,)
        All stamps / s since the first.
    """
    of = scene.answer.of
    if not levels.held or several(levels, of.u):
        return None
    ramp = np.flatnonzero((of.begin >= levels.before) & (of.end <= levels.held[0].start) & (of.begin > 0))
    if len(ramp) < READ or int(_kept(time, levels).sum()) < LEAST:
        return None
    found = unlike(scene, best, noise, time, parts=False)
    half = ramp[np.argmin(np.abs(of.u[ramp] - (of.u[0] + levels.held[0].value) / 2))]
    model = best.model - best.values[0]
    zero = _rested(of.y, model, of.count, of.end <= levels.before)
    read, linear = ((row[half] - z) / ((row[ramp[-1]] - z) or np.inf) for row, z in ((of.y, zero), (model, 0.0)))
    return Bend(found.odds, found.whole, float(read), float(linear))


def _rested(y: Array, model: Array, count: Integers, rest: Where) -> float:
    """Zero of what answered: mean at rest, less what the model has there already; else the first reading."""
    if not rest.any():
        return float(y[0] - model[0])
    return float(np.average((y - model)[rest], weights=count[rest]))


def without(one: Mounting, imposed: Course, levels: Levels) -> tuple[Mounting, Course]:
    """A record without the readings of its ramp; what was imposed there is known all the same.

    The readings at rest are kept, the first one at least: they are the zero.
    """
    kept = _kept(one.time - one.time[0], levels)
    places = np.flatnonzero(kept)
    # No mean over what is left spans what was left out.
    apart = (np.flatnonzero(np.diff(places) > 1) + 1).tolist()
    first = sorted({*np.searchsorted(places, imposed.first).tolist(), *apart})
    left = replace(one, time=one.time[kept], force=one.force[kept], shown=one.shown[kept])
    return left, replace(imposed, first=tuple(first))


def _kept(t: Array, levels: Levels) -> Where:
    """Which readings were read at rest or in a hold; `t` are their stamps / s since the first."""
    kept: Where = (t < levels.before) | (t == 0)
    for level in levels.held:
        kept |= (t >= level.start) & (t <= level.stop)
    return kept
