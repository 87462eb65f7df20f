"""A table out of level."""

import math

from metrology.effect import Cause, Effect, Parameter


def force(m, gravity, angle):
    """m·g·sin θ."""
    return m * gravity * math.sin(angle)


EFFECT = Effect(
    name="tilt",
    title="Table out of level",
    equation="F = m·g·sin θ",
    parameters=(
        Parameter("tilt.angle", "θ", "rad", 0.0, -1.5, 1.5, (-5e-3, 5e-3), 1e-5, "slope, downhill towards growing x"),
    ),
    sign="a constant acceleration, thrust on or off",
    source="Newton's second law on an inclined plane",
    straight=True, force=force,
    causes=(
        Cause(
            "response", "tilt", ("tilt.angle",),
            consequence="thrust seems off by m·g·θ; k and c hardly change",
            advice="level the table, or turn it by 180° and repeat",
            separate="a run without thrust, from rest: the module drifts; repeated with the table turned by 180° it "
            "drifts back", pictures=("force-velocity",),
            amount=lambda known: 0.003 * known["force"] / (9.8 * known["m"]),
        ),
    ),
)  # fmt: skip
