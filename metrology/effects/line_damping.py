"""Damping of the line that grows with its speed."""

from dataclasses import replace

from metrology.effect import INF, Cause, Effect, Parameter


def damping(rate, quadratic):
    """c₂·ε′·|ε′|."""
    return quadratic * rate * abs(rate)


CAUSE = Cause(
    "response", "line damping", ("line_damping.quadratic",),
    consequence="c is a mean over the speeds of the record, off by 8·c₂·ω·A/(3π) at the amplitude A",
    advice="state c with its amplitude and frequency",
    separate="another mass on the same sample: c₂ goes with its speed, the drag of the air with that of the module",
    pictures=("rate", "force-velocity"),
    amount=lambda known: 0.1 * max(known["c"], 0.01 * known["k"] / known["omega"]) / known["v"],
)  # fmt: skip
EFFECT = Effect(
    name="line_damping",
    title="Line damping that grows with speed",
    equation="T = k·ε + c·ε′ + c₂·ε′·|ε′|",
    parameters=(
        Parameter("line_damping.quadratic", "c₂", "N·s²/m²", 0.0, 0.0, INF, (0.0, 1e5), 0.1,
                  "quadratic damping of the line", linear=False),
    ),
    sign="decay rate grows with amplitude, in the line only, the more so the faster",
    source="Nayfeh & Mook, Nonlinear Oscillations (1979), 3.3",
    acts="line", damping=damping,
    causes=(
        CAUSE,
        replace(
            CAUSE, method="decay", amount=lambda known: 0.02 * known["c"] / known["v"],
            alone="in a decay it is exactly a quadratic drag of the module",
        ),
    ),
)  # fmt: skip
