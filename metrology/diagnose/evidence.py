"""Evidence of a model for readings: half of the fall of χ², less what the parameters of its effects cost."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from metrology.diagnose import intervals
from metrology.diagnose.candidate import Candidate
from metrology.diagnose.subject import Array, Fit
from metrology.effect import Size

OCCAM = math.log(100 / math.sqrt(2 * math.pi))
"""What a size costs in ln evidence: all sizes up to a distance of 100 standard deviations are equally probable."""
STATED = 1.0
"""What it costs more to say that the laboratory is wrong beyond its own stated uncertainty."""


def log_bayes(candidates: Mapping[str, Candidate], before: Fit, after: Fit, others: Sequence[Fit] = ()) -> float:
    """Ln evidence of one model over another, both on the readings that carry weight in all of them."""
    common = [
        np.logical_and.reduce(marks) for marks in zip(*(one.used for one in (before, after, *others)), strict=True)
    ]
    gain = 0.5 * (_cost(before, common) - _cost(after, common))
    return gain - price(candidates, after) + price(candidates, before)


def price(candidates: Mapping[str, Candidate], fit: Fit) -> float:
    """What the parameters of a model's effects cost in ln evidence."""
    spread = intervals.spread(fit)
    total = 0.0
    for name in fit.effects:
        candidate = candidates[name]
        ways = sum(entry.name.split("@")[0] in _own(candidate) for entry in fit.problem.unknowns)
        total += OCCAM + 0.5 * max(ways - 1, 0) + (STATED if candidate.kind == "input" else 0.0)
        for shape in candidate.parameters:
            at = fit.index(shape.name) if shape.shape else None
            total += _held_price(shape) if at is None else _shape_price(shape, float(fit.theta[at]), float(spread[at]))
    return total


def _own(candidate: Candidate) -> set[str]:
    return {size.name for size in candidate.parameters if size.own}


def _cost(fit: Fit, marks: Sequence[Array]) -> float:
    return fit.penalty + sum(float(np.sum(part[own] ** 2)) for part, own in zip(fit.full, marks, strict=True))


def _held_price(shape: Size) -> float:
    """Ln of the number of places that were tried, for a shape that is tried place by place."""
    count = shape.high - shape.low
    return math.log(count) if shape.held and 1 < count < math.inf else 0.0


def _shape_price(shape: Size, value: float, u: float) -> float:
    """Ln of the range of a shape over what the data leave of it; logarithmic where it is positive."""
    if u <= 0 or not math.isfinite(u):
        return 0.0
    if shape.low > 0 and value > 0:
        wide, left = math.log(shape.high / shape.low), u / value
    else:
        wide, left = shape.high - shape.low, u
    return float(np.clip(math.log(max(wide, 1e-12) / (left * math.sqrt(2 * math.pi))), 0.0, 5.0))
