"""Prediction of data that a fit has not seen: each block left out in turn, only its own inputs sought anew."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from metrology.diagnosis import Gain
from metrology.diagnostics.subject import Array, Fit, Marks
from metrology.estimation import Problem, Unknown, solve
from metrology.estimation.covariance import inverse
from metrology.estimation.problem import Block, Point, evaluate
from metrology.estimation.solver import finished

DRAWS = 1000
PIECES = 12
"""Pieces into which a channel of a run is cut for the interval of the ratio: residuals hang together in time."""

CLOSE, STEPS = 0.03, 8
"""How closely the other blocks are fitted again, in standard uncertainties, and the steps that this may take."""
LOCAL = 0.02
"""Share of what is known of an unknown that other blocks must hold, else it is the block's own."""


@dataclass(frozen=True)
class HeldOut:
    """Whitened residuals of every block, each predicted without it (None where that failed), and which carry weight."""

    residuals: tuple[Array | None, ...]
    used: tuple[Marks, ...] = ()

    @property
    def complete(self) -> bool:
        """Whether every block was predicted."""
        return all(part is not None for part in self.residuals)


def predict(fit: Fit, *, thorough: bool = False) -> HeldOut:
    """Leave each block out: common unknowns from the others, its own ones from itself within their priors.

    Without block i the optimum moves by (H − JᵢᵀJᵢ)⁻¹·Jᵢᵀrᵢ (one Gauss–Newton step from the joint optimum); the
    block's own unknowns, those named ``…@block``, are then sought anew on the full model. `thorough`: the others are
    fitted again from there, as they have to be where a valley bends.
    """
    return HeldOut(tuple(_without(fit, at, thorough=thorough) for at in range(len(fit.problem.blocks))), fit.used)


def _without(fit: Fit, at: int, *, thorough: bool) -> Array | None:
    block, J, r = fit.problem.blocks[at], fit.slopes[at], fit.residuals[at]
    rows = np.array(block.uses)
    information = fit.information.copy()
    information[np.ix_(rows, rows)] -= J.T @ J
    gradient = np.zeros(len(fit.theta))
    gradient[rows] = -J.T @ r
    own = np.array([entry.name.endswith(f"@{block.name}") for entry in fit.problem.unknowns])
    # What shows in this block alone, such as a slip that happened in it, is its own as well.
    rest = ~own
    spread = np.diag(inverse(information[np.ix_(rest, rest)]))
    own[rest] = spread * LOCAL > np.diag(fit.covariance)[rest]
    common = ~own
    step = np.zeros(len(fit.theta))
    step[common] = -inverse(information[np.ix_(common, common)]) @ gradient[common]
    low, high = fit.problem.low, fit.problem.high
    theta = np.clip(fit.theta + step, low, high)
    if thorough:
        others = _others(fit, block)
        found = solve(others, theta, close=CLOSE, steps=STEPS)
        together = evaluate(others, fit.theta)
        if together is not None and found.cost > together.cost:
            # It ended above the joint optimum, which is a point of this problem as well.
            found = solve(others, fit.theta, close=CLOSE, steps=STEPS)
        point = _ended(others, found.point)
        theta = theta if point is None else np.where(common, point.theta, theta)
    for held in (theta, fit.theta):
        alone = Problem(_held(fit, own, held), (block,))
        point = _ended(alone, solve(alone, held, close=0.03, steps=6).point)
        if point is not None:
            return point.residuals[0]
    # Nor without that step, which leads a model too far that loses the motion anyway.
    return None


def _ended(problem: Problem, point: Point | None) -> Point | None:
    """Point carried on to its last digit."""
    end = None if point is None else finished(problem, point.theta)
    return point if end is None else end[0]


def _held(fit: Fit, own: Marks, theta: Array) -> tuple[Unknown, ...]:
    """Unknowns with all but the block's own ones held."""
    return tuple(
        entry if free else replace(entry, start=float(value), low=float(value), high=float(value), u=None, mean=None)
        for entry, free, value in zip(fit.problem.unknowns, own, theta, strict=True)
    )


def gains(
    fit: Fit, before: HeldOut, after: HeldOut, rng: np.random.Generator
) -> tuple[dict[str, Gain], Gain | None]:  # fmt: skip
    """Root mean square over noise before and after, and their ratio with its interval: by channel, and of all channels.

    Whole pieces of runs are drawn anew, a block bootstrap, since residuals of one run hang together (Künsch, Ann.
    Statist. 17 (1989) 1217). None where no block could be predicted both times.
    """
    squares: dict[str, list[tuple[float, float, int]]] = {}
    for at, block in enumerate(fit.problem.blocks):
        one, other = before.residuals[at], after.residuals[at]
        if one is None or other is None:
            continue
        for segment in block.segments:
            own = slice(segment.first, segment.last)
            a, b = one[own], other[own]
            both = before.used[at][own] & after.used[at][own]
            for part in np.array_split(np.flatnonzero(both), PIECES):
                if len(part):
                    piece = (float(a[part] @ a[part]), float(b[part] @ b[part]), len(part))
                    squares.setdefault(segment.name, []).append(piece)
    found = {channel: _gain(np.array(rows), rng) for channel, rows in squares.items()}
    every = [row for rows in squares.values() for row in rows]
    return found, _gain(np.array(every), rng) if every else None


def _gain(rows: Array, rng: np.random.Generator) -> Gain:
    total = rows.sum(axis=0)
    drawn = rows[rng.integers(0, len(rows), (DRAWS, len(rows)))].sum(axis=1)
    ratio = np.sqrt(drawn[:, 0] / np.maximum(drawn[:, 1], 1e-300))
    low, high = np.quantile(ratio, (0.025, 0.975))
    before, after = (float(np.sqrt(total[at] / total[2])) for at in (0, 1))
    return Gain(before, after, before / max(after, 1e-300), float(low), float(high))


def _others(fit: Fit, block: Block) -> Problem:
    """Problem without one of its blocks."""
    return Problem(fit.problem.unknowns, tuple(one for one in fit.problem.blocks if one is not block))
