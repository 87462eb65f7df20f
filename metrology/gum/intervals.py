"""Coverage intervals from draws (JCGM 101:2008, 7.7)."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Literal

from metrology.gum.inputs import Floats

Kind = Literal["symmetric", "shortest"]
SHORTER = 0.01
"""Part of its width by which an interval has to be shorter than the symmetric one to be reported in its place."""
_CHANCE = 4.0
"""Standard deviations of the width of an interval of few draws, within which the shortest is shorter by chance."""


@dataclass(frozen=True)
class Intervals:
    """Probabilistically symmetric and shortest coverage interval of draws.

    `least` is the part of its width by which the shortest one has to be shorter to be the one that is reported.
    """

    low: float
    high: float
    shortest_low: float
    shortest_high: float
    least: float = SHORTER

    @property
    def gain(self) -> float:
        """Part of the width of the symmetric interval by which the shortest one is shorter."""
        width = self.high - self.low
        return 1 - (self.shortest_high - self.shortest_low) / width if width > 0 else 0.0

    @property
    def kind(self) -> Kind:
        """Which of the two is reported: the shortest one where it is shorter by more than chance makes it."""
        return "shortest" if self.gain > self.least else "symmetric"

    @property
    def reported(self) -> tuple[float, float]:
        """Ends of the interval that is reported."""
        return (self.shortest_low, self.shortest_high) if self.kind == "shortest" else (self.low, self.high)


def worthwhile(size: int, probability: float) -> float:
    """Part of its width by which the shortest interval of `size` draws has to be shorter than the symmetric one.

    Where the density is flat every interval of the probability has the same width, and where the shortest one of draws
    lies is chance alone: the standard deviation of its width is √(p·(1 − p)/M) of the range.

    Examples
    --------
    >>> worthwhile(100_000, 0.95), round(worthwhile(1000, 0.95), 4)
    (0.01, 0.0276)
    """
    return max(SHORTER, _CHANCE * sqrt(probability * (1 - probability) / size))


def ranks(size: int, probability: float) -> tuple[int, int]:
    """Number q = pM of draws inside the interval, and the zero-based rank of the lower symmetric end (7.7.1, 7.7.2).

    Examples
    --------
    >>> ranks(10_000, 0.95)
    (9500, 249)
    """
    inside = min(int(probability * size + 0.5), size - 1)
    return inside, max((size - inside + 1) // 2, 1) - 1


def symmetric(values: Floats, probability: float) -> tuple[float, float]:
    """Ends of the probabilistically symmetric interval of draws, shape (M,), which are left in another order."""
    inside, first = ranks(values.size, probability)
    _part(values, first, first + inside)
    return float(values[first]), float(values[first + inside])


def intervals(values: Floats, probability: float) -> Intervals:
    """Both intervals of draws, shape (M,), which are left in another order.

    Only the two tails are sorted: the shortest interval leaves out as many draws as the symmetric one, in other places.

    Source: JCGM 101:2008 7.7.2, 7.7.4.
    """
    inside, first = ranks(values.size, probability)
    tail = values.size - inside
    if tail < inside:
        _part(values, tail - 1, inside)
        values[:tail].sort()
        values[inside:].sort()
    else:
        values.sort()
    lows, highs = values[:tail], values[inside:]
    best = int((highs - lows).argmin())
    ends = float(lows[first]), float(highs[first]), float(lows[best]), float(highs[best])
    return Intervals(*ends, least=worthwhile(values.size, probability))


def _part(values: Floats, low: int, high: int) -> None:
    """Bring the values of rank `low` and `high` to their places; two single cuts are far faster than one double cut."""
    values.partition(low)
    values[low + 1 :].partition(high - low - 1)
