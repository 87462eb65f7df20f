"""Probabilities from evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeVar

from metrology.diagnostics.sets import Set

Model = TypeVar("Model", Set, Set | None)


def normalised(evidence: Mapping[Model, float]) -> dict[Model, float]:
    """Probability of each model by its ln evidence, one of them being true."""
    top = max(evidence.values())
    weights = {one: math.exp(max(value - top, -700.0)) for one, value in evidence.items()}
    total = math.fsum(weights.values())
    return {one: value / total for one, value in weights.items()}


def probabilities(over: Mapping[Set, float], others: float) -> dict[Set, float]:
    """Probability of each of some models beside others, of whose evidence together that of the models is given over."""
    found = normalised({None: math.log(others), **over} if others > 0 else {**over})
    return {one: w for one, w in found.items() if one is not None}


def logistic(odds: float) -> float:
    """Probability of odds that are given by their logarithm."""
    return 1.0 / (1.0 + math.exp(-min(max(odds, -700.0), 700.0)))
