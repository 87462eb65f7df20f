"""A specimen that warms during its test and grows longer."""

import numpy as np

from metrology.effect import INF, Cause, Effect, Pulled, Size


def reading(seen: Pulled, time: float):
    """1 − exp(−(t − t₀)/τ) in both readings."""
    return -np.expm1(-(seen.time - seen.history[1][0]) / time)


EFFECT = Effect(
    name="heating",
    title="Heating of the specimen",
    equation="ε = … + α·ΔT·(1 − exp(−(t − t₀)/τ))",
    sign="the stretch goes on with time and levels off, whatever the load does; a specimen that cools shrinks",
    source="Newton's law of cooling with linear expansion: Incropera & DeWitt, Heat and Mass Transfer, 5.1",
    acts="line",
    causes=(
        Cause(
            "tension", "heating",
            (Size("heating.extension", "m", 0.0, -INF, INF, 1e-6),
             Size("heating.time", "s", 1.0, 1e-9, 1e12, 1.0, True, apart=6)),
            consequence="k and E are off by the growth over the rise of the load, and belong to another temperature",
            advice="let specimen and grips reach the temperature of the room; state it with k and E",
            separate="a thermometer on the specimen; ten minutes under a small load that stays",
            pictures=("order",), needs=("unloading", "time"), amount=lambda seen: seen.u,
            shapes=lambda seen, _: [{"heating.time": part * seen.duration} for part in (0.06, 0.2, 0.6)],
            limits=lambda seen: {"heating.time": (0.02 * seen.duration, seen.duration)}, reading=reading,
        ),
    ),
)  # fmt: skip
