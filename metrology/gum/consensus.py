"""One value of a quantity by several methods: weighted mean with joint covariance, or with between-method scatter."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, sqrt

import numpy as np

from metrology.gum.inputs import Floats

SIGNIFICANCE = 0.05
"""Of the χ² test of consistency (Cox 2002, 5.1)."""


@dataclass(frozen=True, eq=False)
class Combined:
    """A consensus value of positive results, and how each of them stands to the others.

    Parameters
    ----------
    value, u, low, high : float
        Consensus value, standard uncertainty and ends of the coverage interval.
    weights : ndarray, shape (n,)
        Of ln y_i; they add up to one. Of strongly correlated results one may be negative.
    en : ndarray, shape (n,)
        E_n of each result against the consensus of the others, without a between-method scatter.
    statistic, p_value : float
        χ² of the weighted mean without a between-method scatter, n − 1 degrees of freedom, and its probability.
    birge : float
        Birge ratio √(χ²/(n − 1)).
    between : float
        Between-method standard deviation relative to the value; 0 where the results are consistent.
    dof : float, optional
        Degrees of freedom of the interval; None: normal.
    """

    value: float
    u: float
    low: float
    high: float
    weights: Floats
    en: Floats
    statistic: float
    p_value: float
    birge: float
    between: float
    dof: int | None

    @property
    def consistent(self) -> bool:
        """Whether the χ² test is passed."""
        return self.p_value >= SIGNIFICANCE


def combine(values: Floats, covariance: Floats, *, probability: float = 0.95) -> Combined:
    """Consensus of the same positive quantity by n ≥ 2 results.

    Generalised least squares of z = ln y with the covariance S_ij = V_ij/(y_i·y_j): ẑ = wᵀz, w = S⁻¹1/(1ᵀS⁻¹1),
    u²(ẑ) = 1/(1ᵀS⁻¹1). Scales that results share then act on all alike; of the values themselves the mean would lie
    below all of them (Peelle's puzzle). Where χ² = (z − ẑ)ᵀS⁻¹(z − ẑ) exceeds its 95 % quantile, S is replaced by
    S + τ²·I with τ such that χ² = n − 1, and the interval is that of Student's t with n − 1 degrees of freedom.

    Parameters
    ----------
    values : ndarray, shape (n,)
        y, above zero.
    covariance : ndarray, shape (n, n)
        V of the values, positive definite.
    probability : float
        Coverage probability.

    Returns
    -------
    Combined
        Consensus value with u and interval in the unit of the values, weights, χ², and E_n of each against the others.

    Notes
    -----
    M. G. Cox, Metrologia 39 (2002) 589, procedure A with correlation (5.1, A.1); R. C. Paule, J. Mandel,
    J. Res. NBS 87 (1982) 377; G. Knapp, J. Hartung, Statist. Med. 22 (2003) 2693, whose factor is 1 at this τ;
    ISO 13528:2022, 9.7, E_n.

    Examples
    --------
    >>> found = combine(np.array([100.0, 102.0]), np.diag([1.0, 1.0]))
    >>> round(found.value), round(found.u, 2), found.consistent
    (101, 0.71, True)
    """
    from scipy.special import chdtrc, ndtri, stdtrit

    z, scaled = np.log(values), covariance / np.outer(values, values)
    n, reach = len(z), float(ndtri((1 + probability) / 2))
    weights, u = _mean(scaled)
    statistic = _misfit(z, scaled)
    p_value = float(chdtrc(n - 1, statistic))
    between, dof, factor = 0.0, None, reach
    if p_value < SIGNIFICANCE:
        between, dof, factor = _between(z, scaled), n - 1, float(stdtrit(n - 1, (1 + probability) / 2))
        weights, u = _mean(scaled + between**2 * np.eye(n))
    mean = float(weights @ z)
    value = exp(mean)
    return Combined(
        value, value * u, exp(mean - factor * u), exp(mean + factor * u), weights, _against_others(z, scaled, reach),
        statistic, p_value, sqrt(statistic / (n - 1)), between, dof,
    )  # fmt: skip


def _mean(scaled: Floats) -> tuple[Floats, float]:
    """Weights of the mean by generalised least squares, and its standard uncertainty."""
    each = np.linalg.solve(scaled, np.ones(len(scaled)))
    return each / each.sum(), 1 / sqrt(float(each.sum()))


def _misfit(z: Floats, scaled: Floats) -> float:
    apart = z - float(_mean(scaled)[0] @ z)
    return float(apart @ np.linalg.solve(scaled, apart))


def _between(z: Floats, scaled: Floats) -> float:
    """τ at which χ² is n − 1 (Paule and Mandel); χ² falls with τ, and at √(n − 1) spreads of z it is below that."""
    from scipy.optimize import brentq

    n = len(z)
    most = float(np.ptp(z)) * sqrt(n)
    return float(brentq(lambda tau: _misfit(z, scaled + tau**2 * np.eye(n)) - (n - 1), 0.0, most, xtol=1e-12 * most))


def _against_others(z: Floats, scaled: Floats, reach: float) -> Floats:
    """E_n of each result against the mean of the others: (z_i − ẑ_others)/U of this difference."""
    found = []
    for i in range(len(z)):
        others = np.arange(len(z)) != i
        own = np.zeros(len(z))
        own[i] = 1.0
        own[others] = -_mean(scaled[np.ix_(others, others)])[0]
        found.append(float(own @ z) / (reach * sqrt(float(own @ scaled @ own))))
    return np.array(found)
