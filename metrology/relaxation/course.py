"""The course of what was imposed: straight pieces, as many as the noise of its own readings supports."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from metrology.relaxation.blocks import Array, Blocks

PARAMETERS = 3.0
"""What a further piece adds: an end, a value and a slope, each at ln n of the residual χ² (Yao, Stat. Probab. Lett. 6
(1988) 181; Schwarz's criterion)."""
FINE = 1e-5
"""Part of the range of the input that no course has to follow: less than any instrument of a testing machine tells."""
ON = 1e-6
"""Part of the time between two readings within which a corner is at one of them."""
MOST = 240
"""Pieces at most: eighty levels with a ramp of three pieces to each. The rest stays in one piece."""
BINS = 4096
"""Means of a long piece among which the place of a corner is found first."""
SWEEPS = 3
"""Times that every corner is sought again between its neighbours; most stand after one."""

MEANS = 32
"""Means of which the scatter is judged, at least."""
WALK = 2.0
"""Growth of √count·scatter of means of a random walk from one count to twice as many."""


@dataclass(frozen=True)
class Course:
    """What was imposed as straight pieces, which meet in a corner, or are joined from one reading to the next.

    Parameters
    ----------
    time, u : ndarray, shape (k,)
        Where its slope changes: s since the first reading, and the value there.
    first : tuple of int
        First reading of each piece, and the end.
    noise : float
        Standard deviation of a reading; of a noise with a memory that of a white one with the same means.
    whole : bool
        Whether all pieces that the readings support were taken.
    """

    time: Array
    u: Array
    first: tuple[int, ...]
    noise: float
    whole: bool

    def unread(self, t: Array) -> float:
        """Time / s within which a change of what was imposed lies between two readings; the mean over all changes.

        A ramp with readings on it has its corners by them, and counts as none; `t` are all stamps / s.
        """
        moved = np.abs(np.diff(self.u))
        last = t[np.array(self.first[1:-1], dtype=int) - 1] - t[0]
        long = np.where(np.isin(self.time[:-1], last), np.diff(self.time), 0.0)
        return float(moved @ long / (moved.sum() or 1.0))

    def at(self, t: Array) -> Array:
        """What was imposed at times / s since the first reading."""
        return np.interp(t, self.time, self.u)

    def branch(self, t: Array, tau: float) -> Array:
        """What a branch of τ / s answers at times / s since the first reading: z of τ·z′ + z = u, from rest."""
        long, slopes = np.diff(self.time), np.diff(self.u) / np.diff(self.time)
        left = np.zeros(len(self.time))
        for at, (step, slope) in enumerate(zip(long.tolist(), slopes.tolist(), strict=True)):
            left[at + 1] = left[at] * np.exp(-step / tau) - slope * tau * np.expm1(-step / tau)
        piece = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, len(long) - 1)
        since = (t - self.time[piece]) / tau
        followed = left[piece] * np.exp(-since) - slopes[piece] * tau * np.expm1(-since)
        return np.asarray(self.at(t) - self.u[0] - followed)

    def covariance(self, t: Array, of: Blocks) -> Array:
        """Covariance of its means over blocks, none of which spans two pieces, shape (n, n); `t` are all stamps / s.

        Each piece is a line by least squares: σ²·(1/m + (tₐ − t̄)·(t_b − t̄)/Σ(t − t̄)²) within it, nothing between two.
        """
        found = np.zeros((len(of.time), len(of.time)))
        for first, last in pairwise(self.first):
            inside = np.flatnonzero((of.start[:-1] >= first) & (of.start[:-1] < last))
            piece = t[first:last] - t[0]
            away = of.time[inside] - piece.mean()
            squares = float(((piece - piece.mean()) ** 2).sum())
            turned = np.outer(away, away) / squares if len(piece) > 1 else 0.0
            found[np.ix_(inside, inside)] = self.noise**2 * (1 / len(piece) + turned)
        return found


def course(time: Array, u: Array, division: float = 0.0) -> Course:
    """Find the pieces: what explains most is divided next, then every corner is sought again, or left out.

    A corner that the noise of the readings does not support would turn noise into an input, to which the specimen did
    not answer: all stiffness would come out too small.

    Parameters
    ----------
    time, u : ndarray, shape (n,)
        Stamps / s, increasing; readings.
    division : float
        Smallest difference that is shown; what lies within half of it is no corner.
    """
    t = time - time[0]
    size = float(np.ptp(u)) or 1.0
    noise = slow_scatter(t, u)
    worth = PARAMETERS * float(np.log(len(t))) * noise**2
    least = max(division / 2, FINE * size) ** 2

    def gained(first: int, last: int) -> tuple[float, int]:
        """By how much a corner lessens the squares beyond what it has to, and where it stands."""
        at, gain = _corner(t, u, first, last)
        return gain - worth - min(at - first, last - at) * least, at

    edges = [0, len(t)]
    heap = [(-gain, at, 0, len(t)) for gain, at in [gained(0, len(t))]]
    heapify(heap)
    while heap and heap[0][0] < 0 and len(edges) <= MOST:
        _, at, first, last = heappop(heap)
        edges.append(at)
        for a, b in ((first, at), (at, last)):
            if b - a > 1:
                gain, place = gained(a, b)
                heappush(heap, (-gain, place, a, b))
    whole = not heap or heap[0][0] >= 0
    edges.sort()
    for _ in range(SWEEPS):
        before = list(edges)
        at = 1
        while at < len(edges) - 1:
            gain, place = gained(edges[at - 1], edges[at + 1])
            if gain > 0:
                edges[at] = place
                at += 1
            else:
                del edges[at]
        if edges == before:
            break
    times, values = (np.array(row) for row in zip(*_knots(t, u, edges), strict=True))
    later = np.concatenate([[True], np.diff(times) > 0])
    return Course(times[later], values[later], tuple(edges), noise, whole)


def scatter(t: Array, u: Array) -> float:
    """Standard deviation of a reading about the line through its neighbours, by the median: ramps do not count."""
    part = (t[2:] - t[1:-1]) / (t[2:] - t[:-2])
    away = u[1:-1] - part * u[:-2] - (1 - part) * u[2:]
    return float(np.median(np.abs(away) / np.sqrt(1 + part**2 + (1 - part) ** 2)) / 0.6745)


def slow_scatter(t: Array, u: Array) -> float:
    """Standard deviation of a white noise whose means scatter as much as those of the readings, over any count of them.

    Means over 1, 2, 4, … readings, as long as √count times their scatter does not grow by more than that of a random
    walk: what grows faster is the course.
    """
    found = [scatter(t, u)]
    for m in (2**power for power in range(1, len(t).bit_length())):
        if len(t) // m < MEANS:
            break
        rows = (row[: len(t) // m * m].reshape(-1, m).mean(axis=1) for row in (t, u))
        found.append(scatter(*rows) * float(np.sqrt(m)))
        if found[-1] > WALK * found[-2]:
            return max(found[:-1])
    return max(found)


def _knots(t: Array, u: Array, edges: list[int]) -> Iterator[tuple[float, float]]:
    """Corners where two lines meet within a reading of where one piece ends; elsewhere the ends of both.

    A piece then begins with the first reading after the corner: `edges` follow.
    """
    lines = [_line(t[a:b], u[a:b]) for a, b in pairwise(edges)]
    yield float(t[0]), lines[0].at(float(t[0]))
    for number, (line, then) in enumerate(pairwise(lines), 1):
        at = edges[number]
        near = float(t[at])
        # About the end of the piece: about zero a steep ramp late in a record would leave few digits of its level.
        bend = line.slope - then.slope
        corner = near + (then.at(near) - line.at(near)) / bend if bend else np.inf
        # A corner at a reading but for rounding is at it, on every processor.
        first = int(np.searchsorted(t, corner - ON * (t[at] - t[at - 1])))
        is_near = t[max(at - 2, edges[number - 1])] < corner < t[min(at + 1, edges[number + 1] - 1)]
        # Two lines that meet where the first one begins leave it no reading.
        if is_near and edges[number - 1] < first < edges[number + 1]:
            edges[number] = first
            yield corner, line.at(corner)
        else:
            yield float(t[at - 1]), line.at(float(t[at - 1]))
            yield near, then.at(near)
    yield float(t[-1]), lines[-1].at(float(t[-1]))


class _Line(NamedTuple):
    """A line through the means of stamps and readings."""

    time: float
    value: float
    slope: float

    def at(self, t: float) -> float:
        return self.value + self.slope * (t - self.time)


def _line(t: Array, u: Array) -> _Line:
    """The line of least squares through the readings of a piece."""
    middle, mean = float(t.mean()), float(u.mean())
    away = t - middle
    slope = float(away @ (u - mean) / (away @ away)) if len(t) > 1 else 0.0
    return _Line(middle, mean, slope)


def _corner(t: Array, u: Array, first: int, last: int) -> tuple[int, float]:
    """First reading of the second of two lines that leave the least squares, and by how much less than one line."""
    n = last - first
    if n <= BINS:
        return _divided(t, u, first, last, np.ones(n))
    edges = np.linspace(first, last, BINS + 1).astype(int)
    count = np.diff(edges).astype(float)
    means = [np.add.reduceat(row[first:last], edges[:-1] - first) / count for row in (t, u)]
    at, gain = _divided(means[0], means[1], 0, BINS, count)
    low, high = int(edges[max(at - 2, 0)]), int(edges[min(at + 2, BINS)])
    fine, _ = _divided(t, u, low, high, np.ones(high - low))
    return fine, gain


def _divided(t: Array, u: Array, first: int, last: int, count: Array) -> tuple[int, float]:
    part = slice(first, last)
    middle = count.sum()
    x, y = (row[part] - float(count @ row[part]) / middle for row in (t, u))
    x = x / (float(np.abs(x).max()) or 1.0)
    forward = _squares(x, y, count)
    backward = _squares(x[::-1], y[::-1], count[::-1])[::-1]
    left = forward[:-1] + backward[1:]
    at = int(np.argmin(left))
    return first + at + 1, float(forward[-1] - left[at])


def _squares(x: Array, y: Array, count: Array) -> Array:
    """Squares that a line leaves of the first 1, 2, … readings."""
    w, wx, wy = (np.cumsum(count * row) for row in (np.ones_like(x), x, y))
    xx, xy, yy = (np.cumsum(count * row) for row in (x * x, x * y, y * y))
    sxx, sxy, syy = xx - wx**2 / w, xy - wx * wy / w, yy - wy**2 / w
    # Two readings are a line; what rounding leaves of fewer has no meaning.
    return np.where(np.arange(len(x)) < 2, 0.0, np.maximum(syy - sxy**2 / np.where(sxx > 0, sxx, np.inf), 0.0))
