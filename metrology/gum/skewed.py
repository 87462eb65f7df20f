"""Distributions of zero-mean influences that are not symmetric, or cut off: what `distributions` cannot say.

Each is moved so that its mean is zero: the value to which it belongs is the mean. A width of zero is the null case.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import isfinite, sqrt
from typing import Any, ClassVar

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.influence import Distribution, Floats, Generator

WIDEST = 3.0
"""Largest s of a lognormal: at 3 its u is 90 times its median, and no number of draws has its moments."""
NARROWEST = 0.01
"""Least cut of a truncated normal, in its σ: there it is rectangular to 1e-5, and below it rounding takes its u."""


class _Inverted(Distribution):
    """Drawn by inversion: ξ = scale·(x − mean) with x of a standard form that has quantiles in both tails."""

    @abstractmethod
    def _standard(self, p: Floats, *, above: bool) -> Any:
        """Quantile of the standard form for p ≤ 1/2 counted from below, or from above."""

    @abstractmethod
    def _moments(self) -> tuple[float, float]:
        """Mean and standard deviation of the standard form."""

    @property
    @abstractmethod
    def _scale(self) -> float:
        """What one of the standard form is of the influence."""

    @cached_property
    def _fixed(self) -> tuple[float, float]:
        return self._moments()

    @property
    def u(self) -> float:
        return self._scale * self._fixed[1]

    def draw(self, generator: Generator, size: int) -> Floats:
        return np.asarray(self.quantile(generator.random(size)))

    def lower(self, p: Floats) -> Floats:
        return np.asarray(self._scale * (self._standard(p, above=False) - self._fixed[0]))

    def upper(self, q: Floats) -> Floats:
        return np.asarray(self._scale * (self._standard(q, above=True) - self._fixed[0]))

    def _positive(self, **parameters: float) -> None:
        for key, value in parameters.items():
            if not (isfinite(value) and value > 0):
                raise MetrologyError(Fault(f"{self.name}.{key}", repr(value), "a finite number above zero"))


@dataclass(frozen=True)
class Gamma(_Inverted):
    """Gamma of shape k: ξ = u·(x − k)/√k with g(x) ∝ x^(k−1)·exp(−x); skewness 2/√k; null at u = 0.

    Source: JCGM 101:2008 6.4.11 (counts); N. L. Johnson, S. Kotz, Continuous Univariate Distributions 1, ch. 17.
    """

    standard: float
    k: float
    name: ClassVar[str] = "gamma"

    def __post_init__(self) -> None:
        self._width("standard", self.standard)
        self._positive(k=self.k)

    @property
    def _scale(self) -> float:
        return self.standard / sqrt(self.k)

    def _moments(self) -> tuple[float, float]:
        return self.k, sqrt(self.k)

    def _standard(self, p: Floats, *, above: bool) -> Any:
        from scipy.special import gammainccinv, gammaincinv

        return gammainccinv(self.k, p) if above else gammaincinv(self.k, p)


@dataclass(frozen=True)
class Exponential(_Inverted):
    """Exponential, of a quantity that cannot be below value − u: ξ = u·(x − 1) with g(x) = exp(−x); null at u = 0.

    Source: JCGM 101:2008 6.4.10.
    """

    standard: float
    name: ClassVar[str] = "exponential"

    def __post_init__(self) -> None:
        self._width("standard", self.standard)

    @property
    def _scale(self) -> float:
        return self.standard

    def _moments(self) -> tuple[float, float]:
        return 1.0, 1.0

    def _standard(self, p: Floats, *, above: bool) -> Any:
        with np.errstate(divide="ignore"):
            return -np.log(p) if above else -np.log1p(-p)


@dataclass(frozen=True)
class Lognormal(_Inverted):
    """Lognormal with s the standard deviation of the logarithm: ξ ∝ exp(s·z) − exp(s²/2), z normal; null at u = 0.

    The lower end is u/√(exp(s²) − 1) below the value.

    Source: N. L. Johnson, S. Kotz, Continuous Univariate Distributions 1, ch. 14.
    """

    standard: float
    s: float
    name: ClassVar[str] = "lognormal"

    def __post_init__(self) -> None:
        self._width("standard", self.standard)
        self._positive(s=self.s)
        if self.s > WIDEST:
            raise MetrologyError(Fault("lognormal.s", repr(self.s), f"{WIDEST:g} at most"))

    @property
    def _scale(self) -> float:
        return self.standard / self._fixed[1]

    def _moments(self) -> tuple[float, float]:
        mean = float(np.exp(self.s**2 / 2))
        return mean, mean * sqrt(float(np.expm1(self.s**2)))

    def _standard(self, p: Floats, *, above: bool) -> Any:
        from scipy.special import ndtri

        return np.exp(self.s * (-ndtri(p) if above else ndtri(p)))


@dataclass(frozen=True)
class TruncatedNormal(_Inverted):
    """Normal of standard deviation σ cut off at ±c·σ: u² = σ²·(1 − 2c·φ(c)/(2Φ(c) − 1)); null at σ = 0.

    Source: N. L. Johnson, S. Kotz, Continuous Univariate Distributions 1, ch. 13.
    """

    standard: float
    cut: float
    name: ClassVar[str] = "truncated-normal"

    def __post_init__(self) -> None:
        self._width("standard", self.standard)
        self._positive(cut=self.cut)
        if self.cut < NARROWEST:
            fix = "state a rectangular distribution"
            raise MetrologyError(Fault("truncated-normal.cut", repr(self.cut), f"{NARROWEST:g} at least", fix))

    @property
    def _scale(self) -> float:
        return self.standard

    def _moments(self) -> tuple[float, float]:
        c, inside = self.cut, self._inside()
        return 0.0, sqrt(1 - 2 * c * float(np.exp(-c * c / 2)) / sqrt(2 * np.pi) / inside)

    def _inside(self) -> float:
        from scipy.special import erf

        return float(erf(self.cut / sqrt(2)))

    def _standard(self, p: Floats, *, above: bool) -> Any:
        from scipy.special import ndtr, ndtri

        found = ndtri(ndtr(-self.cut) + p * self._inside())
        return -found if above else found


@dataclass(frozen=True)
class Beta(_Inverted):
    """Beta between two limits 2a apart: ξ = 2a·(x − mean) with g(x) ∝ x^(α−1)·(1 − x)^(β−1); null at a = 0.

    Limit: rectangular at α = β = 1.

    Source: N. L. Johnson, S. Kotz, Continuous Univariate Distributions 2, ch. 25.
    """

    half_width: float
    alpha: float
    beta: float
    name: ClassVar[str] = "beta"

    def __post_init__(self) -> None:
        self._width("half_width", self.half_width)
        self._positive(alpha=self.alpha, beta=self.beta)

    @property
    def _scale(self) -> float:
        return 2 * self.half_width

    def _moments(self) -> tuple[float, float]:
        a, b = self.alpha, self.beta
        return a / (a + b), sqrt(a * b / (a + b + 1)) / (a + b)

    def _standard(self, p: Floats, *, above: bool) -> Any:
        from scipy.special import betaincinv

        return 1 - betaincinv(self.beta, self.alpha, p) if above else betaincinv(self.alpha, self.beta, p)


@dataclass(frozen=True)
class Asymmetric(_Inverted):
    """Limits that are not alike below and above the value: g(x) ∝ exp(λ·x), λ such that the mean is the value.

    Of all distributions with these limits and this mean it assumes least (maximum
    entropy). Limit: rectangular where the limits are alike.

    Parameters
    ----------
    half_width : float
        Half of the distance between the limits.
    ratio : float
        Distance of the upper limit from the value, over that of the lower one.

    Source: JCGM 100:2008 4.3.8.
    """

    half_width: float
    ratio: float
    name: ClassVar[str] = "asymmetric"

    def __post_init__(self) -> None:
        self._width("half_width", self.half_width)
        if not 0.02 <= self.ratio <= 50:
            raise MetrologyError(Fault("asymmetric.ratio", repr(self.ratio), "a number from 0.02 to 50"))

    @property
    def _scale(self) -> float:
        return 2 * self.half_width

    @cached_property
    def _rate(self) -> float:
        """λ of the interval from 0 to 1, by its mean 1/(1 − exp(−λ)) − 1/λ."""
        from scipy.optimize import brentq

        return float(brentq(lambda rate: _mean(rate) - 1 / (1 + self.ratio), -100.0, 100.0, xtol=1e-13))

    def _moments(self) -> tuple[float, float]:
        rate = self._rate
        if abs(rate) < 1e-3:
            return _mean(rate), sqrt(1 / 12 - rate**2 / 240)
        return _mean(rate), sqrt(1 / rate**2 - 1 / (4 * np.sinh(rate / 2) ** 2))

    def _standard(self, p: Floats, *, above: bool) -> Any:
        rate = -self._rate if above else self._rate
        found = p if abs(rate) < 1e-9 else np.log1p(p * np.expm1(rate)) / rate
        return 1 - found if above else found


def _mean(rate: float) -> float:
    """Mean over 0 to 1 of a density in proportion to exp(rate·x)."""
    if abs(rate) < 1e-3:
        return 0.5 + rate / 12 - rate**3 / 720
    return float(-1 / np.expm1(-rate) - 1 / rate)


SKEWED: dict[str, Callable[..., Distribution]] = {
    "exponential": Exponential,
    "gamma": Gamma,
    "lognormal": Lognormal,
    "truncated-normal": TruncatedNormal,
    "beta": Beta,
    "asymmetric": Asymmetric,
}
"""Every one by its name, which is also the word for it in a campaign file."""
