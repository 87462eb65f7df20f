"""Slow motion, steps and lines under a decay, and their derivatives."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from metrology.diagnostics.release import LEVELS, LINES, STEPS, Record
from metrology.diagnostics.subject import Array

GROWTH = (-50.0, 5.0)
"""Least and most ln of what a line has grown to: the search may try any rate."""


def overlaid(record: Record, values: Mapping[str, float]) -> Array:
    """Slow motion and lines under the decay."""
    y = np.array([values[name] for name in record.levels]) @ record.slow
    for name, (_, later) in zip(STEPS, record.steps, strict=False):
        y = y + values[name] * later
    for name in LINES:
        if f"{name}.frequency" in values:
            (sine, cosine), (a, b) = _ways(record, name, values)
            y = y + (record.weights * (a * sine + b * cosine)).sum(axis=0)
    return np.asarray(y, dtype=float)


def overlaid_slope(record: Record, unknown: str, values: Mapping[str, float]) -> Array:
    """Derivative of `overlaid` by one of its values."""
    if unknown in LEVELS:
        return np.asarray(record.slow[LEVELS.index(unknown)])
    if unknown in STEPS:
        return record.steps[STEPS.index(unknown)][1]
    name, _, parameter = unknown.partition(".")
    (sine, cosine), (a, b) = _ways(record, name, values)
    growth = _growth(record, name, values)
    grows = (growth > GROWTH[0]) & (growth < GROWTH[1])
    by = {
        "sin": sine,
        "cos": cosine,
        "frequency": 2 * math.pi * record.nodes * (a * cosine - b * sine),
        "rate": np.where(grows, -record.nodes, 0.0) * (a * sine + b * cosine),
    }[parameter]
    return np.asarray((record.weights * by).sum(axis=0))


def _ways(record: Record, name: str, values: Mapping[str, float]) -> tuple[tuple[Array, Array], tuple[float, float]]:
    """Sine and cosine of a line at the nodes, and how much there is of each."""
    turn = 2 * math.pi * values[f"{name}.frequency"] * record.nodes
    fall = np.exp(np.clip(_growth(record, name, values), *GROWTH))
    amounts = values.get(f"{name}.sin", 0.0), values.get(f"{name}.cos", 0.0)
    return (fall * np.sin(turn), fall * np.cos(turn)), amounts


def _growth(record: Record, name: str, values: Mapping[str, float]) -> Array:
    """Ln of what a line has grown to at the nodes, by its rate alone."""
    return np.asarray(-values.get(f"{name}.rate", 0.0) * record.nodes)
