"""Distributions of zero-mean influences: standard uncertainty, draws and quantiles (JCGM 101:2008, 6.4).

Each entry describes one cause of uncertainty, in the unit of the input it acts on: here those without limits, and
`DISTRIBUTIONS`, which lists all by name, those between limits (`bounded`) among them.
A width of zero is the null case: the influence vanishes, u = 0 and every draw is 0.
"""

# ruff: noqa: D102 - what the methods return is said once, in the base class

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt
from typing import ClassVar

import numpy as np

from metrology.gum.bounded import Arcsine, CurvilinearTrapezoid, Rectangular, Trapezoidal, Triangular
from metrology.gum.influence import Distribution, Floats, Generator, demand


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
        demand(isfinite(self.dof) and self.dof > 0, "student.dof", self.dof, "a finite number above zero")

    @classmethod
    def by_deviation(cls, deviation: float, dof: float) -> Student:
        """Distribution whose standard deviation is `deviation`: s = deviation·√((ν−2)/ν), for ν > 2."""
        demand(dof > 2, "student.dof", dof, "more than 2: the standard deviation does not exist below")
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
        demand(isfinite(self.dof) and self.dof > 0, "chi-square.dof", self.dof, "a finite number above zero")

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
