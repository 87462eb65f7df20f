"""The scale of the motion capture."""

from metrology.effect import INF, Cause, Effect, Parameter


def reading(y, scale):
    """(κ − 1)·y."""
    return (scale - 1.0) * y


EFFECT = Effect(
    name="motion",
    title="Motion capture: scale",
    equation="x_read = κ·x, v_read = κ·v",
    parameters=(Parameter("motion.scale", "κ", "1", 1.0, -INF, INF, (0.9, 1.1), 1e-3, "reading over length"),),
    sign="x and v off by one factor",
    source="JCGM 100:2008, F.2.2",
    acts="reading", readings={"x": reading, "v": reading},
    causes=(
        Cause(
            "response", "motion scale", ("motion.scale",),
            consequence="k and c are off by the reciprocal factor",
            advice="calibrate the motion capture with a scale bar",
            separate="scale bar in the field of view",
            pictures=("time",), kind="input", needs=("motion",), amount=3e-3,
        ),
    ),
)  # fmt: skip
