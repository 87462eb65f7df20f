"""Shapes in which a candidate may act on readings in blocks, and what it does there to the residuals of a fit."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from metrology.diagnostics.blocks import Readings, plain_values
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.subject import Array, Fit

ROUNDING = 1e-8
"""Part of the readings below which what a candidate changes is the error of the motions, which are right to 3e-10."""

Predict = Callable[[int, Mapping[str, float]], Array | None]


@dataclass(frozen=True)
class Trial:
    """A shape in which a candidate may act: values of its shapes and the amount to try."""

    amount: float
    shapes: Mapping[str, float] = field(default_factory=dict)
    looks: float = 1.0


def overlay(
    blocks: Sequence[Readings],
    predict: Predict,
    fit: Fit,
    candidate: Candidate,
    trial: Trial,
    scattered: Collection[str],
) -> Direction:
    """Direction with a column for each way and block; `scattered`: what departs from block to block by chance."""
    sizes = [size for size in candidate.parameters if size.own]
    # If all blocks depart alike, none does.
    acting = blocks[:-1] if sizes[0].name in scattered else blocks
    ways = tuple(f"{size.name}@{data.name}" for data in acting for size in sizes)
    rows = [np.zeros((len(data.y), len(ways))) for data in blocks]
    for at, data in enumerate(acting):
        null = dict.fromkeys((size.name for size in sizes), 0.0)
        own = {**fit.shapes, **plain_values(fit.values, data.name), **trial.shapes, **null}
        here = predict(at, own)
        for way, size in enumerate(sizes):
            there = predict(at, {**own, size.name: trial.amount})
            if here is not None and there is not None:
                rows[at][:, at * len(sizes) + way] = (here - there) / data.u
    return Direction(candidate.name, dict(trial.shapes), trial.amount, tuple(rows), trial.looks, ways)


def moved_rows(
    blocks: Sequence[Readings], predict: Predict, fit: Fit, values: Mapping[str, float]
) -> tuple[Array, ...] | None:
    """Change of the whitened residuals of a fit with other values, block by block; None where nothing acts."""
    rows = []
    for at, data in enumerate(blocks):
        own = {**fit.shapes, **plain_values(fit.values, data.name)}
        here, there = predict(at, own), predict(at, {**own, **values})
        if here is None or there is None:
            return None
        rows.append((here - there) / data.u)
    moved = sum(float(part @ part) for part in rows)
    whole = sum(float(np.sum((data.y / data.u) ** 2)) for data in blocks)
    # What does not act, such as a stop that no swing reaches, leaves rounding, which has another form everywhere.
    return tuple(rows) if moved > ROUNDING**2 * whole else None
