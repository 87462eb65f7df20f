"""The distribution of an output quantity: the one object that value, u, interval, probabilities and verdicts come from.

Where clause 8 of JCGM 101 confirms the GUM uncertainty framework it is Student's distribution (`Analytic`), elsewhere
that of the Monte Carlo draws themselves (`Empirical`): a probability is counted, not taken from a curve that does not
hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import Protocol

import numpy as np

from metrology.gum.inputs import Floats
from metrology.gum.intervals import intervals
from metrology.gum.risk import Limits, Prior, quadrature, tails

FEW = 1e-4
"""Probability below which one digit is given: of a million draws, a hundred and fewer."""
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SMALLEST = 1e-6
"""Probability below which no more is stated than that it is smaller: no tail of a measurement is known further out."""


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

    def below(self, x: float) -> float:
        """Probability of a value below x."""

    def above(self, x: float) -> float:
        """Probability of a value above x."""

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

    def below(self, x: float) -> float:
        """Probability of a value below x; exact in its tail."""
        return float(tails((x - self.value) / self.u, self.dof)) if self.u > 0 else float(self.value < x)

    def above(self, x: float) -> float:
        """Probability of a value above x; exact in its tail."""
        return float(tails((self.value - x) / self.u, self.dof)) if self.u > 0 else float(self.value > x)

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
        Mean and standard deviation of the draws; where they have none, their median and u by the framework.
    draws : ndarray, shape (M,)
        In ascending order.
    """

    value: float
    u: float
    draws: Floats
    dof: float = inf

    @property
    def resolution(self) -> float:
        """One draw."""
        return 1.0 / self.draws.size

    def below(self, x: float) -> float:
        """Share of the draws below x."""
        return float(np.searchsorted(self.draws, x, "left")) / self.draws.size

    def above(self, x: float) -> float:
        """Share of the draws above x."""
        return float(self.draws.size - np.searchsorted(self.draws, x, "right")) / self.draws.size

    def quantile(self, p: float) -> float:
        """Value that is not exceeded by a share p of the draws."""
        return float(self.draws[min(max(int(np.ceil(p * self.draws.size)) - 1, 0), self.draws.size - 1)])

    def interval(self, p: float) -> tuple[float, float]:
        """Shortest coverage interval (JCGM 101, 5.3.4)."""
        found = intervals(self.draws.copy(), p)
        return found.shortest_low, found.shortest_high

    def posterior(self, prior: Prior, limits: Limits, shift: float) -> tuple[float, float]:
        """Sums of the prior's density over the draws inside and outside of limits; the draws are the likelihood."""
        values = self.draws + shift
        return _parted(values, np.asarray(prior.density(values)), limits)


def _parted(values: Floats, mass: Floats, limits: Limits) -> tuple[float, float]:
    inside = np.ones(values.size, dtype=bool)
    if limits.lower is not None:
        inside &= values >= limits.lower
    if limits.upper is not None:
        inside &= values <= limits.upper
    return float(mass[inside].sum()), float(mass[~inside].sum())


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


def probability(p: float, resolution: float = 0.0) -> str:
    """A probability as it is printed: two digits, and none that is not known.

    Parameters
    ----------
    p : float
        From 0 to 1.
    resolution : float
        Smallest probability that can be distinguished from 0, such as one draw.

    Returns
    -------
    str
        Such as ``0.023`` or ``< 10⁻⁶``.

    Examples
    --------
    >>> probability(0.0228), probability(2.7e-15), probability(0.0, 1e-5), probability(1 - 1e-9)
    ('0.023', '< 10⁻⁶', '< 10⁻⁵', '> 1 − 10⁻⁶')
    >>> probability(7.2e-6)
    '7×10⁻⁶'
    """
    least = max(SMALLEST, resolution if isfinite(resolution) else SMALLEST)
    if least <= p < FEW:
        digit, _, exponent = f"{p:.0e}".partition("e")
        return f"{digit}×10{str(int(exponent)).translate(_SUPERSCRIPT)}"
    if least <= p <= 1 - least or p == 1.0:
        return f"{p:.2g}" if p <= 0.99 or p == 1.0 else f"{p:.{int(np.ceil(-np.log10(1 - p))) + 1}f}".rstrip("0")
    power = int(np.ceil(np.log10(least) - 1e-9))
    bound = "10" + str(power).translate(_SUPERSCRIPT)
    return f"< {bound}" if p < least else f"> 1 − {bound}"
