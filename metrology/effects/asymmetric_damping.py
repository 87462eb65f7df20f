"""Damping of the line that is stronger, or weaker, while it is drawn out than while it comes back."""

from dataclasses import replace

from metrology.effect import INF, Cause, Effect, Parameter


def damping(rate, way, outward):
    """c₊·ε′ while ε grows."""
    return outward * rate * (way > 0)


CAUSE = Cause(
    "response", "asymmetric damping", ("asymmetric_damping.outward",),
    consequence="c is a mean over both ways, off by about half of c₊",
    advice="state c for each way, or take out what damps one way only",
    separate="a line that is drawn out and let back at a constant speed: the forces of both ways",
    pictures=("force-velocity", "loop"),
    amount=lambda known: 0.1 * max(known["c"], 0.01 * known["k"] / known["omega"]),
)  # fmt: skip
EFFECT = Effect(
    name="asymmetric_damping",
    title="Line damping that differs between drawing out and return",
    equation="T = k·ε + c·ε′ + c₊·max(ε′, 0)",
    parameters=(
        Parameter("asymmetric_damping.outward", "c₊", "N·s/m", 0.0, -INF, INF, (-1e3, 1e3), 1.0,
                  "damping more while the line is drawn out"),
    ),
    sign="the tension at the same speed differs between drawing out and return; the decay rate hardly does",
    source="Dixon, The Shock Absorber Handbook (2007), 1.5 (bump and rebound)",
    acts="line", damping=damping,
    causes=(
        CAUSE,
        replace(CAUSE, method="decay", consequence="c is a mean over both ways, off by half of c₊; the zero moves with "
                "the amplitude", pictures=("rate",), amount=lambda known: 0.02 * known["c"]),
    ),
)  # fmt: skip
