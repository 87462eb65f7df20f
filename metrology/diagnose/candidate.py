"""What a table of effects tells of each of them, whatever the test: the cause, its parameters, what follows from it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Size:
    """One parameter of a candidate.

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


@dataclass(frozen=True)
class Candidate:
    """One cause that may be missing in a model.

    Parameters
    ----------
    name, title : str
        Key, and what a report prints.
    equation : str
        Its term.
    parameters : tuple of Size
        The first is its size.
    sign : str
        How one sees it.
    consequence : str
        What leaving it out does to k, E and c.
    advice : str
        What the laboratory should do.
    separate : str
        The extra measurement that tells it from others.
    kind : {'physics', 'input'}
        'input': something that the laboratory states with an uncertainty, and that would be wrong beyond it.
    shapes : tuple of mapping
        Shapes in which it is tried; those that the motion suggests where it names none.
    amount : float, optional
        Size to begin with.
    """

    name: str
    title: str
    equation: str
    parameters: tuple[Size, ...]
    sign: str
    consequence: str
    advice: str
    separate: str
    kind: Literal["physics", "input"] = "physics"
    shapes: tuple[Mapping[str, float], ...] = ()
    amount: float | None = None

    @property
    def size(self) -> Size:
        """The parameter that says how much of it there is."""
        return self.parameters[0]

    @property
    def signed(self) -> bool:
        """Whether it may act either way."""
        return self.size.low < self.size.null < self.size.high
