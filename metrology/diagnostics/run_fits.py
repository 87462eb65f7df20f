"""Fits of runs on the rig at the values where the search settled: what a motion costs there, and whether it is lost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from metrology.diagnostics import settling
from metrology.diagnostics.plain import FAR
from metrology.diagnostics.settling import Model
from metrology.diagnostics.subject import LOST, Array, Fit
from metrology.estimation import MeasuredRun
from metrology.estimation.problem import Point, evaluate, slope
from metrology.estimation.response import motion, problem, values_of

PLAIN = 80
"""Steps of an integration that cost as much as a motion without any."""
EXACT = 12
"""States, squared, of a linear motion that costs as much as the base model's: a third of what others do."""


def begun(model: Model, values: Mapping[str, float]) -> Array:
    """Values to begin from, within their bounds."""
    found = np.array([values.get(entry.name, entry.start) for entry in model.layout.unknowns])
    low, high = (np.array([getattr(entry, side) for entry in model.layout.unknowns]) for side in ("low", "high"))
    clipped: Array = np.clip(found, low, high)
    return clipped


def fitted(effects: tuple[str, ...], model: Model, found: settling.Settled, usual: int) -> Fit | None:
    """Fit of the model with these effects where it settled; `usual`: how many unknowns the base model has."""
    theta = found.theta
    seen = model.seen(theta, settling.WHOLE)
    if seen is None:
        return None
    posed, use = seen
    point = evaluate(posed, theta)
    here = slope(posed, point) if point is not None else None
    if point is None or here is None:
        return None
    # By the masks, not by residuals that are zero: a slack cell often reads exactly what the model says.
    used = tuple(
        np.concatenate([marks[name] for name in run.channels]) for run, marks in zip(model.runs, use, strict=True)
    )
    full = full_residuals(model, point)
    return Fit(
        effects, posed, point.theta, point.residuals, here.blocks, here.information, point.penalty, full, used,
        spent=found.spent, steps=found.steps, dear=_dear(model, theta, usual),
    )  # fmt: skip


def _dear(model: Model, theta: Array, usual: int) -> float:
    """What a motion with its derivatives costs there, over one of the base model: by its matrices or its steps."""
    moved = [motion(model.rig, run.run, values_of(model.layout, at, theta)) for at, run in enumerate(model.runs)]
    known = [one for one in moved if one is not None]
    steps = sum(one.steps for one in known) / max(len(known), 1)
    states = max((one.states for one in known), default=2)
    more = len(model.layout.unknowns) / max(usual, 1)
    return max(1.0, 1.0 + steps / PLAIN, states**2 * more / (4 if steps else EXACT))


def full_residuals(model: Model, point: Point) -> tuple[Array, ...]:
    """Residuals of all readings at a point, those without weight as well."""
    everything = [{name: run.used(name) for name in run.channels} for run in model.runs]
    whole = evaluate(problem(model.rig, model.runs, model.layout, everything, settling.WHOLE), point.theta)
    return point.residuals if whole is None else whole.residuals


def is_lost(runs: Sequence[MeasuredRun], fit: Fit) -> bool:
    """Whether a fit is so far from the readings that a straight line through it says nothing."""
    for at, run in enumerate(runs):
        for segment in fit.problem.blocks[at].segments:
            rows = slice(segment.first, segment.last)
            marks, noise = fit.used[at][rows], run.noise[segment.name]
            y = run.readings(segment.name)[marks]
            left = float(np.sum((fit.full[at][rows][marks] * noise) ** 2))
            motion_of = float(np.sum((y - y.mean()) ** 2)) if marks.any() else 0.0
            if left > max(FAR**2 * motion_of, LOST * marks.sum() * noise**2):
                return True
    return False
