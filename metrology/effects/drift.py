"""A reading that drifts, whatever the motion or the load."""

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size, choice


def reading(seen: Readings, kind: float):
    """A steady one, one that settles as a laboratory warms up, one that begins late."""
    count = len(seen.force)
    g = np.arange(count) / count
    return (seen.order, -count / 3 * np.expm1(-3 * g), count * g**2)[round(kind)]


EFFECT = Effect(
    name="drift",
    title="Drift of a reading",
    equation="y = … + Σ a_n·P_n(2t/T − 1)",
    sign="readings move with time, whatever moves or pulls",
    source="JCGM 100:2008, F.2.4.2",
    acts="reading",
    causes=(
        Cause(
            "decay", "drift", (Size("drift", "m", 0.0, 0.0, INF, 1e-6),),
            title="Drift of the sensor, or motion slower than the record",
            equation="y = … + Σ a_n·P_n(2t/T − 1), n = 1 … 4",
            sign="the mean of the record moves from its begin to its end",
            consequence="peaks of one sign are too large, of the other too small; k and c hardly change where both are "
            "used",
            advice="let the sensor warm up; keep its stand off the frame",
            separate="a record of the plate at rest, as long as the others; a longer record shows a swing as a swing",
            pictures=("order",), alone="it is part of every fit of a record",
        ),
        Cause(
            "elongation", "drift", (Size("drift.rate", "m", 0.0, -INF, INF, 1e-7), choice("drift.kind", 3)),
            title="Drift of temperature or of the indicator",
            equation="x = … + a·j, or a settling or growing one",
            sign="readings move with their order, whatever the load",
            consequence="k and E are off where loading goes up only; a cycle up and down takes a steady drift out",
            advice="record temperature; read up and down at a steady pace",
            separate="an hour of readings at constant load, with the temperature",
            pictures=("order",), needs=("order",), amount=lambda seen: seen.u / 5, reading=reading,
            law="yield or drift",
        ),
    ),
)  # fmt: skip
