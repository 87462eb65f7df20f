"""An extensometer that reads a constant factor too much or too little."""

from metrology.effect import Cause, Effect, Pulled, Size

MOST = 0.1
"""Part by which a scale may be off: five times what class 2 of ISO 9513 allows."""


def reading(seen: Pulled):
    """(dx/dF)·F in the extensometer."""
    return (1 - seen.crosshead) * seen.slope * seen.force


EFFECT = Effect(
    name="extensometer_scale",
    title="Wrong scale of the extensometer",
    equation="ε_read = (1 + s)·ε",
    sign="the extensometer reads another part of what the crosshead moves, the same in every mounting",
    source="ISO 9513:2012, 6 (relative error of indication)",
    acts="reading",
    causes=(
        Cause(
            "tension", "extensometer scale", (Size("clip.scale", "1", 0.0, -MOST, MOST, 1e-4),),
            consequence="k and E are off by the factor 1/(1 + s)",
            advice="calibrate the extensometer, measure its gauge length",
            separate="the stiff bar in the same grips for the set-up's compliance; specimens of two lengths; a second "
            "extensometer",
            pictures=("load",), kind="input", needs=("tether",), amount=lambda seen: seen.u / (seen.slope * seen.most),
            reading=reading, defined=True,
        ),
    ),
)  # fmt: skip
