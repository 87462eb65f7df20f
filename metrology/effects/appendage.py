"""A part of the module that moves on a spring of its own: slosh, a panel, a loose load, a mode of the mount."""

from collections.abc import Container

from metrology.effect import INF, Cause, Effect, Parameter, Scales
from metrology.effects.frame import RINGS, modes

MOST = 0.5
"""Part of the mass that may move by itself, at most: with more it is the module that is the appendage."""
FASTEST = 5.0
"""Frequency over that of the rig up to which a mode is tried: a faster one is moved by contacts alone, like a frame."""


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Modes about the frequency of the rig."""
    frequencies = modes(0.25 * known["omega"], FASTEST * known["omega"], known)
    return [{"appendage.frequency": one, "appendage.damping": RINGS} for one in frequencies]


def limits(known: Scales) -> dict[str, tuple[float, float]]:
    """Less than half of the module, and twice as fast as what is tried."""
    omega = known["omega"]
    return {
        "appendage.mass": (0.0, MOST * known["m"]),
        "appendage.frequency": (0.1 * omega, 2 * FASTEST * omega),
        "appendage.damping": (0.0, 0.5),
    }


EFFECT = Effect(
    name="appendage",
    title="Part of the module that moves on a spring of its own",
    equation="(m − m_a)·x″ = … + m_a·(ω_a²·y + 2·ζ_a·ω_a·y′), y″ + 2·ζ_a·ω_a·y′ + ω_a²·y = −x″",
    parameters=(
        Parameter("appendage.mass", "m_a", "kg", 0.0, 0.0, INF, (0.0, 10.0), 1e-3, "part of the mass that moves"),
        Parameter("appendage.frequency", "ω_a", "rad/s", 10.0, 1e-3, INF, (0.1, 1e3), 0.1,
                  "natural frequency of that part"),
        Parameter("appendage.damping", "ζ_a", "1", 0.02, 0.0, INF, (0.0, 0.5), 1e-3, "damping ratio of that part"),
    ),
    sign="a second frequency in x and v, also while the line is slack; a beat that no force of the line has",
    source="Abramson, The Dynamic Behavior of Liquids in Moving Containers, NASA SP-106 (1966), 6; Den Hartog, "
    "Mechanical Vibrations (1956), 3.2",
    acts="module", built_in=True,
    causes=(
        Cause(
            "response", "appendage", ("appendage.mass", "appendage.frequency", "appendage.damping"),
            consequence="k comes out too large by up to m/(m − m_a), c stands for energy that the part takes and gives "
            "back",
            advice="fix what is loose, fill or empty the tanks, stiffen the panels, or keep the part in the model",
            separate="a tap on the module at rest, with an accelerometer: it rings at ω_a·√(m/(m − m_a))",
            pictures=("time",), amount=lambda known: 0.01 * known["m"], shapes=shapes, limits=limits,
        ),
    ),
)  # fmt: skip
