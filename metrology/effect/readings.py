"""Readings of an elongation or tension test, as the term of a cause takes them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings under dead loads, in the order in which they were taken.

    Parameters
    ----------
    force : ndarray, shape (n,)
        N.
    order : ndarray, shape (n,)
        Number of the reading within its repeat.
    back : ndarray, shape (n,)
        1 when unloading, else 0.
    repeat : ndarray of int, shape (n,)
        Number of its repeat.
    u : float
        Scatter of one reading / m.
    """

    force: Array
    order: Array
    back: Array
    repeat: NDArray[np.intp]
    u: float = 1.0

    @property
    def most(self) -> float:
        """Largest force / N."""
        return float(np.abs(self.force).max())


@dataclass(frozen=True, eq=False)
class Pulled:
    """Readings of one specimen in a testing machine, first those of the crosshead, then those of the extensometer.

    Both are displacements over the free length: a strain is multiplied by it.

    Parameters
    ----------
    force, time : ndarray, shape (n,)
        N, s.
    crosshead : ndarray, shape (n,)
        1 for a reading of the crosshead, 0 for one of the extensometer.
    number : int
        Number of the mounting.
    many : int
        Mountings of the test.
    most : float
        Largest force of the test / N.
    middle : float
        Middle of its forces / N.
    slope : float
        Stretch of the free length by force / (m/N).
    u : float
        Scatter of one reading / m.
    steps : int
        Places of each record at which a step is tried.
    halves : int
        Records of each mounting, one after the other: what is lost in one is lost in the next.
    rate : float
        Logarithm of the rate of its force over the geometric mean of those of the test.
    history : tuple of ndarray, shape (h,)
        Force / N and time / s of the whole record up to its last reading, with what lies outside the range of the line.
    kept : dict
        What an effect computes once for these readings, by its name; a copy with other readings begins anew.
    """

    force: Array
    time: Array
    crosshead: Array
    number: int = 0
    many: int = 1
    most: float = 1.0
    middle: float = 0.0
    slope: float = 1.0
    u: float = 1.0
    steps: int = 8
    halves: int = 1
    rate: float = 0.0
    history: tuple[Array, Array] = (np.zeros(1), np.zeros(1))
    kept: dict[str, Array] = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def highest(self) -> Array:
        """Highest force so far at each reading / N."""
        force, time = self.history
        return np.maximum(np.interp(self.time, time, np.maximum.accumulate(force)), self.force)

    @property
    def duration(self) -> float:
        """Time of the whole record up to its last reading / s."""
        return float(np.ptp(self.history[1])) or 1.0

    @property
    def falling(self) -> Array:
        """1 while the force falls, 0 while it rises: over five values of the record, whose noise falls as often."""
        force, time = self.history
        if len(force) < 6:
            return np.zeros(len(self.force))
        later, sooner = np.arange(len(force)) + 2, np.arange(len(force)) - 2
        change = force[np.minimum(later, len(force) - 1)] - force[np.maximum(sooner, 0)]
        nearest = np.searchsorted(0.5 * (time[1:] + time[:-1]), self.time)
        return np.asarray(change[nearest] < 0, dtype=float)

    def after(self, place: float) -> Array:
        """1 for what was read of one mounting beyond the n-th place, which lies in record n // `steps`."""
        number, part = divmod(round(place), self.steps)
        if number < self.number and number // self.halves == self.number // self.halves:
            return np.ones(len(self.force))
        late = self.time > self.time.min() + (part + 0.5) / self.steps * float(np.ptp(self.time))
        return np.asarray(late & (number == self.number), dtype=float)

    @property
    def places(self) -> range:
        """Every place at which a step is tried."""
        return range(self.steps * self.many)
