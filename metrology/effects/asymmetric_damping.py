"""Damping of the line that is stronger, or weaker, while it is stretched than while it shortens."""

from metrology.effect import INF, Cause, Effect, Parameter, Size


def damping(rate, way, outward):
    """c₊·ε′ while ε grows."""
    return outward * rate * (way > 0)


EFFECT = Effect(
    name="asymmetric_damping",
    title="Line damping that depends on the direction",
    equation="T = k·ε + c·ε′ + c₊·max(ε′, 0)",
    parameters=(
        Parameter("asymmetric_damping.outward", "c₊", "N·s/m", 0.0, -INF, INF, (-1e3, 1e3), 1.0,
                  "further damping while the line is stretched"),
    ),
    sign="the damping force at one speed differs between stretching and shortening; the decay rate stays the same "
    "at every amplitude",
    source="Dixon, The Shock Absorber Handbook (2007), 1.5 (bump and rebound)",
    acts="line", damping=damping,
    causes=(
        Cause(
            "response", "asymmetric damping", ("asymmetric_damping.outward",),
            consequence="c is a mean of both directions, off by about half of c₊",
            advice="state c for each direction, or remove what damps in one direction only",
            separate="stretch the line and let it shorten at a constant speed: the forces of both directions",
            pictures=("force-velocity", "loop"),
            amount=lambda known: 0.1 * max(known["c"], 0.01 * known["k"] / known["omega"]),
        ),
        Cause(
            "decay", "asymmetric damping", (Size("asymmetric_damping.outward", "N·s/m", 0.0, -INF, INF, 1.0),),
            equation="m·x″ + c·x′ + c₊·max(x′, 0) + k·x = 0",
            sign="the decay rate stays the same at every amplitude, and the middle of the motion moves with it",
            consequence="c is a mean of both directions, off by about half of c₊; k hardly changes",
            advice="state c for each direction, or remove what damps in one direction only",
            separate="stretch the line and let it shorten at a constant speed: the forces of both directions",
            pictures=("force-velocity", "rate"), amount=lambda known: 0.02 * known["c"],
        ),
    ),
)  # fmt: skip
