"""Damping of the line that grows with its elongation."""

from metrology.effect import INF, Cause, Effect, Parameter, Size


def damping(e, rate, side, amplitude):
    """c₁·|ε|·ε′."""
    return amplitude * side * e * rate


EFFECT = Effect(
    name="damping",
    title="Line damping that grows with amplitude",
    equation="T = k·ε + (c + c₁·|ε|)·ε′",
    parameters=(
        Parameter("damping.amplitude", "c₁", "N·s/m²", 0.0, 0.0, INF, (0.0, 1e6), 1.0, "damping per elongation",
                  linear=False),
    ),
    sign="decay rate grows with amplitude, in the line only",
    source="Nayfeh & Mook, Nonlinear Oscillations (1979), 3.3",
    acts="line", damping=damping,
    causes=(
        Cause(
            "response", "damping", ("damping.amplitude",),
            consequence="c is a mean over the amplitude",
            advice="state c with its amplitude",
            separate="decays from several amplitudes",
            pictures=("force-elongation", "rate"),
            amount=lambda known: 0.1 * max(known["c"], 0.01 * known["k"] / known["omega"]) / known["e"],
        ),
        Cause(
            "decay", "damping", (Size("damping.amplitude", "N·s/m²", 0.0, -INF, INF, 1.0),),
            title="Amplitude-dependent damping of the sample",
            equation="m·x″ + (c + c₁·|x|)·x′ + k·x = 0",
            sign="the decay rate changes with the amplitude, in proportion to it",
            consequence="c is a mean over the amplitudes of the record, off by 4·c₁·A/(3π) at the amplitude A; "
            "k hardly changes",
            advice="state c with its amplitude",
            separate="another mass on the same sample: c₁ stays, the drag of air b₂ grows with the speed",
            pictures=("rate", "force-elongation"), amount=lambda known: 0.02 * known["c"] / known["e"],
            law="damping that grows with amplitude",
        ),
    ),
)  # fmt: skip
