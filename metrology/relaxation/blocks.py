"""A long record as means of consecutive readings: short where it changes, long where it rests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

MOST = 200
"""Blocks of a record: some thirty for each decade of time."""
FIRST = 16
"""Blocks of equal count that the division begins with."""
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
    span : ndarray, shape (n,)
        Width / s of the interval over which a smooth course has the mean of the readings: √12 times the standard
        deviation of their stamps; 0 of a single reading.
    """

    start: Integers
    time: Array
    u: Array
    y: Array
    span: Array

    @property
    def count(self) -> Integers:
        """Readings of each block."""
        return np.diff(self.start)

    @property
    def step(self) -> Array:
        """Mean time between readings of each block / s; of a single one, that to its neighbours."""
        several = self.count > 1
        own = self.span / np.sqrt(np.maximum(self.count.astype(float) ** 2 - 1, 1))
        between = np.gradient(self.time) if len(self.time) > 1 else np.ones(1)
        return np.where(several, own, between)


def blocks(time: Array, u: Array, y: Array, pieces: Sequence[int] = (), most: int = MOST) -> Blocks:
    """Divide a record where its mean loses most: the block whose halves differ by most, weighed by √count.

    For white noise alone this loss is the same for blocks of every length, so that only what changes is divided.

    Parameters
    ----------
    time, u, y : ndarray, shape (n,)
        Stamps / s, increasing; what was imposed; what answered.
    pieces : sequence of int
        First readings of the pieces of the input, which no block spans, and the end.
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
    sums = {name: np.concatenate([[0.0], np.cumsum(channel - middle)])
            for name, channel, middle in (("u", u, u.mean()), ("y", y, y.mean()))}  # fmt: skip
    sizes = {"u": float(np.ptp(u)) or 1.0, "y": float(np.ptp(y)) or 1.0}

    def loss(first: int, last: int) -> float:
        """Difference of the means of the two halves over the range of the channel, times √count."""
        middle = (first + last) // 2
        found = 0.0
        for name, total in sums.items():
            left = (total[middle] - total[first]) / (middle - first)
            right = (total[last] - total[middle]) / (last - middle)
            found = max(found, abs(right - left) / sizes[name])
        return found * float(np.sqrt(last - first))

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
    since = time - origin
    means = [np.add.reduceat(channel, start[:-1]) / count for channel in (since, u, y)]
    away = since - np.repeat(means[0], count)
    span = np.sqrt(12 * np.add.reduceat(away**2, start[:-1]) / count)
    return Blocks(start, means[0], means[1], means[2], np.where(count > 1, span, 0.0))
