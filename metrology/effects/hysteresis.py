"""A branch that yields: a loop that stays open however slow."""

from collections.abc import Container

from metrology.effect import INF, Cause, Effect, Parameter, Scales


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Yields over the largest elongation."""
    return [{"hysteresis.yield": part * known["e"]} for part in (0.03, 0.06, 0.12, 0.25, 0.5)]


EFFECT = Effect(
    name="hysteresis",
    title="Bouc–Wen hysteresis",
    equation="T = k·ε + k_h·h, h′ = ε′·(1 − ½·(1 + sign(ε′·h))·|h/h_y|)",
    parameters=(
        Parameter("hysteresis.stiffness", "k_h", "N/m", 0.0, 0.0, INF, (0.0, 1e5), 0.1,
                  "stiffness of the yielding branch", linear=False),
        Parameter("hysteresis.yield", "h_y", "m", 1e-3, 1e-12, INF, (1e-6, 0.1), 1e-5, "elongation at which it yields"),
    ),
    sign="a loop in T against elongation that stays open however slow",
    source="Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249",
    acts="line", built_in=True,
    causes=(
        Cause(
            "response", "hysteresis", ("hysteresis.stiffness", "hysteresis.yield"),
            consequence="k depends on amplitude, c stands for a loss that does not depend on frequency",
            advice="state k and the loss per cycle with the amplitude",
            separate="a slow loading loop between two tensions",
            pictures=("loop",), amount=lambda known: 0.01 * known["k"], shapes=shapes,
            limits=lambda known: {
                "hysteresis.yield": (0.01 * known["e"], 3 * known["e"]),
                "hysteresis.stiffness": (0.0, 3 * known["k"]),
            },
        ),
    ),
)  # fmt: skip
