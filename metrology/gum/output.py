"""The distribution of an output quantity: the one object that value, u, interval, probabilities and verdicts come from.

Where clause 8 of JCGM 101 confirms the GUM uncertainty framework it is Student's distribution (`Analytic`), elsewhere
that of the Monte Carlo draws themselves (`Empirical`): a probability is counted, not taken from a curve that does not
hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, Protocol

import numpy as np

from metrology.gum.inputs import Floats
from metrology.gum.intervals import intervals
from metrology.gum.risk import Limits, Prior, quadrature, tails

_UNSEEN = 3.0
"""−ln 0.05: a probability above 3/M shows in one of M draws at least, with 95 %."""
OFF_CENTRE = 0.025
"""Part of its width by which the middle of an interval may lie off the value and still be given as ± U."""


class Output(Protocol):
    """What is known of an output quantity."""

    @property
    def value(self) -> float:
        """Estimate."""

    @property
    def u(self) -> float:
        """Standard uncertainty."""

    @property
    def dof(self) -> float:
        """Degrees of freedom of `u`."""

    @property
    def resolution(self) -> float:
        """Smallest probability that is distinguished from zero; 0 for one without a limit."""

    def below(self, x: Any) -> Any:
        """Probability of a value below x, a number or an array."""

    def above(self, x: Any) -> Any:
        """Probability of a value above x, a number or an array."""

    def quantile(self, p: float) -> float:
        """Value that is not exceeded with probability p."""

    def interval(self, p: float) -> tuple[float, float]:
        """Coverage interval that is reported: of probability p."""

    def posterior(self, prior: Prior, limits: Limits, shift: float) -> tuple[float, float]:
        """Weight inside and outside of limits of prior · likelihood, the result moved by `shift`; not normalised."""


@dataclass(frozen=True)
class Analytic:
    """Scaled and shifted t distribution, normal for infinite degrees of freedom (JCGM 100, G.3; JCGM 101, 6.4.9).

    Parameters
    ----------
    value, u : float
    dof : float
        Above zero.

    Examples
    --------
    >>> round(Analytic(13.6, 1.8).below(16.3), 4)
    0.9332
    """

    value: float
    u: float
    dof: float = inf
    resolution: float = 0.0

    def below(self, x: Any) -> Any:
        """Probability of a value below x; exact in its tail."""
        return _plain(tails((x - self.value) / self.u, self.dof) if self.u > 0 else np.less(self.value, x))

    def above(self, x: Any) -> Any:
        """Probability of a value above x; exact in its tail."""
        return _plain(tails((self.value - x) / self.u, self.dof) if self.u > 0 else np.greater(self.value, x))

    def quantile(self, p: float) -> float:
        """Value that is not exceeded with probability p."""
        from scipy.special import ndtri, stdtrit

        return self.value + self.u * float(ndtri(p) if self.dof == inf else stdtrit(self.dof, p))

    def interval(self, p: float) -> tuple[float, float]:
        """Coverage interval value ± k·u."""
        half = self.quantile((1 + p) / 2) - self.value
        return self.value - half, self.value + half

    def posterior(self, prior: Prior, limits: Limits, shift: float) -> tuple[float, float]:
        """Integrals of prior · likelihood inside and outside of limits, by quadrature."""
        centre = Limits(self.value + shift, self.value + shift)
        nodes, weights = quadrature(prior, self.u, limits, centre)
        mass = weights * prior.density(nodes) * self._likelihood((nodes - self.value - shift) / self.u)
        return _parted(nodes, mass, limits)

    def _likelihood(self, z: Floats) -> Floats:
        """Density of the distribution at z, up to a factor."""
        if self.dof == inf:
            return np.exp(-0.5 * z**2)
        return np.asarray((1 + z**2 / self.dof) ** (-(self.dof + 1) / 2))


@dataclass(frozen=True, eq=False)
class Empirical:
    """Distribution of Monte Carlo draws (JCGM 101, 7.5 to 7.7).

    Parameters
    ----------
    value, u : float
        Mean and standard deviation of the draws (7.6); where these have none, see `without_moments`.
    draws : ndarray, shape (M,)
        In any order.
    """

    value: float
    u: float
    draws: Floats
    dof: float = inf

    @cached_property
    def ordered(self) -> Floats:
        """Draws in ascending order; many a result is asked for no probability, and sorting is a third of its time."""
        return np.sort(self.draws)

    @property
    def resolution(self) -> float:
        """3/M, the upper limit of a probability of which M draws show nothing, with 95 %."""
        return _UNSEEN / self.draws.size

    def below(self, x: Any) -> Any:
        """Share of the draws below x."""
        return _plain(np.searchsorted(self.ordered, x, "left") / self.draws.size)

    def above(self, x: Any) -> Any:
        """Share of the draws above x."""
        return _plain((self.draws.size - np.searchsorted(self.ordered, x, "right")) / self.draws.size)

    def quantile(self, p: float) -> float:
        """Value that is not exceeded by a share p of the draws."""
        return float(self.ordered[min(max(int(np.ceil(p * self.draws.size)) - 1, 0), self.draws.size - 1)])

    def interval(self, p: float) -> tuple[float, float]:
        """Shortest interval where it is clearly shorter than the symmetric one, else that one (JCGM 101, 5.3.4)."""
        return intervals(self.draws.copy(), p).reported

    def posterior(self, prior: Prior, limits: Limits, shift: float) -> tuple[float, float]:
        """Sums of the prior's density over the draws inside and outside of limits; the draws are the likelihood."""
        values = self.ordered + shift
        return _parted(values, np.asarray(prior.density(values)), limits)


def _parted(values: Floats, mass: Floats, limits: Limits) -> tuple[float, float]:
    inside = np.ones(values.size, dtype=bool)
    if limits.lower is not None:
        inside &= values >= limits.lower
    if limits.upper is not None:
        inside &= values <= limits.upper
    return float(mass[inside].sum()), float(mass[~inside].sum())


def _plain(found: Any) -> Any:
    """An array as it is, a single number as a float."""
    return float(found) if np.ndim(found) == 0 else np.asarray(found, dtype=float)


def without_moments(draws: Floats, p: float) -> Empirical:
    """Distribution of draws that have no standard deviation: with their median, and with u by their interval.

    Parameters
    ----------
    draws : ndarray, shape (M,)
        In any order.
    p : float
        Coverage probability of the interval.

    Returns
    -------
    Empirical
        Its u is half the width of the interval that is reported over the coverage factor of a normal distribution, so
        that U = k·u holds for value, u, U and interval alike.

    Notes
    -----
    JCGM 100:2008 4.3.4; JCGM 101:2008 6.4.9.4.

    Examples
    --------
    >>> round(without_moments(np.tan(np.pi * (np.arange(1, 1000) / 1000 - 0.5)), 0.95).u, 1)
    6.4
    """
    from scipy.special import ndtri

    ordered = np.sort(draws)
    low, high = intervals(ordered.copy(), p).reported
    return Empirical(float(ordered[ordered.size // 2]), (high - low) / 2 / float(ndtri((1 + p) / 2)), ordered)


def is_centred(value: float, low: float, high: float) -> bool:
    """Whether a value lies in the middle of its interval, so that this is given as value ± U.

    Parameters
    ----------
    value : float
        Estimate.
    low, high : float
        Ends of the interval.

    Returns
    -------
    bool
        Within `OFF_CENTRE` of the width.

    Examples
    --------
    >>> is_centred(0.0, -3.9, 4.0), is_centred(0.0, -3.0, 4.0)
    (True, False)
    """
    return abs(0.5 * (low + high) - value) <= OFF_CENTRE * (high - low)


def reach(output: Output, p: float) -> tuple[float, float]:
    """How far the reported interval reaches below and above the value: U on both sides where it is value ± U.

    Parameters
    ----------
    output : Output
        Distribution of the result.
    p : float
        Coverage probability.

    Returns
    -------
    tuple of float
        Two distances, in the unit of the result.
    """
    low, high = output.interval(p)
    if is_centred(output.value, low, high):
        return ((high - low) / 2,) * 2
    return output.value - low, high - output.value


def expanded(output: Output, p: float) -> float:
    """Expanded uncertainty U: half the width of the coverage interval that is reported (JCGM 101, 5.3.1; VIM 2.35).

    Parameters
    ----------
    output : Output
        Distribution of the result.
    p : float
        Coverage probability.

    Returns
    -------
    float
        U, in the unit of the result.
    """
    low, high = output.interval(p)
    return (high - low) / 2
