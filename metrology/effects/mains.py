"""The mains in the record of a decay."""

from metrology.effect import INF, Cause, Effect, Size

EFFECT = Effect(
    name="mains",
    title="Mains in the record",
    equation="y = … + a·sin 2πft + b·cos 2πft, f a multiple of the mains",
    sign="a line at a multiple of the mains frequency that does not decay",
    source="JCGM 100:2008, F.2.4.2",
    acts="reading",
    causes=(
        Cause(
            "decay", "mains",
            (
                Size("mains.sin", "m", 0.0, -INF, INF, 1e-6, own=True),
                Size("mains.cos", "m", 0.0, -INF, INF, 1e-6, own=True),
                Size("mains.frequency", "Hz", 1.0, 1e-3, 1e5, 0.01, True),
            ),
            consequence="small peaks are biased, and ζ and c with them; k hardly changes",
            advice="part supply and earth of the sensor from the rest",
            separate="a record of the plate at rest",
            pictures=("spectrum",), amount=lambda known: 1e-3 * known["e"],
        ),
    ),
)  # fmt: skip
