"""A hose or cable to the module, which pulls on it like a spring."""

from collections.abc import Container

from metrology.effect import INF, Cause, Effect, Parameter, Scales


def force(x, stiffness, rest):
    """−k_x·(x − x_r)."""
    return -stiffness * (x - rest)


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Without a pull at the least, the middle or the largest position of the runs."""
    low, high = known["least"], known["most"]
    return [{"hose.rest": low + part * (high - low)} for part in (0.0, 0.5, 1.0)]


def limits(known: Scales) -> dict[str, tuple[float, float]]:
    """As stiff as the line at most; without a pull within the runs, or as far beyond."""
    low, high = known["least"], known["most"]
    return {"hose.stiffness": (0.0, known["k"]), "hose.rest": (2 * low - high, 2 * high - low)}


EFFECT = Effect(
    name="hose",
    title="Hose or cable that pulls on the module",
    equation="F = −k_x·(x − x_r)",
    parameters=(
        Parameter("hose.stiffness", "k_x", "N/m", 0.0, 0.0, INF, (0.0, 10.0), 1e-3, "stiffness of the hose"),
        Parameter("hose.rest", "x_r", "m", 0.0, -INF, INF, (-1.0, 5.0), 1e-3, "position at which it does not pull"),
    ),
    sign="the speed changes with the position while the line is slack, and the load cell shows nothing of it",
    source="Schwartz, Peck & Hall, J. Guid. Control Dyn. 26 (2003) 513 (cables of air-bearing simulators)",
    force=force,
    causes=(
        Cause(
            "response", "hose", ("hose.stiffness", "hose.rest"),
            consequence="k from the motion comes out too large by about k_x, k from the tension does not",
            advice="let the hose hang in a loop, or keep k_x in the model",
            separate="the force that holds the module at several positions, the line slack",
            pictures=("time",), amount=lambda known: 0.02 * known["force"] / (known["most"] - known["least"]),
            shapes=shapes, limits=limits,
        ),
    ),
)  # fmt: skip
