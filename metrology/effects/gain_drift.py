"""The gain of the load cell drifts."""

from metrology.effect import INF, Cause, Effect, Parameter


def reading(y, since, rate):
    """γ₁·(t − t₀)·T."""
    return rate * since * y


EFFECT = Effect(
    name="gain_drift",
    title="Drift of the load cell's gain",
    equation="T_read = T + γ₁·(t − t₀)·T",
    parameters=(Parameter("gain_drift.rate", "γ₁", "1/s", 0.0, -INF, INF, (-1e-3, 1e-3), 1e-5, "growth of the gain"),),
    sign="the tension that belongs to an elongation changes from the first second of a run to its last",
    source="ISO 376:2011, 7.5 (creep)",
    acts="reading", readings={"T": reading},
    causes=(
        Cause(
            "response", "gain drift", ("gain_drift.rate",),
            consequence="k and c are means over the run, off by half of what the gain gained",
            advice="let the cell warm up under load; calibrate it before and after",
            separate="the same dead weight on the cell at the beginning and at the end",
            pictures=("time",), needs=("T",), amount=1e-4,
        ),
    ),
)  # fmt: skip
