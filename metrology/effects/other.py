"""A second oscillation in the record of a decay."""

from metrology.effect import INF, Cause, Effect, Size

EFFECT = Effect(
    name="other",
    title="Transverse or pendulum motion",
    equation="y = … + e^{−λt}·(a·sin 2πft + b·cos 2πft)",
    sign="a beat, or a second line in the spectrum, that decays with a rate of its own",
    source="Den Hartog, Mechanical Vibrations (1956), 3.1",
    acts="reading",
    causes=(
        Cause(
            "decay", "other",
            (
                Size("other.sin", "m", 0.0, -INF, INF, 1e-6, own=True),
                Size("other.cos", "m", 0.0, -INF, INF, 1e-6, own=True),
                Size("other.frequency", "Hz", 1.0, 1e-3, 1e5, 0.01, True),
                Size("other.rate", "1/s", 0.0, -1.0, 1e3, 0.1, True),
            ),
            consequence="ζ from peaks is biased where the beat is slow; k hardly changes",
            advice="release straight, on the axis",
            separate="a second vibrometer across the axis",
            pictures=("spectrum",), amount=lambda known: 1e-3 * known["e"],
        ),
    ),
)  # fmt: skip
