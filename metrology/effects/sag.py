"""A line that hangs by its weight."""

from metrology.effect import INF, Cause, Effect, Parameter, Size

EFFECT = Effect(
    name="sag",
    title="Sag of the line as an elastic catenary",
    equation="e = ε − s·(1 − asinh(w)/w), w = q·s/(2·T)",
    parameters=(
        Parameter("sag.weight", "q_s", "N/m", 0.0, 0.0, INF, (0.0, 1.0), 1e-4,
                  "weight per length of the sagging line", linear=False),
    ),
    sign="soft at low tension: the tangent stiffness grows as T³",
    source="Irvine, Cable Structures (1981), 2.3",
    acts="line", straight=True, built_in=True,
    causes=(
        Cause(
            "response", "sag", (Size("sag.weight", "N/m", 0.0, 0.0, INF, 1e-4, power=2),),
            consequence="k comes out too small at low tension",
            advice="raise the tension, or use the elastic catenary with the weighed line",
            separate="weigh the line; repeat at twice the thrust: the softening falls with T³",
            pictures=("force-elongation",), needs=("tether", "length"), amount=lambda known: known["weight"] or 1e-4,
        ),
    ),
)  # fmt: skip
