"""Global risks of a decision on conformity, over all items that may come (JCGM 106:2012, clause 9)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.inputs import Floats

if TYPE_CHECKING:
    from metrology.gum.output import Output

ROUNDING = 1e-12
"""Part of a number by which a sum or a unit moves it: 0.1 mm + 0.2 mm is 0.3 mm, no u is as small."""
_NODES = 24
_REACH = 38.0
_QUANTILES = (1e-6, 1e-5, 1e-4, 1e-3, *(0.01 * i for i in range(1, 100)), 0.999, 0.9999, 0.99999, 0.999999)


@dataclass(frozen=True)
class Limits:
    """A tolerance interval [lower, upper], open on a side whose limit is None."""

    lower: float | None = None
    upper: float | None = None

    def __post_init__(self) -> None:
        given = [limit for limit in (self.lower, self.upper) if limit is not None]
        if not given or not all(isfinite(limit) for limit in given):
            raise MetrologyError(Fault("limits", f"{self.lower} to {self.upper}", "one or two finite limits"))

    def holds(self, value: float) -> bool:
        """Whether a value lies in the interval, ends included, up to the rounding of binary arithmetic (`ROUNDING`)."""

        def near(end: float) -> bool:
            return abs(value - end) <= ROUNDING * max(abs(end), abs(value))

        above = self.lower is None or value >= self.lower or near(self.lower)
        return above and (self.upper is None or value <= self.upper or near(self.upper))

    @property
    def empty(self) -> bool:
        """Whether the lower limit lies above the upper one."""
        return self.lower is not None and self.upper is not None and self.lower > self.upper

    @property
    def half_width(self) -> float:
        """Half of the distance between the limits; infinite where a side is open."""
        return inf if self.lower is None or self.upper is None else (self.upper - self.lower) / 2

    def shrunk(self, lower: float, upper: float | None = None) -> Limits:
        """The interval with its ends moved inside, by `lower` and `upper` (the same where that is None)."""
        upper = lower if upper is None else upper
        if not (isfinite(lower) and isfinite(upper)):
            return Limits(0.0, -1.0)
        return Limits(
            None if self.lower is None else self.lower + lower,
            None if self.upper is None else self.upper - upper,
        )


@dataclass(frozen=True)
class Prior:
    """What is known of the measurand of such items before one is measured: the distribution of production.

    Made by `normal`, `gamma`, `lognormal` or `rectangular`.
    """

    name: str
    density: Callable[[Any], Any]
    quantile: Callable[[Any], Any]

    @classmethod
    def normal(cls, mean: float, standard_deviation: float) -> Prior:
        """Normal, by mean and standard deviation."""
        _positive(standard_deviation=standard_deviation)
        from scipy.stats import norm

        return cls._of(f"normal ({mean:g}, {standard_deviation:g})", norm(mean, standard_deviation))

    @classmethod
    def gamma(cls, shape: float, scale: float) -> Prior:
        """Gamma, for a quantity that is never below zero."""
        _positive(shape=shape, scale=scale)
        from scipy.stats import gamma

        return cls._of(f"gamma ({shape:g}, {scale:g})", gamma(shape, scale=scale))

    @classmethod
    def lognormal(cls, median: float, sigma: float) -> Prior:
        """Lognormal, by the median and the standard deviation of the natural logarithm."""
        _positive(median=median, sigma=sigma)
        from scipy.stats import lognorm

        return cls._of(f"lognormal ({median:g}, {sigma:g})", lognorm(sigma, scale=median))

    @classmethod
    def rectangular(cls, low: float, high: float) -> Prior:
        """Rectangular, between two ends."""
        _positive(width=high - low)
        from scipy.stats import uniform

        return cls._of(f"rectangular ({low:g}, {high:g})", uniform(low, high - low))

    @classmethod
    def _of(cls, name: str, law: Any) -> Prior:
        return cls(name, law.pdf, law.ppf)


def _positive(**parameters: float) -> None:
    faults = [
        Fault(f"prior.{name}", f"{value}", "a finite number above zero")
        for name, value in parameters.items()
        if not (isfinite(value) and value > 0)
    ]
    if faults:
        raise MetrologyError(*faults)


def tails(z: Any, dof: float = inf) -> Any:
    """Distribution function of the normal, or of Student's with `dof`, at z."""
    from scipy.special import ndtr, stdtr

    return ndtr(z) if dof == inf else stdtr(dof, z)


def _errors(measurement: float | Output) -> Output:
    """Distribution of a result, of which that of the errors follows: error = value − true value."""
    from metrology.gum.output import Analytic

    return Analytic(0.0, float(measurement)) if isinstance(measurement, int | float) else measurement


def global_risks(
    prior: Prior, measurement: float | Output, *, limits: Limits, acceptance: Limits
) -> tuple[float, float]:
    """Probability that an item is accepted and does not conform, and that it is rejected and does.

    R_C = ∫_outside g(η)·P(accepted | η) dη, R_P = ∫_inside g(η)·P(rejected | η) dη. An item of true value η gives the
    result η + e, where the error e = y − Y has the distribution of the result about its value y. By Gauss–Legendre
    quadrature over panels between the quantiles of the prior, and the multiples of u and the quantiles of the error
    about every limit.

    Parameters
    ----------
    prior : Prior
    measurement : float or Output
        Distribution of the result of a measurement; or a standard uncertainty, for normal errors.
    limits, acceptance : Limits
        Of the true value, and of the results that pass.

    Notes
    -----
    JCGM 106:2012, 9.5.2. The ball bearings of its 9.5.4 have R_C = 0.008.

    Examples
    --------
    >>> bearings, limit = Prior.gamma(4, 0.25), Limits(upper=2.0)
    >>> consumer, _ = global_risks(bearings, 0.25, limits=limit, acceptance=limit)
    >>> round(consumer, 3)
    0.008
    """
    errors = _errors(measurement)
    nodes, weights = quadrature(prior, errors.u, limits, acceptance, _marks(errors, acceptance))
    mass = weights * prior.density(nodes)
    # The result η + y − Y lies below an acceptance limit where Y > η + y − limit.
    shifted = nodes + errors.value
    below = np.zeros_like(nodes) if acceptance.lower is None else errors.above(shifted - acceptance.lower)
    above = np.zeros_like(nodes) if acceptance.upper is None else errors.below(shifted - acceptance.upper)
    rejected = np.minimum(below + above, 1.0)
    if acceptance.lower is not None and acceptance.upper is not None:
        accepted = 1 - rejected
    elif acceptance.lower is not None:
        # In the tail the complement would lose its digits.
        accepted = errors.below(shifted - acceptance.lower)
    else:
        accepted = errors.above(shifted - acceptance.upper) if acceptance.upper is not None else np.ones_like(nodes)
    inside = np.ones(len(nodes), dtype=bool)
    if limits.lower is not None:
        inside &= nodes >= limits.lower
    if limits.upper is not None:
        inside &= nodes <= limits.upper
    return float(np.sum((mass * accepted)[~inside])), float(np.sum((mass * rejected)[inside]))


def _marks(errors: Output, acceptance: Limits) -> Floats:
    """True values at which an acceptance limit is a quantile of the results: panels follow the shape of the errors."""
    if not errors.u > 0:
        return np.empty(0)
    reach = np.array([errors.quantile(p) for p in _QUANTILES]) - errors.value
    return np.concatenate([end + reach for end in (acceptance.lower, acceptance.upper) if end is not None])


def quadrature(
    prior: Prior, u: float, limits: Limits, acceptance: Limits, further: Floats | None = None
) -> tuple[Floats, Floats]:
    """Nodes and weights over the support of the prior, with panels fine enough for prior and measurement.

    Gauss–Legendre panels end at the quantiles of the prior and at the multiples of u about every end of both intervals;
    and at `further` places.
    """
    probabilities = np.concatenate([[1e-300, 1e-100, 1e-30, 1e-15, 1e-9], np.linspace(1e-4, 0.9999, 101)])
    marks = [prior.quantile(probabilities), prior.quantile(1 - probabilities[3:5]), [prior.quantile(1.0)]]
    ends = [end for end in (limits.lower, limits.upper, acceptance.lower, acceptance.upper) if end is not None]
    marks += [end + u * np.linspace(-_REACH, _REACH, 153) for end in ends] + [np.array(ends)]
    marks += [] if further is None else [further]
    edges = np.unique(np.concatenate([np.asarray(mark, dtype=float) for mark in marks]))
    low, high = float(prior.quantile(0.0)), float(prior.quantile(1.0))
    edges = edges[np.isfinite(edges) & (edges >= low) & (edges <= high)]
    if isfinite(low):
        edges = np.unique(np.append(edges, low))
    base, weights = np.polynomial.legendre.leggauss(_NODES)
    half = np.diff(edges)[:, None] / 2
    middle = edges[:-1, None] + half
    return (middle + half * base).ravel(), (half * weights).ravel()


def global_guard_band(prior: Prior, measurement: float | Output, *, limits: Limits, risk: float) -> float:
    """Width w of the guard band for a stated global consumer's risk; 0 where the risk is smaller without one.

    Parameters
    ----------
    prior : Prior
    measurement : float or Output
        As for `global_risks`.
    limits : Limits
    risk : float
        Consumer's risk.

    Notes
    -----
    JCGM 106:2012, 9.5.4: an acceptance limit of 1.67 µm, w = 0.33 µm, for R_C = 0.001.
    """
    errors = _errors(measurement)

    def excess(w: float) -> float:
        return global_risks(prior, errors, limits=limits, acceptance=limits.shrunk(w))[0] - risk

    if excess(0.0) <= 0:
        return 0.0
    from scipy.optimize import brentq

    widest = _REACH * errors.u
    while widest < limits.half_width and excess(widest) > 0:
        widest *= 2.0
    return float(brentq(excess, 0.0, min(limits.half_width, widest), xtol=1e-10 * errors.u, rtol=1e-12))
