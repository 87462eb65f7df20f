"""Symmetric distributions between limits: rectangle, triangle, trapezoids, arcsine (JCGM 101:2008, 6.4.2 to 6.4.6)."""

# ruff: noqa: D102 - what the methods return is said once, in the base class

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import ClassVar

import numpy as np

from metrology.gum.influence import Distribution, Floats, Generator, demand


@dataclass(frozen=True)
class Rectangular(Distribution):
    """Rectangular: g(ξ) = 1/(2a) for |ξ| ≤ a; u = a/√3; null at a = 0.

    Parameters
    ----------
    half_width : float
        Half-width a, in the unit of the input.

    Source: JCGM 101:2008 6.4.2; JCGM 100:2008 4.3.7.

    Examples
    --------
    >>> round(Rectangular(0.05).u, 4)
    0.0289
    """

    half_width: float
    name: ClassVar[str] = "rectangular"

    def __post_init__(self) -> None:
        self._width("half_width", self.half_width)

    @property
    def u(self) -> float:
        return self.half_width / sqrt(3)

    def draw(self, generator: Generator, size: int) -> Floats:
        return _spread(generator, size, self.half_width)

    def lower(self, p: Floats) -> Floats:
        return self.half_width * (2 * p - 1)


@dataclass(frozen=True)
class Triangular(Distribution):
    """Triangular: g(ξ) = (a − |ξ|)/a² for |ξ| ≤ a; u = a/√6; null at a = 0.

    Parameters
    ----------
    half_width : float
        Half-width a, in the unit of the input.

    Source: JCGM 101:2008 6.4.5; JCGM 100:2008 4.3.9.
    """

    half_width: float
    name: ClassVar[str] = "triangular"

    def __post_init__(self) -> None:
        self._width("half_width", self.half_width)

    @property
    def u(self) -> float:
        return self.half_width / sqrt(6)

    def draw(self, generator: Generator, size: int) -> Floats:
        values = _spread(generator, size, self.half_width / 2)
        values += _spread(generator, size, self.half_width / 2)
        return values

    def lower(self, p: Floats) -> Floats:
        return self.half_width * (np.sqrt(2 * p) - 1)


@dataclass(frozen=True)
class Trapezoidal(Distribution):
    """Symmetric trapezoid: top of half-width βa over a base of half-width a; u² = a²(1 + β²)/6; null at a = 0.

    Density 1/(a(1+β)) on the top, falling linearly to zero at ±a. Limits: triangular at β = 0, rectangular at β = 1.

    Parameters
    ----------
    half_width : float
        Half-width a of the base, in the unit of the input.
    beta : float
        Ratio of top to base, 0 ≤ β ≤ 1.

    Source: JCGM 101:2008 6.4.4; JCGM 100:2008 4.3.9.
    """

    half_width: float
    beta: float
    name: ClassVar[str] = "trapezoidal"

    def __post_init__(self) -> None:
        self._width("half_width", self.half_width)
        demand(0 <= self.beta <= 1, "trapezoidal.beta", self.beta, "a number from 0 to 1")

    @property
    def u(self) -> float:
        return self.half_width * sqrt((1 + self.beta**2) / 6)

    def draw(self, generator: Generator, size: int) -> Floats:
        values = _spread(generator, size, self.half_width * (1 + self.beta) / 2)
        values += _spread(generator, size, self.half_width * (1 - self.beta) / 2)
        return values

    def lower(self, p: Floats) -> Floats:
        flank = np.sqrt(2 * p * (1 - self.beta**2)) - 1
        top = (p - 0.5) * (1 + self.beta)
        return self.half_width * np.where(p * 2 * (1 + self.beta) <= 1 - self.beta, flank, top)


@dataclass(frozen=True)
class Arcsine(Distribution):
    """Arcsine (U-shaped), of an influence that cycles sinusoidally: g(ξ) = 1/(π√(a² − ξ²)); u = a/√2; null at a = 0.

    Parameters
    ----------
    half_width : float
        Amplitude a, in the unit of the input.

    Source: JCGM 101:2008 6.4.6.
    """

    half_width: float
    name: ClassVar[str] = "arcsine"

    def __post_init__(self) -> None:
        self._width("half_width", self.half_width)

    @property
    def u(self) -> float:
        return self.half_width / sqrt(2)

    def draw(self, generator: Generator, size: int) -> Floats:
        values = np.sin(_spread(generator, size, np.pi))
        values *= self.half_width
        return values

    def lower(self, p: Floats) -> Floats:
        return -self.half_width * np.cos(np.pi * p)


@dataclass(frozen=True)
class CurvilinearTrapezoid(Distribution):
    """Rectangle whose half-width is known only to ±d: g(ξ) = ln((a+d)/max(|ξ|, a−d))/(4d); u² = a²/3 + d²/9.

    Null at a = d = 0; rectangular as d → 0.

    Parameters
    ----------
    half_width : float
        Best estimate a of the half-width, in the unit of the input.
    limit_half_width : float
        The half-width lies within a ± d; 0 ≤ d ≤ a.

    Source: JCGM 101:2008 6.4.3.
    """

    half_width: float
    limit_half_width: float
    name: ClassVar[str] = "curvilinear-trapezoid"

    def __post_init__(self) -> None:
        self._width("half_width", self.half_width)
        self._width("limit_half_width", self.limit_half_width)
        met = self.limit_half_width <= self.half_width
        demand(
            met, f"{self.name}.limit_half_width", self.limit_half_width, f"at most the half-width {self.half_width!r}"
        )

    @property
    def u(self) -> float:
        return sqrt(self.half_width**2 / 3 + self.limit_half_width**2 / 9)

    def draw(self, generator: Generator, size: int) -> Floats:
        width = _spread(generator, size, self.limit_half_width)
        width += self.half_width
        width *= _spread(generator, size, 1.0)
        return width

    def lower(self, p: Floats) -> Floats:
        inner, outer = self.half_width - self.limit_half_width, self.half_width + self.limit_half_width
        if self.limit_half_width == 0:
            return self.half_width * (2 * p - 1)
        # Bisection on the closed distribution function: 60 halvings exhaust the digits of a float.
        low, high = np.zeros_like(p), np.full_like(p, outer)
        for _ in range(60):
            middle = (low + high) / 2
            beyond = _curvilinear_tail(middle, inner, outer) > p
            low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
        return -(low + high) / 2


def _curvilinear_tail(x: Floats, inner: float, outer: float) -> Floats:
    """Probability beyond x > 0: ∫ ln(outer/max(t, inner)) dt / (2(outer − inner)) from x to outer."""
    edge = np.maximum(x, inner)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(edge > 0, np.log(outer / edge), 0.0)
    return np.asarray((outer - edge - edge * slope + (edge - x) * slope) / (2 * (outer - inner)))


def _spread(generator: Generator, size: int, half_width: float) -> Floats:
    """Rectangular draws from −half_width to half_width, made in place."""
    values = generator.random(size)
    values -= 0.5
    values *= 2 * half_width
    return values
