"""Levenberg–Marquardt within bounds, with undamped steps at the end."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from metrology.estimation.problem import Array, Point, Problem, Slope, evaluate, slope
from metrology.message import said

STEPS = 60
"""Largest number of derivatives taken in one search."""
CLOSE = 1e-5
"""Length of the last step, in standard uncertainties, below which the search has converged."""
FLAT = 1e-9
"""Relative gain of a step below which a search that cannot shorten its steps (kinks of contact) stands still."""
NEARLY = 10.0
"""Times the length of a last step within which a search has converged whose steps are used up: of a model that does
not fit, Gauss–Newton makes each step up to nine tenths of the one before, so that ten times as much is to come."""

RESOLVED = 1e-13
"""Part of the sum of squares below which rounding hides a change: 500 units in the last place."""

LAST, ROUNDED = 1e-9, 1e-6
"""Length of a step, in standard uncertainties, that changes no number of a report; below which rounding may make it."""
FINISHING = 20
"""Steps at most from a search that has converged: where a model fits badly each is half to nine tenths of the last."""

TRIES = 16
"""Dampings tried for one step."""
LEAST = 1e-8
"""Least damping that is not 0; with more, a narrow valley is no longer followed."""
AHEAD = 0.3
"""Part of a step at which the curvature along it is taken."""
ACROSS = 1e-6
"""Least damping of the second-order part of a step."""
BEND = 0.75
"""Twice the length of the second-order part of a step over that of the first, scaled by diag H, that is believed."""


@dataclass(frozen=True)
class Solution:
    """Where a search ended.

    Parameters
    ----------
    point : Point or None
        Values, residuals, cost; None where the model had no answer at the start.
    slope : Slope or None
        Derivatives there.
    status : {'converged', 'stalled', 'failed'}
        'stalled': the steps were used up, or no step lowers the sum though the gradient is not zero.
    steps : int
        Derivatives taken.
    sentence : str
        What happened.
    """

    point: Point | None
    slope: Slope | None
    status: Literal["converged", "stalled", "failed"]
    steps: int
    sentence: str

    @property
    def cost(self) -> float:
        """Sum that was minimised; infinite for a failed search."""
        return math.inf if self.point is None else self.point.cost


def solve(
    problem: Problem, start: Array | None = None, *, close: float = CLOSE, steps: int = STEPS, enough: float = 0.0
) -> Solution:
    """Minimise a problem from `start` on.

    Marquardt, J. SIAM 11 (1963) 431: (H + λ·diag H)·δ = −g, with H = JᵀJ + P. λ falls to exactly 0 near the end, since
    damped steps stop short along directions that the data hardly determine. Unknowns at a bound that the gradient
    presses against stay there.

    Parameters
    ----------
    problem : Problem
        What is minimised.
    start : ndarray, shape (p,), optional
        First values; those of the unknowns unless given.
    close : float
        Converged when a step is shorter than this many standard uncertainties.
    steps : int
        Largest number of derivatives.
    enough : float
        Converged when a step lowers the sum by less than this part of it, for a search that only prepares another.

    Returns
    -------
    Solution
        With status 'converged', 'stalled' or 'failed', and a sentence.
    """
    first = problem.start if start is None else np.clip(start, problem.low, problem.high)
    point = evaluate(problem, first)
    if point is None:
        return Solution(None, None, "failed", 0, said("the model has no answer at the start values"))
    return _descend(problem, point, close=close, steps=steps, enough=enough)


def finished(problem: Problem, theta: Array) -> tuple[Point, Slope] | None:
    """Carry a search that has converged on until rounding, or a kink, alone moves it; None without an answer there.

    What is then said of its end is the same on every processor: a search that ends within some part of a standard
    uncertainty has the digits below that from its way, and each processor sums in another order.

    Parameters
    ----------
    problem : Problem
        What is minimised.
    theta : ndarray, shape (p,)
        Where the search converged.

    Returns
    -------
    tuple of Point and Slope, or None
        The end.
    """
    point = evaluate(problem, theta)
    here = None if point is None else slope(problem, point)
    before = math.inf
    for _ in range(FINISHING):
        if point is None or here is None:
            return None
        step = _step(problem, point.theta, here, 0.0)
        length = _length(step, here)
        if length < LAST or length > (0.5 if length < ROUNDED else 0.9) * before:
            return point, here
        moved = evaluate(problem, np.clip(point.theta + step, problem.low, problem.high))
        there = None if moved is None else slope(problem, moved)
        if moved is None or there is None or moved.cost > point.cost * (1 + FLAT):
            return point, here
        point, here, before = moved, there, length
    return None if point is None or here is None else (point, here)


def _descend(problem: Problem, point: Point, *, close: float, steps: int, enough: float) -> Solution:
    damping, length = 1e-3, math.inf
    here = slope(problem, point)
    plain = close
    for count in range(1, steps + 1):
        if here is None:
            return Solution(point, None, "failed", count, said("the derivatives of the model have no answer there"))
        length, moved, damping = _advance(problem, point, here, damping)
        if moved is None:
            return _ended(point, here, count, length)
        gain = point.cost - moved.cost
        point = moved
        # Where the model does not fit, a standard uncertainty is longer than the noise alone says.
        close = plain * math.sqrt(max(1.0, point.chi_squared / max(problem.count, 1)))
        if length < close or gain < enough * point.cost:
            return Solution(point, here, "converged", count, said("converged in {count} steps", count=count))
        if gain < FLAT * (1 + point.cost) and length < 1e3 * close:
            return Solution(
                point, slope(problem, point), "converged", count, said("converged in {count} steps", count=count)
            )
        if gain <= 0.0 and length**2 <= RESOLVED * point.cost:
            # The step promises less than rounding lets the sum show, and the sum shows nothing: this is the minimum.
            return Solution(point, here, "converged", count, said("converged in {count} steps", count=count))
        # Near the end the parabola holds: leave the damping away altogether.
        damping = 0.0 if length < 1.0 else damping
        here = slope(problem, point)
    if length < NEARLY * close:
        return Solution(point, here, "converged", steps, said("converged in {count} steps", count=steps))
    return Solution(point, here, "stalled", steps, said("not converged within {count} steps", count=steps))


def _ended(point: Point, here: Slope, count: int, length: float) -> Solution:
    if length < 0.05:
        return Solution(point, here, "converged", count, said("converged in {count} steps", count=count))
    sentence = said("no step lowers the sum of squares after {count} steps", count=count)
    return Solution(point, here, "stalled", count, sentence)


def _advance(problem: Problem, point: Point, here: Slope, damping: float) -> tuple[float, Point | None, float]:
    """How far the minimum was, in standard uncertainties, the new point (None: none is better), and the next λ.

    A damped step is shorter than the way: the distance is that of the undamped one. A step that gains less than the
    straight line says is tried again, bent along the valley.
    """
    length = math.inf
    for _ in range(TRIES):
        step = _step(problem, point.theta, here, damping)
        length = _length(step, here)
        if length < 1e-12:
            return length, None, damping
        moved = _better(problem, point, step)
        promised = -2 * float(np.einsum("p,p->", step, here.gradient)) - _form(here.information, step)
        if moved is None or point.cost - moved.cost < 0.5 * promised:
            bent = _bent(problem, point, here, step, damping)
            other = None if bent is None else _better(problem, point, bent)
            moved = min((one for one in (moved, other) if one is not None), key=lambda one: one.cost, default=None)
        if moved is not None:
            left = length if damping == 0.0 else max(length, _length(_step(problem, point.theta, here, 0.0), here))
            return left, moved, damping / 8 if damping > LEAST else 0.0
        damping = max(damping * 8, LEAST)
    return length, None, damping


def _better(problem: Problem, point: Point, step: Array) -> Point | None:
    """Point at the end of a step, None where the sum of squares is larger there."""
    moved = evaluate(problem, np.clip(point.theta + step, problem.low, problem.high))
    return moved if moved is not None and moved.cost <= point.cost * (1 + RESOLVED) else None


def _bent(problem: Problem, point: Point, here: Slope, step: Array, damping: float) -> Array | None:
    """Step bent by the curvature of the model along it; None where that is too strong to be believed.

    Geodesic acceleration: Transtrum & Sethna, arXiv:1201.5885 (2012), eq. 9 and 15, with h = 0.3 and α = 0.75. It only
    has to lead back across the valley, not along it: hence a damping of its own.
    """
    ahead = evaluate(problem, np.clip(point.theta + AHEAD * step, problem.low, problem.high))
    if ahead is None:
        return None
    pull = np.zeros_like(step)
    with np.errstate(over="ignore", invalid="ignore"):  # A motion that ran away ahead: no bend, as said below.
        for block, part, now, then in zip(problem.blocks, here.blocks, point.residuals, ahead.residuals, strict=True):
            uses = np.array(block.uses)
            second = (2 / AHEAD) * ((then - now) / AHEAD - np.einsum("np,p->n", part, step[uses]))
            np.add.at(pull, uses, np.einsum("np,n->p", part, second))
    if not np.isfinite(pull).all():
        return None
    free = step != 0.0
    bend = np.zeros_like(step)
    bend[free] = -0.5 * _solved(here.information[np.ix_(free, free)], pull[free], max(damping, ACROSS))
    size = np.diag(here.information)
    return step + bend if 4 * float(np.sum(size * bend**2)) <= BEND**2 * float(np.sum(size * step**2)) else None


def _length(step: Array, here: Slope) -> float:
    return math.sqrt(max(_form(here.information, step), 0.0))


def _form(matrix: Array, vector: Array) -> float:
    """vᵀ·M·v."""
    return float(np.einsum("p,pq,q->", vector, matrix, vector))


def _step(problem: Problem, theta: Array, here: Slope, damping: float) -> Array:
    """Damped Gauss–Newton step of the unknowns that the bounds leave free."""
    step = np.zeros_like(theta)
    pressed = ((theta <= problem.low) & (here.gradient > 0)) | ((theta >= problem.high) & (here.gradient < 0))
    free = ~pressed
    for _ in range(len(theta)):
        if not free.any():
            break
        step = np.where(free, 0.0, np.where(pressed, 0.0, step))
        held = here.gradient + np.einsum("pq,q->p", here.information, step)
        step[free] = -_solved(here.information[np.ix_(free, free)], held[free], damping)
        target = theta + step
        over = free & ((target < problem.low) | (target > problem.high))
        if not over.any():
            break
        step[over] = np.clip(target[over], problem.low[over], problem.high[over]) - theta[over]
        free = free & ~over
    return step


def _solved(information: Array, gradient: Array, damping: float) -> Array:
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scaled = information / np.outer(size, size)
    scaled[np.diag_indices_from(scaled)] += damping
    found = _eliminated(scaled, gradient / size)
    if found is None:
        found = np.linalg.lstsq(scaled, gradient / size, rcond=1e-12)[0]
    solved: Array = found / size
    return solved


def _eliminated(matrix: Array, right: Array) -> Array | None:
    """Solution with a positive definite matrix, None where it is none in this arithmetic.

    Gauss's elimination by products of single numbers, which every processor rounds alike; LAPACK's sums are not.
    """
    rows, count = np.column_stack([matrix, right]), len(right)
    for at in range(count):
        if not rows[at, at] > 0.0:
            return None
        rows[at + 1 :, at:] -= np.outer(rows[at + 1 :, at] / rows[at, at], rows[at, at:])
    found = rows[:, count].copy()
    for at in reversed(range(count)):
        found[at] /= rows[at, at]
        found[:at] -= rows[:at, at] * found[at]
    return found
