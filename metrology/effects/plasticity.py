"""A specimen that yields: beyond a force it stretches more, and does not go back."""

import numpy as np

from metrology.effect import INF, Cause, Effect, Pulled, Size

PARTS = (0.35, 0.5, 0.6, 0.7, 0.8, 0.9)
"""Forces F_y, as parts of the range of the forces, at which a search begins."""
WITHIN = (0.25, 0.97)
"""Parts of the range of the forces between which F_y may lie: the slope below it has to be known from what is there."""


def reading(seen: Pulled, force: float):
    """What the highest force so far is beyond F_y, in both readings."""
    return np.maximum(seen.highest - force, 0.0)


def at(seen: Pulled, part: float) -> float:
    """Force at a part of the range of the forces."""
    least = 2 * seen.middle - seen.most
    return least + part * (seen.most - least)


EFFECT = Effect(
    name="plasticity",
    title="Yield of the specimen",
    equation="ε = … + a/L·max(F_m − F_y, 0), F_m the highest force so far",
    sign="a knee in stretch against load, by crosshead and extensometer alike; what is beyond it stays after unloading",
    source="linear isotropic hardening: Simo & Hughes, Computational Inelasticity (1998), 1.2",
    acts="line",
    causes=(
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
