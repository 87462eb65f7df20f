"""From start values to the optimum of a model of runs: straight there, or along a growing horizon where that is far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from metrology.diagnostics.subject import LOST, Array
from metrology.estimation import Layout, MeasuredRun, Problem, solve
from metrology.estimation.problem import Point, evaluate
from metrology.estimation.response import Mask, View, masks, problem
from metrology.rig import Rig

WHOLE = View()
FIRST = (View(temper=4.0, beside=0.02), 0.3, 12)
"""View of a first look at the whole runs, how closely it is followed, derivatives at most."""
SETTLE = (FIRST, (View(beside=0.005), 0.05, 15), (WHOLE, 1e-2, 15))
"""Views, one after the other; their steps are counted, not timed, so that a fit repeats."""
ENOUGH = 1e-3
"""Part of the sum of squares for less than which a search that only prepares another takes no step."""
AGAIN = 3
"""Searches more at full weight, where the readings beside a contact, which carry none, are others at the optimum."""
HORIZONS = (2.0, 8.0, 30.0)
"""Natural periods after the first contact up to which the motion is followed, one after the other, from far off."""
GLANCE = HORIZONS[:2]
"""Those of a glance, which only compares models."""


@dataclass(frozen=True)
class Model:
    """A rig with its unknowns, and the runs that they are sought from."""

    rig: Rig
    runs: Sequence[MeasuredRun]
    layout: Layout

    @property
    def count(self) -> int:
        """Readings of the whole runs."""
        return sum(int(run.used(name).sum()) for run in self.runs for name in run.channels)

    def seen(self, theta: Array, view: View) -> tuple[Problem, list[Mask]] | None:
        """Problem in a view, with the readings that carry weight at these values; None without an answer."""
        use = masks(self.rig, self.runs, self.layout, theta, view)
        return None if use is None else (problem(self.rig, self.runs, self.layout, use, view), use)

    def point(self, theta: Array) -> Point | None:
        """Residuals and cost of the whole runs there; None without an answer."""
        seen = self.seen(theta, WHOLE)
        return evaluate(seen[0], theta) if seen else None

    def looked(self, theta: Array, view: View) -> tuple[float, int]:
        """Cost for each reading with weight there, infinite without an answer, and how many readings these are."""
        seen = self.seen(theta, view)
        point = evaluate(seen[0], theta) if seen else None
        if seen is None or point is None:
            return math.inf, 0
        return point.cost / max(seen[0].count, 1), seen[0].count

    def mean_cost(self, theta: Array, view: View = WHOLE) -> float:
        """Cost for each reading with weight there; infinite without an answer."""
        return self.looked(theta, view)[0]


def is_far(model: Model, theta: Array) -> bool:
    """Whether the motion has nothing to do with the readings there."""
    seen = model.seen(theta, WHOLE)
    point = evaluate(seen[0], theta) if seen else None
    return seen is None or point is None or point.chi_squared > LOST * seen[0].count


def grown(model: Model, theta: Array) -> tuple[Array, int]:
    """Values from which the whole runs can be followed, and the derivatives that it took."""
    total = 0
    for view in _horizons(model, HORIZONS):
        theta, steps = _followed(model, theta, view)
        total += steps
    return theta, total


def glanced(model: Model, theta: Array) -> tuple[float, float]:
    """Cost for each reading of the first moments after contact, fitted from `theta` on; infinite without an answer.

    With the derivatives that it took, in those of whole runs: as much fewer as the first moments have readings.
    """
    views, total = _horizons(model, GLANCE), 0
    for view in views:
        theta, steps = _followed(model, theta, view)
        total += steps
    cost, count = model.looked(theta, views[-1])
    return cost, total * count / model.count


def _horizons(model: Model, horizons: Sequence[float]) -> list[View]:
    """Views up to so many natural periods after the first contact."""
    contact = max(_first_contact(model.rig, run) for run in model.runs)
    period = 2 * math.pi * math.sqrt(model.rig.m / max(model.rig.k, 1e-12))
    return [replace(FIRST[0], until=contact + periods * period) for periods in horizons]


def _followed(model: Model, theta: Array, view: View) -> tuple[Array, int]:
    """Values after a search in one view that only prepares another, and the derivatives that it took."""
    _, close, steps = FIRST
    seen = model.seen(theta, view)
    solution = solve(seen[0], theta, close=close, steps=steps, enough=ENOUGH) if seen else None
    if solution is None or solution.point is None:
        return theta, 0
    return solution.point.theta, solution.steps


def _first_contact(rig: Rig, measured: MeasuredRun) -> float:
    """Time at which the module is first seen where the line is taut / s, else when it begins to move."""
    held = measured.run.held_until
    begun = measured.run.t0 if held is None else held
    if rig.attachment != "tether" or measured.x is None:
        return begun
    there = measured.stamps("x")[np.nan_to_num(measured.x, nan=-math.inf) >= rig.taut]
    return float(there[0]) if there.size else begun


@dataclass(frozen=True)
class Settled:
    """Optimum, whether a search used up its steps, and the derivatives that all took."""

    theta: Array
    spent: bool
    steps: int


def led(model: Model, theta: Array, far: Array) -> Settled:
    """Optimum by a growing horizon from `theta` on; a first look only where the model loses the motion all the same.

    Not worse than at `far`, where the motion was lost.
    """
    theta, before = grown(model, theta)
    theta, steps = _followed(model, theta, FIRST[0])
    if not is_far(model, theta):
        found = settled(model, theta)
        return replace(found, steps=found.steps + before + steps)
    costs = [math.inf if point is None else point.cost for point in (model.point(theta), model.point(far))]
    return Settled(theta if costs[0] <= costs[1] else far, True, before + steps)


def settled(model: Model, theta: Array, *, known: bool = False) -> Settled:
    """Optimum from values that follow the motion; only by the last view where the start is an optimum that is known.

    The readings beside a contact carry no weight: the search ends when they are those of the search before. Where they
    lead it from contact to contact, to ever worse ones, the best place that it passed counts, its start among them.
    """
    spent, last, steps_taken = False, None, 0
    best = theta, model.mean_cost(theta), False
    for view, close, steps in (*(SETTLE[-1:] if known else SETTLE), *AGAIN * SETTLE[-1:]):
        seen = model.seen(theta, view)
        if seen is None or _same(seen[1], last):
            break
        solution = solve(seen[0], theta, close=close, steps=steps)
        steps_taken += solution.steps
        if solution.point is None:
            break
        spent = solution.status == "stalled" and solution.steps == steps
        theta, last = solution.point.theta, seen[1] if view == WHOLE else None
        if (cost := model.mean_cost(theta)) <= best[1]:
            best = theta, cost, spent
        elif view == WHOLE:
            break
    return Settled(best[0], best[2], steps_taken)


def _same(one: Sequence[Mask], other: Sequence[Mask] | None) -> bool:
    if other is None:
        return False
    return all(np.array_equal(a[name], b[name]) for a, b in zip(one, other, strict=True) for name in a)
