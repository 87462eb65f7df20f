"""Two loads of an elongation test that were exchanged."""

from collections.abc import Container
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from metrology.effect import INF, Cause, Effect, Readings, Size, choice


def _pairs(seen: Readings) -> list[tuple[float, float]]:
    """Every two loads, the smaller one first."""
    return list(combinations(np.unique(seen.force).tolist(), 2))


def _passes(seen: Readings) -> list[NDArray[np.bool_]]:
    """Readings of the whole test, then of each way up or down by itself where there are several."""
    ways = 2 * seen.repeat + (seen.back > 0)
    several = np.unique(ways)
    return [np.ones(len(ways), dtype=bool), *(ways == one for one in several if len(several) > 1)]


def reading(seen: Readings, which: float):
    """F_j − F_i where F_i is stated, and the other way round: in every repeat, or on one way up or down."""
    pairs = _pairs(seen)
    at, pair = divmod(round(which), len(pairs))
    low, high = pairs[pair]
    return (high - low) * _passes(seen)[at] * ((seen.force == low).astype(float) - (seen.force == high))


def places(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """Every pair of loads, and every pair of which one way up or down reads more at the smaller one.

    Two loads that changed places read as each other; a way on which the larger one reads more has none of them.
    """
    pairs, (_, *ways) = _pairs(seen), _passes(seen)
    found = list(range(len(pairs)))
    for at, rows in enumerate(ways if len(seen.value) else (), 1):
        read = {float(force): float(seen.value[rows & (seen.force == force)].mean()) for force in set(seen.force[rows])}
        found += [at * len(pairs) + pair for pair, (low, high) in enumerate(pairs)
                  if low in read and high in read and read[low] > read[high]]  # fmt: skip
    return [{"exchange.which": float(which)} for which in found]


def _limits(seen: Readings) -> dict[str, tuple[float, float]]:
    return {"exchange.which": (-0.5, len(_pairs(seen)) * len(_passes(seen)) - 0.5)}


EFFECT = Effect(
    name="exchange",
    title="Two loads that were exchanged",
    equation="x = … + s·(F_j − F_i) at load i, x = … − s·(F_j − F_i) at load j",
    sign="one load reads too much and another too little by as much, in every repeat or once",
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
            limits=_limits, reading=reading,
        ),
    ),
)  # fmt: skip
