"""Coverage intervals from draws (JCGM 101:2008, 7.7)."""

from __future__ import annotations

from dataclasses import dataclass

from metrology.gum.inputs import Floats


@dataclass(frozen=True)
class Intervals:
    """Probabilistically symmetric and shortest coverage interval."""

    low: float
    high: float
    shortest_low: float
    shortest_high: float


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
    return Intervals(float(lows[first]), float(highs[first]), float(lows[best]), float(highs[best]))


def _part(values: Floats, low: int, high: int) -> None:
    """Bring the values of rank `low` and `high` to their places; two single cuts are far faster than one double cut."""
    values.partition(low)
    values[low + 1 :].partition(high - low - 1)
