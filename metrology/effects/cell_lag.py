"""The reading of the load cell follows the tension late, as behind a filter of first order."""

from metrology.effect import INF, Cause, Effect, Parameter

EFFECT = Effect(
    name="cell_lag",
    title="Lag of the load cell",
    equation="τ_T·T_read′ + T_read = T",
    parameters=(
        Parameter("cell_lag.time", "τ_T", "s", 0.0, 0.0, INF, (0.0, 0.5), 1e-3, "time constant of the load cell"),
    ),
    sign="tension late, and round where it changes suddenly; fast motions are read too small",
    source="Doebelin, Measurement Systems (2003), 3.3 (first-order instruments)",
    acts="reading", built_in=True,
    causes=(
        Cause(
            "response", "cell lag", ("cell_lag.time",),
            consequence="c is biased by k·τ_T where tension and position are compared",
            advice="raise the cut-off frequency of the amplifier, or keep τ_T in the model",
            separate="a weight on the cell that is cut loose: its reading falls to 1/e within τ_T",
            pictures=("delay",), needs=("T",), amount=5e-3,
        ),
    ),
)  # fmt: skip
