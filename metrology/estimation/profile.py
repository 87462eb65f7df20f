"""Profile likelihood: the interval of one unknown where the parabola is wrong or the range ends."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from metrology.estimation.covariance import inverse
from metrology.estimation.problem import Array, Point, Problem, Slope, evaluate
from metrology.estimation.solver import Solution, solve

NORMAL_95, NORMAL_95_ONE_SIDED = 1.959963984540054, 1.6448536269514722
CURVED = 0.15
"""Relative departure of the profile from the parabola, as a length, from which on the profile gives the interval."""


CHORDS = 6
"""Steps with the derivatives of the optimum before the search is done in full."""
SHORT = 0.05
"""Length of such a step, in standard uncertainties, that changes Δχ² by no more than its square."""


@dataclass(frozen=True)
class Interval:
    """95 % interval of one unknown: ends (None: open), and how it was found."""

    low: float | None
    high: float | None
    kind: Literal["parabola", "profile", "one-sided"]


def interval(problem: Problem, solution: Solution, at: int, u: float, bread: float) -> Interval:
    """95 % interval of unknown number `at`.

    Where Δχ², all others sought anew, follows the parabola at both ends of θ̂ ± 1.96·u to 15 %, that is the interval;
    else the ends are where Δχ² reaches 1.96²·(u/u_bread)² (Venzon & Moolgavkar, Appl. Statist. 37 (1988) 87, with the
    variance of the sandwich). A range that ends inside the interval leaves a one-sided bound.

    Parameters
    ----------
    problem : Problem
        What was minimised.
    solution : Solution
        Its optimum.
    at : int
        Which unknown.
    u : float
        Its standard uncertainty, in its unit.
    bread : float
        The standard uncertainty that H⁻¹ alone gives.

    Returns
    -------
    Interval
        Ends in the unit of the unknown, None where open, and how they were found.
    """
    assert solution.point is not None
    value, entry = float(solution.point.theta[at]), problem.unknowns[at]
    stretch = u / bread if bread > 0 else 1.0
    if value - NORMAL_95 * u <= entry.low or value + NORMAL_95 * u >= entry.high:
        lower = value - NORMAL_95 * u <= entry.low
        side = NORMAL_95_ONE_SIDED * (1 if lower else -1)
        end = _crossing(problem, solution, at, (side, u, stretch))
        return Interval(None, end, "one-sided") if lower else Interval(end, None, "one-sided")
    ends = [_crossing(problem, solution, at, (side, u, stretch)) for side in (-NORMAL_95, NORMAL_95)]
    straight = [value - NORMAL_95 * u, value + NORMAL_95 * u]
    curved = any(abs(end - line) > CURVED * NORMAL_95 * u for end, line in zip(ends, straight, strict=True))
    return Interval(ends[0], ends[1], "profile") if curved else Interval(straight[0], straight[1], "parabola")


def _crossing(problem: Problem, solution: Solution, at: int, wanted: tuple[float, float, float]) -> float:
    """Value at which √Δχ² is `side` times the stretch of the sandwich; secant steps, at most four."""
    side, u, stretch = wanted
    assert solution.point is not None
    value, entry = float(solution.point.theta[at]), problem.unknowns[at]
    target = abs(side) * stretch
    reach = side * u
    for _ in range(4):
        trial = float(np.clip(value + reach, entry.low, entry.high))
        rise = _rise(problem, solution, at, trial)
        if not math.isfinite(rise) or rise <= 0:
            return value + reach
        depth = math.sqrt(rise)
        if abs(depth / target - 1) < 0.5 * CURVED or trial in (entry.low, entry.high):
            return trial
        reach *= min(max(target / depth, 0.25), 4.0)
    return value + reach


def _rise(problem: Problem, solution: Solution, at: int, value: float) -> float:
    """Δχ² with one unknown held at a value, all others sought anew.

    Steps with the derivatives of the optimum (a chord method): one evaluation each in place of two for every unknown.
    They serve as long as each is well shorter than the one before; else the search is done in full.
    """
    assert solution.point is not None
    assert solution.slope is not None
    entry = problem.unknowns[at]
    unknowns = list(problem.unknowns)
    unknowns[at] = replace(entry, start=value, low=value, high=value)
    held = Problem(tuple(unknowns), problem.blocks)
    theta = solution.point.theta.copy()
    theta[at] = value
    information = solution.slope.information
    others = [index for index in range(len(unknowns)) if index != at]
    inner = inverse(information[np.ix_(others, others)])
    theta[others] -= inner @ information[others, at] * (value - solution.point.theta[at])
    close = SHORT * math.sqrt(max(1.0, solution.point.chi_squared / max(problem.count, 1)))
    before = math.inf
    for _ in range(CHORDS):
        theta = np.clip(theta, held.low, held.high)
        point = evaluate(held, theta)
        if point is None:
            break
        step = -inner @ _gradient(held, point, solution.slope)[others]
        length = math.sqrt(max(float(step @ information[np.ix_(others, others)] @ step), 0.0))
        if length < close:
            return point.cost - solution.cost
        if length > 0.3 * before:
            break
        theta[others] += step
        before = length
    return solve(held, theta, close=0.03, steps=8).cost - solution.cost


def _gradient(problem: Problem, point: Point, near: Slope) -> Array:
    """Half the gradient of the sum at `point` with the derivatives of a place nearby."""
    found: Array = problem.precision * (point.theta - problem.mean)
    for block, residual, slopes in zip(problem.blocks, point.residuals, near.blocks, strict=True):
        np.add.at(found, np.array(block.uses), residual @ slopes)
    return found
