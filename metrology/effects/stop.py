"""Something that the module touches on its way: a stop, a wall, a cable."""

from collections.abc import Container

from metrology.effect import INF, Cause, Effect, Parameter, Scales


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Either side: more places would bend with whatever a poor model leaves, and the noise would be taken for less."""
    return [{"stop.gap": side * 0.7 * known["e"]} for side in (1, -1)]


def limits(known: Scales) -> dict[str, tuple[float, float]]:
    """As stiff as the line at most, within the largest motion on either side: a wall ends a motion."""
    return {"stop.stiffness": (0.0, known["k"]), "stop.gap": (-known["e"], known["e"])}


EFFECT = Effect(
    name="stop",
    title="Stop that the motion touches on one side",
    equation="F = −k_s·(x − x_s) beyond x_s",
    parameters=(
        Parameter("stop.stiffness", "k_s", "N/m", 0.0, 0.0, INF, (0.0, 1e3), 1e-3, "stiffness of the stop"),
        Parameter("stop.gap", "x_s", "m", 0.0, -INF, INF, (-1.0, 1.0), 1e-3, "position at which it is touched"),
    ),
    sign="the frequency falls with the amplitude until the motion no longer touches it; the middle of the motion moves",
    source="Shaw & Holmes, J. Sound Vib. 90 (1983) 129 (a periodically forced piecewise linear oscillator)",
    built_in=True,
    causes=(
        Cause(
            "decay", "stop", ("stop.stiffness", "stop.gap"),
            consequence="k comes out too large; c hardly changes",
            advice="clear the path of the motion, or evaluate the periods in which nothing is touched",
            separate="a release from less than x_s: the frequency stays the same at every amplitude",
            pictures=("frequency",), amount=lambda known: 0.02 * known["k"], shapes=shapes,
            limits=limits,
        ),
    ),
)  # fmt: skip
