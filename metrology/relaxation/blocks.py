"""A long record as means of consecutive readings: short where it changes, long where it rests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Where = NDArray[np.bool_]

MOST = 200
"""Blocks of a record: some thirty for each decade of time."""
FIRST = 16
"""Blocks of equal count that the division begins with."""
EVEN = 0.1
"""Part of the length of a block by which the mean of its stamps may lie off its middle: of stamps that grow evenly in
their logarithm 0.06 over a factor of two."""
DIGITS = 9
"""Decimal places of what a division decides by: the sums of another processor differ in later ones, and where nothing
changes only these are left."""
LEAST = 24
"""Readings below which a record tells no course over time."""


@dataclass(frozen=True)
class Blocks:
    """Means of consecutive readings.

    Parameters
    ----------
    start : ndarray of int, shape (n + 1,)
        First reading of each block, and the end.
    time, u, y : ndarray, shape (n,)
        Means of the stamps / s, of what was imposed and of what answered.
    begin, end : ndarray, shape (n,)
        First and last stamp of each / s.
    """

    start: Integers
    time: Array
    u: Array
    y: Array
    begin: Array
    end: Array

    @cached_property
    def count(self) -> Integers:
        """Readings of each block."""
        return np.diff(self.start)

    @cached_property
    def step(self) -> Array:
        """Mean time between readings of each block / s; of a single one, that to its neighbours."""
        between = np.gradient(self.time) if len(self.time) > 1 else np.ones(1)
        return np.where(self.count > 1, (self.end - self.begin) / np.maximum(self.count - 1, 1), between)

    @cached_property
    def half(self) -> Array:
        """Half of the time between the first and the last reading of each block / s."""
        return (self.end - self.begin) / 2


def blocks(
    time: Array, u: Array, y: Array, pieces: Sequence[int] = (), by: Sequence[Array] = (), most: int = MOST
) -> Blocks:
    """Divide a record where its mean loses most: the block whose halves differ by most, weighed by √count.

    What decides is known without noise: a division by what answered would keep the differences that noise enlarges, and
    lose those that it lessens, and a record of many small steps would relax by more than its specimen.

    Parameters
    ----------
    time, u, y : ndarray, shape (n,)
        Stamps / s, increasing; the course of what was imposed; what answered.
    pieces : sequence of int
        First readings of the pieces of the input, which no block spans, and the end.
    by : sequence of ndarray, shape (n,)
        Courses that the answer may have, whose means decide; `u` where there is none.
    most : int
        Blocks at most, apart from those of the pieces.

    Examples
    --------
    >>> t = np.arange(1000.0)
    >>> found = blocks(t, np.minimum(t, 10.0), np.minimum(t, 10.0), most=40)
    >>> len(found.time), int(found.count[0]) < 10, int(found.count[-1]) > 10
    (40, True, True)
    """
    n = len(time)
    origin = time[0]
    sums = np.zeros((max(len(by), 1), n + 1))
    for row, channel in zip(sums, by or (u,), strict=True):
        np.cumsum((channel - channel.mean()) / (float(np.ptp(channel)) or 1.0), out=row[1:])

    since = time - origin
    stamps = np.concatenate([[0.0], np.cumsum(since - since.mean())])

    def uneven(first: int, last: int) -> bool:
        """Whether the mean of the stamps is far from the middle, as where the rate of the readings changes."""
        mean = (stamps[last] - stamps[first]) / (last - first) + since.mean()
        ends = float(since[first]), float(since[last - 1])
        return bool(abs(mean - sum(ends) / 2) > EVEN * (ends[1] - ends[0]))

    def loss(first: int, last: int) -> float:
        """Largest difference of the means of the two halves over the range of a course, times √count."""
        if last - first > 2 and uneven(first, last):
            return np.inf
        middle = (first + last) // 2
        left = (sums[:, middle] - sums[:, first]) / (middle - first)
        right = (sums[:, last] - sums[:, middle]) / (last - middle)
        return round(float(np.abs(right - left).max() * np.sqrt(last - first)), DIGITS)

    edges = sorted({*np.linspace(0, n, min(FIRST, n) + 1).astype(int).tolist(), *pieces})
    most += len(pieces)
    heap = [(-loss(a, b), a, b) for a, b in pairwise(edges) if b - a > 1]
    heapify(heap)
    chosen = set(edges)
    while heap and len(chosen) <= most:
        _, first, last = heappop(heap)
        middle = (first + last) // 2
        chosen.add(middle)
        for a, b in ((first, middle), (middle, last)):
            if b - a > 1:
                heappush(heap, (-loss(a, b), a, b))
    start = np.array(sorted(chosen), dtype=np.int64)
    count = np.diff(start)
    means = [np.add.reduceat(channel, start[:-1]) / count for channel in (since, u, y)]
    return Blocks(start, means[0], means[1], means[2], since[start[:-1]], since[start[1:] - 1])
