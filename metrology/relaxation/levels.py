"""Where the input of a record rests, and how long its ramps take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metrology.relaxation.blocks import Blocks
from metrology.relaxation.course import Course
from metrology.ties import level

WITHIN = 0.03
"""Part of the range of the input within which it counts as held."""
ON = 1e-9
"""Rounding of a time / s."""
LONG = 0.5
"""Time at a level, over that of a ramp through the whole range, from which on it is one."""


@dataclass(frozen=True)
class Level:
    """One level: from when to when / s, the mean of the input, and the range of its blocks."""

    start: float
    stop: float
    value: float
    range: float

    @property
    def duration(self) -> float:
        """How long it was held / s."""
        return self.stop - self.start


@dataclass(frozen=True)
class Levels:
    """Levels other than that of the beginning, and the times / s that the ramps to them took.

    `before`: until when the input rested / s; 0 where the record begins with a ramp.
    """

    held: tuple[Level, ...]
    ramps: tuple[float, ...]
    before: float

    @property
    def ramp(self) -> float:
        """Longest ramp / s."""
        return max(self.ramps)


def levels(of: Blocks, imposed: Course) -> Levels:
    """Find the levels of a record: stretches of time over which the input stays within 3 % of its range.

    Of these the ones that last longer than half a ramp through the range are levels; the others are parts of ramps. The
    rest before the first ramp ends where that begins, not where it has gone 3 % of the range.
    """
    reach = WITHIN * float(np.ptp(of.u))
    limit = level(reach)
    groups, begin = [], 0
    for at in range(1, len(of.u) + 1):
        if at == len(of.u) or level(abs(of.u[at] - np.median(of.u[begin:at]))) > limit:
            groups.append((begin, at))
            begin = at
    first, last = of.begin, of.end
    spans = np.array([last[b - 1] - first[a] for a, b in groups])
    turns = [a for a, _ in groups[1:]]
    fastest = max((abs(of.u[a] - of.u[a - 1]) / (of.time[a] - of.time[a - 1]) for a in turns), default=np.inf)
    ramp = float(np.ptp(of.u)) / float(fastest)
    found = [group for group, span in zip(groups, spans.tolist(), strict=True) if span > LONG * ramp]
    rest = [_level(of, a, b) for a, b in found]
    start, before = of.u[0], float(of.time[0])
    rested = 0.0
    held: list[Level] = []
    ramps: list[float] = []
    for one in rest:
        if abs(one.value - start) > reach or held:
            held.append(one)
            ramps.append(max(one.start - before, float(of.step.min())))
            before = one.stop
        else:
            before = rested = _rested(of, imposed, one, reach)
    return Levels(tuple(held), tuple(ramps) or (ramp,), rested)


def _rested(of: Blocks, imposed: Course, one: Level, reach: float) -> float:
    """When the last block of a rest ends before a piece of the course leaves it."""
    leaves = np.flatnonzero(np.abs(np.diff(imposed.u)) > reach)
    begins = float(imposed.time[leaves[0]]) if len(leaves) else np.inf
    stopped = of.end[of.end <= min(one.stop, begins + ON)]
    return float(stopped[-1]) if len(stopped) else 0.0


def _level(of: Blocks, first: int, last: int) -> Level:
    part = slice(first, last)
    start = float(of.begin[first])
    stop = float(of.end[last - 1])
    weights = of.count[part].astype(float)
    value = float((of.u[part] * weights).sum() / weights.sum())
    return Level(start, stop, value, float(np.ptp(of.u[part])))
