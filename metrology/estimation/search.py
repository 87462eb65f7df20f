"""From start values to the optimum: directly where that works, else along a growing horizon and from several starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from metrology.estimation.measured import MeasuredRun
from metrology.estimation.priors import Layout
from metrology.estimation.problem import Array, Problem
from metrology.estimation.response import Mask, View, cut, masks, motion, problem, values_of
from metrology.estimation.solver import Solution, finished, solve
from metrology.rig import Rig

GOOD = 1.5
"""χ² for each reading up to which the first search is believed."""
VAIN = 2
"""Searches in a row that may end no better than the best one before the rest is left away."""
FACTORS = ((0.7, 0.5), (1.4, 2.0), (0.5, 1.0), (2.0, 1.0))
"""Further starts: factors on the stiffness and damping that the rig states."""
GROWING = ((2.0, 10.0, 0.05), (8.0, 3.0, 0.02), (30.0, 1.0, 0.005))
"""Horizon in natural periods after the first contact, tempering of the noise, distance from contact / s."""
SETTLING = ((View(smooth=True), 0.3, 0.02), (View(beside=0.01), 0.1, 0.002), (View(), 1e-2, 0.0))
"""Views of the whole runs, one after the other, how closely each is followed in u, and `enough`."""
BUDGET = 240
"""Derivatives of all runs that one search may take, all starts together; counted, not timed, so that a fit repeats."""


@dataclass(frozen=True)
class Found:
    """Best optimum of all searches, the problem as it was weighted there, and how many derivatives that took.

    `spent`: whether the budget ended the search before all starts that called for it were tried.
    """

    problem: Problem
    solution: Solution
    steps: int
    searches: int = 1
    spent: bool = False

    @property
    def reduced(self) -> float:
        """χ² of the readings for each reading."""
        point = self.solution.point
        return math.inf if point is None else point.chi_squared / max(self.problem.count, 1)


def search(
    rig: Rig, runs: Sequence[MeasuredRun], layout: Layout, starts: Sequence[Array], *, near: bool = False
) -> Found | None:
    """Best optimum; None where the model has no answer at any start.

    The first start is tried directly. If that leaves more than `GOOD`, every start goes along a growing horizon with
    tempered noise, until two searches end at the same place, `VAIN` in a row were no better, or `BUDGET` is spent. The
    lowest χ² for each reading counts. Where the first start is `near` an optimum, only that is tried.

    Parameters
    ----------
    rig : Rig
        As stated.
    runs : sequence of MeasuredRun
        In the order of the layout.
    layout : Layout
        Of the unknowns.
    starts : sequence of ndarray, shape (p,)
        First values, the best first.
    near : bool
        Whether the first start is near an optimum.

    Returns
    -------
    Found or None
        The optimum with its problem, and what was spent on it.
    """
    best: Found | None = None
    steps = searches = vain = 0
    spent = False
    for way, start in ((_settled, starts[0]), *((_grown, start) for start in starts if not near)):
        spent = steps >= BUDGET
        if spent:
            break
        found = way(rig, runs, layout, start, BUDGET - steps)
        searches += 1
        if found is None:
            continue
        steps += found.steps
        if best is not None and _same(best, found):
            best = min(best, found, key=lambda one: one.reduced)
            break
        vain = vain + 1 if best is not None and found.reduced > 0.95 * best.reduced else 0
        if best is None or found.reduced < best.reduced:
            best = found
        if vain == VAIN or (best.reduced < GOOD and best.solution.status == "converged"):
            break
    if best is None:
        return None
    solution = best.solution
    if solution.status == "converged" and solution.point is not None:
        end = finished(best.problem, solution.point.theta)
        solution = solution if end is None else replace(solution, point=end[0], slope=end[1])
    return Found(best.problem, solution, steps, searches, spent)


def _same(one: Found, other: Found) -> bool:
    a, b = one.solution, other.solution
    if a.point is None or b.point is None or a.slope is None or {a.status, b.status} != {"converged"}:
        return False
    apart = a.point.theta - b.point.theta
    return float(apart @ a.slope.information @ apart) < 0.01 * one.reduced


def _grown(rig: Rig, runs: Sequence[MeasuredRun], layout: Layout, start: Array, budget: int) -> Found | None:
    theta, steps = start, 0
    contact, period = _first_contact(rig, runs, layout, start)
    last = max(measured.run.end for measured in runs)
    for periods, temper, beside in GROWING:
        until = contact + periods * period
        view = View(until if until < last else math.inf, temper, beside, smooth=True)
        use = masks(rig, runs, layout, theta, view)
        if use is None:
            return None
        most = min(15, budget - steps)
        solution = solve(problem(rig, runs, layout, use, view), theta, close=0.02, steps=most, enough=0.01)
        if solution.point is None:
            return None
        theta, steps = solution.point.theta, steps + solution.steps
        if steps >= budget or (until >= last and temper == 1.0):
            break
    found = _settled(rig, runs, layout, theta, max(budget - steps, 1))
    return None if found is None else replace(found, steps=found.steps + steps)


def _settled(rig: Rig, runs: Sequence[MeasuredRun], layout: Layout, start: Array, budget: int) -> Found | None:
    """Search at full weight until the readings beside a contact, which carry none, are those of a search before."""
    theta, found, last, steps = start, None, len(SETTLING) - 1, 0
    seen: list[Sequence[Mask]] = []
    for turn in range(last + 5):
        view, close, enough = SETTLING[min(turn, last)]
        use = masks(rig, runs, layout, theta, view)
        if use is None or steps >= budget or any(_unchanged(use, before) for before in seen):
            break
        posed = problem(rig, runs, layout, use, view)
        solution = solve(posed, theta, close=close, steps=min(25, budget - steps), enough=enough)
        if solution.point is None:
            break
        steps += solution.steps
        found, theta = Found(posed, solution, steps), solution.point.theta
        if turn >= last:
            seen.append(use)
    return found


def _unchanged(one: Sequence[Mask], other: Sequence[Mask]) -> bool:
    return all(np.array_equal(a[name], b[name]) for a, b in zip(one, other, strict=True) for name in a)


def _first_contact(rig: Rig, runs: Sequence[MeasuredRun], layout: Layout, theta: Array) -> tuple[float, float]:
    """Latest first contact of any run / s, and the natural period / s, at the start values."""
    latest = -math.inf
    for at, measured in enumerate(runs):
        moved = motion(rig, cut(measured, math.inf), values_of(layout, at, theta))
        taut = [] if moved is None else [event.t for event in moved.events if event.kind == "taut"]
        latest = max(latest, min(taut, default=measured.run.t0))
    period = 2 * math.pi * math.sqrt(rig.m / rig.k) if rig.k > 0 else measured.run.end
    return latest, period


def starts(rig: Rig, layout: Layout, extra: Sequence[dict[str, float]] = ()) -> list[Array]:
    """First values: the stated ones, those that the caller adds, and others for the stiffness and damping.

    Parameters
    ----------
    rig : Rig
        As stated.
    layout : Layout
        Of the unknowns.
    extra : sequence of dict of str to float
        First values of some unknowns, tried before the others.

    Returns
    -------
    list of ndarray, shape (p,)
        Within the bounds; the stated values first.
    """
    stated = np.array([entry.start for entry in layout.unknowns])
    names = [entry.name for entry in layout.unknowns]
    wanted = [dict(one) for one in extra]
    for on_k, on_c in FACTORS:
        wanted.append({"k": rig.k * on_k, "c": rig.c * on_c})
    found = [stated]
    for one in wanted:
        theta = stated.copy()
        for name, value in one.items():
            if name in names:
                at = names.index(name)
                entry = layout.unknowns[at]
                theta[at] = float(np.clip(value, entry.low, entry.high))
        found.append(theta)
    return found
