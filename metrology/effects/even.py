"""A line whose stiffness changes with the sign of its elongation."""

from dataclasses import replace

from metrology.effect import INF, Cause, Effect, Parameter


def tension(e, stiffness):
    """k₂·ε²."""
    return stiffness * e * e


def slope(e, stiffness):
    """2·k₂·ε."""
    return 2.0 * stiffness * e


CAUSE = Cause(
    "response", "even stiffness", ("even.stiffness",),
    consequence="k is that of small amplitudes about a mean which moves with the amplitude; c hardly changes",
    advice="state k with its amplitude and its mean load, or give k and k₂",
    separate="static loading either way about the same mean load",
    pictures=("force-elongation", "frequency"), needs=("both ways",),
    amount=lambda known: 0.02 * known["k"] / known["e"],
)  # fmt: skip
EFFECT = Effect(
    name="even",
    title="Stiffness that is not alike either way",
    equation="T = k·ε + k₂·ε²",
    parameters=(
        Parameter("even.stiffness", "k₂", "N/m²", 0.0, -INF, INF, (-1e9, 1e9), 1.0, "even stiffness", linear=False),
    ),
    sign="the mean of the motion moves with the square of the amplitude; a line at twice the frequency",
    source="Nayfeh & Mook, Nonlinear Oscillations (1979), 2.3",
    acts="line", tension=tension, slope=slope,
    causes=(CAUSE, replace(
        CAUSE, method="decay", needs=(), amount=lambda known: 1e-3 * known["k"] / known["e"], law="either way"
    )),
)  # fmt: skip
