"""The load cell: gain, zero and drift of the zero."""

from metrology.effect import INF, Cause, Effect, Parameter, Pulled, Size


def reading(y, since, gain, zero, drift):
    """(γ − 1)·T + T₀ + T₁·(t − t₀)."""
    return (gain - 1.0) * y + zero + drift * since


def pulled(seen: Pulled):
    """−(t − t₀)·dx/dF in both readings: what the cell reads is not all force."""
    return -seen.slope * (seen.time - seen.history[1][0])


EFFECT = Effect(
    name="cell",
    title="Load cell: gain, zero, drift",
    equation="T_read = γ·T + T₀ + T₁·(t − t₀)",
    parameters=(
        Parameter("cell.gain", "γ", "1", 1.0, -INF, INF, (0.8, 1.25), 0.01, "reading over force"),
        Parameter("cell.zero", "T₀", "N", 0.0, -INF, INF, (-1.0, 1.0), 1e-3, "reading without force"),
        Parameter("cell.drift", "T₁", "N/s", 0.0, -INF, INF, (-0.01, 0.01), 1e-5, "drift of the zero"),
    ),
    sign="T is not m times the change of acceleration; T is not zero when slack",
    source="ISO 376:2011, 7 and 8",
    sizes=3, acts="reading", readings={"T": reading},
    causes=(
        Cause(
            "response", "cell gain", ("cell.gain",),
            consequence="k and c from the tension are off by the same factor",
            advice="calibrate the load cell",
            separate="dead weight on the load cell",
            pictures=("time",), kind="input", needs=("T",), amount=3e-3,
        ),
        Cause(
            "response", "cell zero", ("cell.zero",),
            consequence="tension offset; k hardly changes",
            advice="take the zero before every run",
            separate="a minute of readings with the line slack",
            pictures=("time",), kind="input", needs=("T",), amount=lambda known: 1e-3 * known["force"],
        ),
        Cause(
            "response", "cell drift", ("cell.drift",),
            consequence="tension drifts; k hardly changes",
            advice="let the cell warm up; take the zero before and after every run",
            separate="ten minutes of readings with the line slack",
            pictures=("time",), needs=("T",), amount=lambda known: 1e-5 * known["force"],
        ),
        Cause(
            "tension", "cell drift", (Size("cell.drift", "N/s", 0.0, -INF, INF, 1e-3),),
            title="Drift of the load cell's zero",
            equation="F_read = F + T₁·(t − t₀)",
            sign="stretch and force part as time passes, loading and unloading alike",
            consequence="k and E are off by the drift over the rise of the force",
            advice="let the cell warm up; take its zero before and after",
            separate="ten minutes of readings with nothing in the grips",
            pictures=("order",), needs=("unloading", "time"),
            amount=lambda seen: seen.u / (abs(seen.slope) * seen.duration), reading=pulled,
        ),
    ),
)  # fmt: skip
