"""Law of propagation of uncertainty: sensitivities, combined u, effective degrees of freedom (JCGM 100:2008, 5, G)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf, isfinite, nan, sqrt
from operator import mul

import numpy as np

from metrology.gum.evaluation import Coverage, Measurand
from metrology.gum.inputs import Floats, Knowledge
from metrology.gum.joint import Joint, joint
from metrology.gum.linear import Linear, linearise
from metrology.message import said


class Law:
    """The GUM uncertainty framework applied to all measurands.

    Attributes
    ----------
    contributions : list of list of float
        Signed c_a·u_a of every measurand (rows) and term (columns).
    products : list of list of float
        Their products with the correlation matrix of the terms, Σ_b r_ab·c_b·u_b.
    variances : list of float
        u² of every measurand, Σ_a c_a·u_a Σ_b r_ab·c_b·u_b.
    """

    def __init__(self, linear: tuple[Linear, ...], joint: Joint) -> None:
        self.linear = linear
        self.joint = joint
        terms = [(term.input.name, u) for term, u in zip(joint.terms, joint.u, strict=True)]
        self.contributions = [[line.sensitivities.get(name, 0.0) * u for name, u in terms] for line in linear]
        self.products = joint.times(self.contributions)
        self.variances: list[float] = []
        self._u: list[float] = []
        self._freedoms: list[tuple[float | None, str]] = []
        for line, parts, products in zip(linear, self.contributions, self.products, strict=True):
            variance = sum(map(mul, parts, products))  # of a few terms in less time than as arrays
            u = nan if line.failure else sqrt(max(variance, 0.0))
            self.variances.append(variance)
            self._u.append(u)
            self._freedoms.append(self._freedom(line, u, parts))

    def u(self, row: int) -> float:
        """Combined standard uncertainty (JCGM 100:2008 5.1.2, 5.2.2); NaN where the law fails."""
        return self._u[row]

    def dof(self, row: int) -> tuple[float | None, str]:
        """Effective degrees of freedom; None, with the reason, where they are infinite or undefined.

        Welch–Satterthwaite, ν = u⁴ / Σ u_j⁴/ν_j, over contributions that are independent of one another: simultaneous
        readings form one contribution with ν = n − 1, correlated inputs without finite degrees of freedom another.

        Source: JCGM 100:2008 G.4.1.
        """
        return self._freedoms[row]

    def _freedom(self, line: Linear, u: float, parts: list[float]) -> tuple[float | None, str]:
        if not u > 0:
            reason = line.failure or said("the GUM uncertainty framework gives u = 0")
            return None, said("undefined: {reason}", reason=reason)
        if self.joint.stated and (culprits := self._correlated_finite(line.sensitivities)):
            reason = said(
                "a correlation is stated for {names:comma}, of finite degrees of freedom; the Welch–Satterthwaite "
                "formula asks for independent inputs, so there is no coverage factor and the Monte Carlo interval is "
                "used. Simultaneous readings given as an ensemble would have ν = n − 1",
                names=tuple(culprits),
            )
            return None, said("undefined: {reason}", reason=reason)
        total = sum((self._variance(parts, rows) / u**2) ** 2 / dof for rows, dof in self.joint.scatters)
        if total == 0:
            return None, said("infinite: every contribution is taken as exactly known")
        return 1 / total, ""

    def _correlated_finite(self, sensitivities: Mapping[str, float]) -> list[str]:
        """Inputs with finite ν that are correlated, by statement, with another input that contributes too."""
        active = {name for pair in self.joint.stated for name in pair if all(sensitivities.get(n) for n in pair)}
        if not active:
            return []
        finite = (term.input.name for term in self.joint.terms if isfinite(term.component.dof) and term.component.u)
        return [name for name in dict.fromkeys(finite) if name in active]

    def _variance(self, parts: list[float], rows: list[int]) -> float:
        """Variance of the sum of some of a measurand's contributions `parts`."""
        if len(rows) == 1:
            return parts[rows[0]] ** 2
        own = np.array([parts[row] for row in rows])
        return float(own @ self.joint.among(rows) @ own) if own.any() else 0.0

    def coverage(self, row: int, probability: float) -> Coverage:
        """Interval y ± k·u with k the quantile of Student's distribution (JCGM 100:2008 G.3, G.6.4)."""
        dof, note = self.dof(row)
        value, u = self.linear[row].value, self.u(row)
        if u == 0:
            return Coverage(probability, None, value, value)
        if note.startswith("undefined"):
            return Coverage(probability, None, None, None)
        k = coverage_factor(probability, inf if dof is None else dof)
        return Coverage(probability, k, value - k * u, value + k * u)

    def coefficients(self) -> tuple[tuple[float | None, ...], ...]:
        """Correlation coefficients between the outputs; None where a u is zero or undefined."""
        return tuple(tuple(self._coefficient(i, j, one) for j, one in enumerate(line))
                     for i, line in enumerate(self.covariance.tolist()))  # fmt: skip

    def _coefficient(self, i: int, j: int, covariance: float) -> float | None:
        if not (self._u[i] > 0 and self._u[j] > 0):
            return None
        return 1.0 if i == j else min(1.0, max(-1.0, covariance / (self._u[i] * self._u[j])))

    @property
    def covariance(self) -> Floats:
        """Covariance matrix of the outputs, C V Cᵀ (JCGM 102:2011 6.2.1.3)."""
        shape = len(self.linear), len(self.joint.terms)
        found = np.reshape(self.contributions, shape) @ np.reshape(self.products, shape).T
        return np.asarray((found + found.T) / 2)


def effective_dof(parts: Iterable[tuple[float, float]]) -> float:
    """Effective degrees of freedom of a sum of independent parts, ν = u⁴ / Σ u_j⁴/ν_j (JCGM 100:2008 G.4.1).

    Parameters
    ----------
    parts : iterable of (float, float)
        Variance and degrees of freedom of each part.

    Returns
    -------
    float
        ν, infinite where every part is taken as known.

    Examples
    --------
    >>> effective_dof([(1.0, 4.0), (1.0, float("inf"))])
    16.0
    """
    known = list(parts)
    total = sum(variance for variance, _ in known)
    least = sum((variance / total) ** 2 / dof for variance, dof in known) if total > 0 else 0.0
    return 1 / least if least else inf


def coverage_factor(probability: float, dof: float = inf) -> float:
    """Coverage factor k of the two-sided interval y ± k·u (JCGM 100:2008 G.3.4, Table G.2).

    Parameters
    ----------
    probability : float
        Coverage probability, above 0 and below 1.
    dof : float
        Degrees of freedom; a normal distribution where infinite.

    Returns
    -------
    float
        k, the quantile of the t-distribution at (1 + p)/2.

    Examples
    --------
    >>> round(coverage_factor(0.99, 16), 2), round(coverage_factor(0.95), 2)
    (2.92, 1.96)
    """
    import scipy.special

    tail = (1 - probability) / 2
    return -float(scipy.special.stdtrit(dof, tail) if isfinite(dof) else scipy.special.ndtri(tail))


def propagate(measurands: Sequence[Measurand], knowledge: Knowledge) -> Law:
    """Apply the law to every measurand; the joint knowledge is limited to the inputs that any of them reads.

    Parameters
    ----------
    measurands : sequence of Measurand
        In order of use.
    knowledge : Knowledge
        The inputs, in SI.

    Returns
    -------
    Law
        Covariance, degrees of freedom and contributions on demand.

    Raises
    ------
    MetrologyError
        As `linearise`.

    Notes
    -----
    JCGM 100:2008 5.1.2, 5.2.2; JCGM 102:2011 6.2.
    """
    linear = linearise(measurands, knowledge)
    return Law(linear, joint(knowledge, (name for line in linear for name in line.reads)))
