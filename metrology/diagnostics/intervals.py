"""Uncertainties and 95 % intervals of what is found: by the parabola, or by the profile where that bends."""

from __future__ import annotations

import math

from metrology.diagnostics.subject import Fit
from metrology.estimation import Solution
from metrology.estimation.problem import Point, Slope
from metrology.estimation.profile import interval

NORMAL_95 = 1.959963984540054
DEAR = 10.0
"""Cost of a motion over that of the base model from which on no profile is followed: one takes some thirty fits."""


def ends(fit: Fit, at: int, u: float, *, curved: bool) -> tuple[float | None, float | None]:
    """95 % interval of unknown number `at`; None for an end that its range leaves open.

    Parameters
    ----------
    fit : Fit
        The model.
    at : int
        Which unknown.
    u : float
        Its standard uncertainty, with the colour of the noise.
    curved : bool
        Whether all other unknowns are to be sought anew at the ends (profile likelihood), as they have to be where
        several parameters of one effect stand for each other along a curved valley, and is not too long a search.
    """
    value, entry = float(fit.theta[at]), fit.problem.unknowns[at]
    if curved and fit.dear < DEAR and math.isfinite(u) and u > 0:
        found = interval(fit.problem, _solution(fit), at, u, math.sqrt(float(fit.covariance[at, at])))
        return found.low, found.high
    low, high = value - NORMAL_95 * u, value + NORMAL_95 * u
    return (low if low > entry.low else None), (high if high < entry.high else None)


def _solution(fit: Fit) -> Solution:
    point = Point(fit.theta, fit.residuals, fit.chi_squared, fit.penalty)
    return Solution(point, Slope(fit.slopes, fit.gradient, fit.information), "converged", 0, "")
