"""State of knowledge about a zero-mean influence: what every distribution of one has."""

from __future__ import annotations

from abc import ABC, abstractmethod
from math import inf
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from metrology.errors import Fault, MetrologyError

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Generator = np.random.Generator


def demand(met: bool, where: str, got: float, expected: str) -> None:
    """Refuse a parameter that is not as expected."""
    if not met:
        raise MetrologyError(Fault(where, f"{got!r}", expected))


class Distribution(ABC):
    """State of knowledge about a zero-mean influence; symmetric unless it defines `upper`."""

    name: ClassVar[str]

    @property
    @abstractmethod
    def u(self) -> float:
        """Standard uncertainty that the law of propagation uses, in the unit of the influence."""

    @property
    def deviation(self) -> float:
        """Standard deviation of the draws; it differs from `u` for Student's distribution only."""
        return self.u

    @abstractmethod
    def draw(self, generator: Generator, size: int) -> Floats:
        """Independent draws, shape (size,)."""

    @abstractmethod
    def lower(self, p: Floats) -> Floats:
        """Quantile for probabilities p ≤ 1/2, precise in the far tail."""

    def upper(self, q: Floats) -> Floats:
        """Value that is exceeded with probability q ≤ 1/2; the lower one with the other sign where it is symmetric."""
        return -self.lower(q)

    def quantile(self, p: ArrayLike) -> Floats:
        """Value below which the influence lies with probability `p` (any shape; 0 ≤ p ≤ 1)."""
        p = np.asarray(p, float)
        tail = np.minimum(p, 1.0 - p)
        return np.where(p > 0.5, self.upper(tail), self.lower(tail))

    def _width(self, key: str, width: float) -> None:
        if not 0 <= width < inf:
            raise MetrologyError(Fault(f"{self.name}.{key}", f"{width!r}", "a finite number, zero or more"))
