"""What a little of a candidate does to the readings of runs on the rig, by motions that are followed with it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.subject import Array, Fit
from metrology.effect import Size
from metrology.estimation import Layout, MeasuredRun
from metrology.estimation.response import motion, values_of
from metrology.rig import Rig, sensitivities

SURE = 8.0
"""Distance in standard deviations by which a trial should move the data."""


@dataclass(frozen=True)
class Tried:
    """A fit of runs about which candidates are tried: the rig with its values, and what its motions read, run by run.

    `stated`: the rig as stated, without what the fit adds to it.
    """

    stated: Rig
    runs: Sequence[MeasuredRun]
    rig: Rig
    layout: Layout
    fit: Fit
    rows: Sequence[Array]


def null_of(rig: Rig, size: Size) -> float:
    """Value of a parameter in the model without the effect: what the campaign's own model says, if it does."""
    return rig.value(size.name) if size.name in rig.effects else size.null


def stated(fit: Fit, candidate: Candidate) -> Direction | None:
    """Direction of an input that is sought within what the laboratory states of it."""
    size = candidate.size
    at = fit.index(size.name)
    if at is None or fit.problem.unknowns[at].u is None:
        return None
    amount, rows = float(fit.problem.unknowns[at].u or 0.0), []
    for block, part in zip(fit.problem.blocks, fit.slopes, strict=True):
        own = [column for column, unknown in enumerate(block.uses) if unknown == at]
        rows.append(amount * part[:, own].sum(axis=1))
    return Direction(candidate.name, {size.name: amount}, amount, tuple(rows), stated=at)


def tried(stated: Rig, runs: Sequence[MeasuredRun], fitted: tuple[Rig, Layout], fit: Fit) -> Tried | None:
    """Motions of a fit, by its rig and its layout; None where one cannot be followed."""
    rig, layout = fitted
    rows = []
    for at, measured in enumerate(runs):
        moved = motion(rig, measured.run, values_of(layout, at, fit.theta))
        if moved is None:
            return None
        rows.append(np.concatenate([getattr(moved, name) for name in measured.channels]))
    return Tried(stated, runs, rig, layout, fit, rows)


def trial(
    base: Tried, candidate: Candidate, shape: Mapping[str, float], scales: Mapping[str, float],
    amounts: dict[tuple[str, ...], float],
) -> Direction | None:  # fmt: skip
    """Direction of a candidate in a shape, at an amount that can just be seen; `amounts` keeps it for the next one."""
    size = candidate.size
    key = (candidate.name, *map(str, shape.values()))
    amount = amounts.get(key) or candidate.amount(scales)
    for _ in range(3):
        rows = _moved(base, {**shape, size.name: amount}, size)
        if rows is None:
            amount *= 0.1
            continue
        d = math.sqrt(sum(float(part @ part) for part in rows))
        if d == 0.0:
            amount *= 30.0
            continue
        there = size.amount(amount, min(max(4 * SURE / d, 1e-4), 1e4))
        if 0.3 * SURE <= d / 4 <= 10 * SURE:
            amounts[key] = amount
            break
        amount, rows = there, None
    if rows is None:
        rows = _moved(base, {**shape, size.name: amount}, size)
    if rows is None:
        return None
    exact = _derivative(base, size.name) if candidate.cause.exact else None
    if exact is not None:
        rows = tuple(amount * part for part in exact)
    return Direction(candidate.name, {**shape, size.name: amount}, amount, rows, exact=exact is not None)


def _derivative(base: Tried, name: str) -> tuple[Array, ...] | None:
    """Derivative of the residuals by a size at its null; None where the motion has none."""
    rows = []
    for at, measured in enumerate(base.runs):
        found = sensitivities(base.rig.with_values(values_of(base.layout, at, base.fit.theta)), measured.run, [name])
        if not found.valid:
            return None
        row = np.concatenate([getattr(found, channel)[:, 0] for channel in measured.channels])
        rows.append(-row * measured.weights * base.fit.used[at])
    return tuple(rows)


def _moved(base: Tried, values: Mapping[str, float], size: Size) -> tuple[Array, ...] | None:
    rows = []
    for at, measured in enumerate(base.runs):
        own = values_of(base.layout, at, base.fit.theta)
        null = own.get(size.name, null_of(base.stated, size))
        trial = {**own, **values, size.name: null + values[size.name]}
        if not size.low <= trial[size.name] <= size.high:
            return None
        moved = motion(base.rig, measured.run, trial)
        if moved is None:
            return None
        row = np.concatenate([getattr(moved, channel) for channel in measured.channels])
        rows.append(-(row - base.rows[at]) * measured.weights * base.fit.used[at])
    return tuple(rows)
