"""One parameter of a cause as a diagnosis seeks it: its range, and how its effect grows with it."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Size:
    """One parameter of a cause, as a diagnosis seeks it.

    Parameters
    ----------
    name, unit : str
        As a result prints it.
    null : float
        Value at which the effect vanishes.
    low, high : float
        Physical range.
    scale : float
        A change of this size is neither tiny nor huge.
    shape : bool
        True for a parameter that says how the effect acts, not how much of it there is.
    own : bool
        True for a parameter that each block of readings has for itself.
    power : int
        Power of the size with which its effect grows.
    extrapolated : bool
        True for a shape whose places differ most where there is no reading: what each of them says there counts alike.
    apart : int
        Values of a shape within its range that readings tell apart of an effect of ten standard deviations: it costs as
        a choice among so many. 0: as many as it may be.
    """

    name: str
    unit: str
    null: float
    low: float
    high: float
    scale: float
    shape: bool = False
    own: bool = False
    power: int = 1
    extrapolated: bool = False
    apart: int = 0

    @property
    def held(self) -> bool:
        """Whether it is a shape that is tried place by place, and held there: never sought between them."""
        return self.shape and self.scale == 0

    @property
    def places(self) -> range:
        """Places of a shape that is held: its range goes half a step beyond the first and the last."""
        return range(round(self.high + 0.5))

    def amount(self, first: float, factor: float) -> float:
        """Return the size whose effect is so many times that of a first one, which vanishes at zero."""
        return math.copysign(abs(factor) ** (1 / self.power), factor) * first


def choice(name: str, count: int, *, extrapolated: bool = False) -> Size:
    """Which of several shapes: tried one by one, and paid for by the logarithm of their number.

    Parameters
    ----------
    name : str
        Of the size.
    count : int
        Of the shapes; they are numbered from 0.
    extrapolated : bool
        Whether they differ most where there is no reading.

    Returns
    -------
    Size
        Without a unit, from −0.5 to count − 0.5.
    """
    return Size(name, "1", 0.0, -0.5, count - 0.5, 0.0, True, extrapolated=extrapolated)
