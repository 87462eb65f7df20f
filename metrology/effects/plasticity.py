"""A specimen that yields: beyond a force it stretches more, and does not go back."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Pulled, Readings, Size, choice
from metrology.effects import softening

PARTS = (0.35, 0.5, 0.6, 0.7, 0.8, 0.9)
"""Forces F_y, as parts of the range of the forces, at which a search begins."""
WITHIN = (0.25, 0.97)
"""Parts of the range of the forces between which F_y may lie: the slope below it has to be known from what is there."""


BEYOND = 2
"""Loads beyond F_y at least: one alone that is off from its first reading on is a slip, by the same numbers."""


def reading(seen: Pulled, force: float):
    """What the highest force so far is beyond F_y, in both readings."""
    return np.maximum(seen.highest - force, 0.0)


def at(seen: Pulled, part: float) -> float:
    """Force at a part of the range of the forces."""
    least = 2 * seen.middle - seen.most
    return least + part * (seen.most - least)


def lasting(seen: Readings, force: float, kind: float):
    """What the highest load so far is beyond F_y: in each repeat anew (0), or in all of the test (1).

    Anew where each repeat is another mounting, or another specimen.
    """
    return np.maximum(seen.highest(mounted=round(kind) == 0) - force, 0.0)


def least(seen: Readings) -> float:
    """Smallest F_y under dead loads: of one that nearly all loads are beyond, the set is a drift of each repeat."""
    return float(seen.force.min() + WITHIN[0] * np.ptp(seen.force))


def knees(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """Between two loads, of either kind."""
    return [{"yield.force": one, "yield.kind": float(kind)}
            for kind in range(2) for one in softening.between(seen, least(seen), beyond=BEYOND)]  # fmt: skip


EFFECT = Effect(
    name="plasticity",
    title="Yield of the specimen",
    equation="ε = … + a/L·max(F_m − F_y, 0), F_m the highest force so far",
    sign="a knee in stretch against load, by crosshead and extensometer alike; what is beyond it stays after unloading",
    source="linear isotropic hardening: Simo & Hughes, Computational Inelasticity (1998), 1.2",
    acts="line",
    causes=(
        Cause(
            "elongation", "yield",
            (
                Size("yield.compliance", "m/N", 0.0, 0.0, INF, 1e-9),
                Size("yield.force", "N", 1.0, 1e-3, 1e9, 1.0, True),
                choice("yield.kind", 2),
            ),
            title="Yield, or slip of a clamp, above a load",
            equation="x = … + a·max(F_m − F_y, 0), F_m the highest load so far",
            sign="a knee in extension against load when loads are reached for the first time; what is beyond it stays",
            consequence="k and E come out too small where the loads beyond F_y are used",
            advice="end the range of loads below F_y; tighten the clamps",
            separate="marks on the sample at the clamps and away from them; load again: what has yielded does not move",
            pictures=("load",), needs=("unloading",), amount=lambda seen: seen.u / seen.most, shapes=knees,
            limits=lambda seen: {"yield.force": softening.within(seen, least(seen), beyond=BEYOND)},
            reading=lasting, law="yield or drift",
        ),
        Cause(
            "tension", "yield",
            (Size("yield.compliance", "m/N", 0.0, 0.0, INF, 1e-9),
             Size("yield.force", "N", 1.0, 1e-3, 1e9, 1.0, True, apart=15)),
            consequence="k and E over the range come out too small: the line is drawn over the knee",
            advice="end the range below F_y; state F_y, or R_p0.2 of the record to the break",
            separate="unload from beyond the knee and measure what stays: softening that is elastic leaves nothing",
            pictures=("load",), amount=lambda seen: seen.u / seen.most,
            shapes=lambda seen, _: [{"yield.force": at(seen, part)} for part in PARTS],
            limits=lambda seen: {"yield.force": (at(seen, WITHIN[0]), at(seen, WITHIN[1]))},
            reading=reading, law="stiffness",
        ),
    ),
)  # fmt: skip
