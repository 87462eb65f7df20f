"""Readings in blocks, the unknowns of a block, and the weighted block that a model's predictions make of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from metrology.diagnostics.subject import Array, Marks
from metrology.effect import Size
from metrology.estimation import Block, Segment, Unknown

STEP = 1e-3
"""Step of central differences, in scales of an unknown."""

Many = Callable[[Sequence[Mapping[str, float]]], Sequence[Array | None]]
Slopes = Callable[[Mapping[str, float], Sequence[Unknown]], Array | None]


@dataclass(frozen=True)
class Readings:
    """One block of readings: what was read, and the standard uncertainty of each.

    `phases`: names of parts of the block with the marks of their readings. `channels`: name and number of readings of
    each channel, one after the other, where there are several.
    """

    name: str
    channel: str
    y: Array
    u: Array
    phases: Sequence[tuple[str, Marks]] = ()
    channels: Sequence[tuple[str, int]] = ()

    def segments(self) -> tuple[Segment, ...]:
        """Rows of each channel."""
        if not self.channels:
            return (Segment(self.channel, 0, len(self.y)),)
        ends = np.cumsum([0, *(many for _, many in self.channels)]).tolist()
        return tuple(Segment(name, *ends[at : at + 2]) for at, (name, _) in enumerate(self.channels))


def unknown_of(size: Size) -> Unknown:
    """Size or shape of an effect as an unknown of a problem."""
    return Unknown(size.name, size.null, size.scale, size.low, size.high, unit=size.unit)


def own_unknown(size: Size, block: str, u: float | None) -> Unknown:
    """Size that a block has for itself; where it departs from the other blocks, their scatter u is its prior."""
    entry = replace(unknown_of(size), name=f"{size.name}@{block}")
    return entry if u is None else replace(entry, mean=0.0, u=u)


def block_of(
    data: Readings, unknowns: Sequence[Unknown], fixed: Mapping[str, float], many: Many, slopes: Slopes | None
) -> Block:
    """Weighted block of a problem; `fixed`: values that are not sought.

    `many`: readings that the model gives with each of some values; `slopes`: their derivatives by some unknowns, by
    central differences without it.
    """
    y, u = data.y, data.u
    uses = tuple(
        place for place, entry in enumerate(unknowns) if "@" not in entry.name or entry.name.endswith(f"@{data.name}")
    )
    names = [unknowns[place].name.split("@")[0] for place in uses]
    scales = np.array([unknowns[place].scale for place in uses]) * STEP
    low, high = (np.array([getattr(unknowns[place], end) for place in uses]) for end in ("low", "high"))

    def named(local: Array) -> dict[str, float]:
        return {**fixed, **dict(zip(names, local.tolist(), strict=True))}

    def residuals(local: Array) -> Array | None:
        (model,) = many([named(local)])
        return None if model is None else (y - model) / u

    def derivatives(local: Array) -> Array | None:
        if slopes is not None:
            moving = slopes(named(local), [unknowns[place] for place in uses])
            return None if moving is None else np.asarray(-(moving / u).T, dtype=float)
        ends = np.tile(local, (2 * len(local), 1))
        rows = np.arange(len(local))
        ends[2 * rows, rows], ends[2 * rows + 1, rows] = (
            np.maximum(local - scales, low),
            np.minimum(local + scales, high),
        )
        apart = ends[2 * rows + 1, rows] - ends[2 * rows, rows]
        found = many([named(end) for end in ends])
        if any(model is None for model in found) or (apart == 0).any():
            return None
        moved = np.array([model for model in found if model is not None])
        return np.asarray(((moved[::2] - moved[1::2]) / apart[:, None] / u).T, dtype=float)

    log_u = float(np.log(u * math.sqrt(2 * math.pi)).sum())
    return Block(data.name, uses, residuals, derivatives, data.segments(), len(y), log_u)


def plain_values(values: Mapping[str, float], block: str) -> dict[str, float]:
    """Values that act on a block, by plain name."""
    return {
        name.split("@")[0]: value for name, value in values.items() if "@" not in name or name.endswith(f"@{block}")
    }
