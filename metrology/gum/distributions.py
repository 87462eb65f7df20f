"""Distributions of zero-mean influences: standard uncertainty, draws and quantiles (JCGM 101:2008, 6.4).

Each entry describes one cause of uncertainty, in the unit of the input it acts on; `DISTRIBUTIONS` lists them by name.
A width of zero is the null case: the influence vanishes, u = 0 and every draw is 0.
"""

# ruff: noqa: D102 - what the methods return is said once, in the base class

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import inf, isfinite, sqrt
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from metrology.errors import Fault, MetrologyError

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Generator = np.random.Generator


def _demand(met: bool, where: str, got: float, expected: str) -> None:
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


@dataclass(frozen=True)
class Normal(Distribution):
    """Normal: g(ξ) = exp(−ξ²/(2u²)) / (u√(2π)); null at u = 0.

    Parameters
    ----------
    standard : float
        Standard uncertainty u, in the unit of the input.

    Source: JCGM 101:2008 6.4.7.

    Examples
    --------
    >>> round(float(Normal(1.0).quantile(0.975)), 2)
    1.96
    """

    standard: float
    name: ClassVar[str] = "normal"

    def __post_init__(self) -> None:
        self._width("standard", self.standard)

    @property
    def u(self) -> float:
        return self.standard

    def draw(self, generator: Generator, size: int) -> Floats:
        values = generator.standard_normal(size)
        values *= self.standard
        return values

    def lower(self, p: Floats) -> Floats:
        from scipy.special import ndtri

        return np.asarray(self.standard * ndtri(p))


@dataclass(frozen=True)
class Student(Distribution):
    """Scaled t: g(ξ) ∝ (1 + (ξ/s)²/ν)^(−(ν+1)/2); null at s = 0, normal as ν → ∞.

    The GUM uncertainty framework takes the scale s (of n readings: s/√n) as standard uncertainty (JCGM 100 4.2.3);
    the draws scatter by s√(ν/(ν−2)), which does not exist for ν ≤ 2.

    Parameters
    ----------
    scale : float
        Scale s, in the unit of the input.
    dof : float
        Degrees of freedom ν > 0.
    standard : float, optional
        Standard uncertainty for the law, where a source states the standard deviation of the t distribution itself
        (see `by_deviation`); the scale when left out.

    Source: JCGM 101:2008 6.4.9.

    Examples
    --------
    >>> round(float(Student(1.0, 16).quantile(0.995)), 2)
    2.92
    """

    scale: float
    dof: float
    standard: float | None = None
    name: ClassVar[str] = "student"

    def __post_init__(self) -> None:
        self._width("scale", self.scale)
        _demand(isfinite(self.dof) and self.dof > 0, "student.dof", self.dof, "a finite number above zero")

    @classmethod
    def by_deviation(cls, deviation: float, dof: float) -> Student:
        """Distribution whose standard deviation is `deviation`: s = deviation·√((ν−2)/ν), for ν > 2."""
        _demand(dof > 2, "student.dof", dof, "more than 2: the standard deviation does not exist below")
        return cls(deviation * sqrt((dof - 2) / dof), dof, deviation)

    @property
    def u(self) -> float:
        return self.scale if self.standard is None else self.standard

    @property
    def deviation(self) -> float:
        if self.scale == 0:
            return 0.0
        return self.scale * sqrt(self.dof / (self.dof - 2)) if self.dof > 2 else float("inf")

    def draw(self, generator: Generator, size: int) -> Floats:
        values = generator.standard_t(self.dof, size)
        values *= self.scale
        return values

    def lower(self, p: Floats) -> Floats:
        from scipy.special import stdtrit

        return np.asarray(self.scale * stdtrit(self.dof, p))


@dataclass(frozen=True)
class MeanSquare(Distribution):
    """What a mean square with ν degrees of freedom leaves open of its expectation: ξ = s²·(ν/χ² - 1); null at s² = 0.

    The GUM uncertainty framework takes s²·√(2/ν) as standard uncertainty (JCGM 100 E.4.3). A standard deviation of few
    degrees of freedom is far from normal: with ν = 2 one of ten is more than three times too small. Of the draws of s²
    there is a standard deviation for ν > 4, of those of s for ν > 2.

    Parameters
    ----------
    scale : float
        The mean square.
    dof : float
        Degrees of freedom ν > 0.

    Source: G. E. P. Box, G. C. Tiao, Bayesian Inference in Statistical Analysis (1973), 2.3.

    Examples
    --------
    >>> round(float(1.0 + MeanSquare(1.0, 2).quantile(0.9)) ** 0.5, 2)
    3.08
    """

    scale: float
    dof: float
    name: ClassVar[str] = "chi-square"

    def __post_init__(self) -> None:
        self._width("scale", self.scale)
        _demand(isfinite(self.dof) and self.dof > 0, "chi-square.dof", self.dof, "a finite number above zero")

    @property
    def u(self) -> float:
        return self.scale * sqrt(2 / self.dof)

    @property
    def deviation(self) -> float:
        if self.scale == 0:
            return 0.0
        return self.scale * self.dof / (self.dof - 2) * sqrt(2 / (self.dof - 4)) if self.dof > 4 else float("inf")

    def draw(self, generator: Generator, size: int) -> Floats:
        values = generator.chisquare(self.dof, size)
        return np.asarray(self.scale * (self.dof / values - 1.0))

    def lower(self, p: Floats) -> Floats:
        from scipy.special import chdtri

        with np.errstate(divide="ignore"):
            return np.asarray(self.scale * (self.dof / chdtri(self.dof, p) - 1.0))

    def upper(self, q: Floats) -> Floats:
        from scipy.special import gammaincinv

        with np.errstate(divide="ignore"):
            return np.asarray(self.scale * (self.dof / (2 * gammaincinv(self.dof / 2, q)) - 1.0))


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
        _demand(0 <= self.beta <= 1, "trapezoidal.beta", self.beta, "a number from 0 to 1")

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
        _demand(
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


DISTRIBUTIONS: dict[str, type[Distribution]] = {
    "normal": Normal,
    "student": Student,
    "rectangular": Rectangular,
    "triangular": Triangular,
    "trapezoidal": Trapezoidal,
    "arcsine": Arcsine,
    "curvilinear-trapezoid": CurvilinearTrapezoid,
}
"""Every distribution by its name, which is also the word for it in a campaign file."""
