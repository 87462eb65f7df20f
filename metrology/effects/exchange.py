"""Two loads of an elongation test that were exchanged."""

from collections.abc import Container
from itertools import combinations

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size, choice


def _pairs(seen: Readings) -> list[tuple[float, float]]:
    """Every two loads, the smaller one first."""
    return list(combinations(np.unique(seen.force).tolist(), 2))


def reading(seen: Readings, which: float):
    """F_j − F_i where F_i is stated, and the other way round."""
    low, high = _pairs(seen)[round(which)]
    return (high - low) * ((seen.force == low).astype(float) - (seen.force == high))


def places(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """Every pair of loads."""
    return [{"exchange.which": float(at)} for at in range(len(_pairs(seen)))]


EFFECT = Effect(
    name="exchange",
    title="Two loads that were exchanged",
    equation="x = … + s·(F_j − F_i) at load i, x = … − s·(F_j − F_i) at load j",
    sign="one load reads too much and another too little by as much, in every repeat",
    source="JCGM 100:2008, 3.4.7 (blunders)",
    acts="reading",
    causes=(
        Cause(
            "elongation", "exchange",
            (Size("exchange.compliance", "m/N", 0.0, 0.0, INF, 1e-9), choice("exchange.which", 1)),
            consequence="k and E come out too large where a small and a large load were exchanged",
            advice="compare the labels of the loads with the order in which they were hung, and correct the table",
            separate="the two loads on a balance, and again on the sample",
            pictures=("load",), amount=lambda seen: seen.u / seen.most, shapes=places,
            limits=lambda seen: {"exchange.which": (-0.5, len(_pairs(seen)) - 0.5)}, reading=reading,
        ),
    ),
)  # fmt: skip
