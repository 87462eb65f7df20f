"""Drag of air and bearings on the module."""

from metrology.effect import INF, Cause, Effect, Parameter, Size


def force(v, way, viscous, quadratic):
    """−b·v − b₂·v·|v|."""
    return -viscous * v - quadratic * way * v * v


EFFECT = Effect(
    name="drag",
    title="Viscous and quadratic drag on the module",
    equation="F = −b·v − b₂·v·|v|",
    parameters=(
        Parameter("drag.viscous", "b", "N·s/m", 0.0, 0.0, INF, (0.0, 5.0), 0.01, "viscous drag"),
        Parameter("drag.quadratic", "b₂", "N·s²/m²", 0.0, 0.0, INF, (0.0, 100.0), 0.1, "quadratic drag", linear=False),
    ),
    sign="slack coast slows in proportion to v, or to v²; decay rate grows with amplitude for the latter",
    source="Nayfeh & Mook, Nonlinear Oscillations (1979), 3.3",
    sizes=2, force=force,
    causes=(
        Cause(
            "response", "drag", ("drag.viscous",),
            consequence="c comes out too large by about b",
            advice="measure b in a coast run and keep it in the model",
            separate="a coast run with the line slack: the speed falls exponentially",
            pictures=("force-velocity",), amount=lambda known: 0.005 * known["force"] / known["v"],
            limits=lambda known: {"drag.viscous": (0.0, 10 * known["force"] / known["v"])},
        ),
        Cause(
            "response", "quadratic drag", ("drag.quadratic",),
            consequence="c comes out too large, the more so the faster the module",
            advice="test at lower speed, or keep b₂ in the model",
            separate="a coast run with the line slack at twice the speed: the deceleration is four times as large",
            pictures=("force-velocity", "rate"), amount=lambda known: 0.005 * known["force"] / known["v"] ** 2,
            limits=lambda known: {"drag.quadratic": (0.0, 10 * known["force"] / known["v"] ** 2)},
        ),
        Cause(
            "decay", "quadratic drag", (Size("drag.quadratic", "N·s²/m²", 0.0, 0.0, INF, 1e-2),),
            title="Quadratic damping",
            equation="m·x″ + c·x′ + k·x = −b₂·|x′|·x′",
            sign="the decay rate falls with the amplitude, in proportion to it",
            consequence="ζ and c come out too large, by 8·b₂·ω·A/(3π) in c at the amplitude A; k hardly changes",
            advice="use a smaller release or a smaller plate, or a screen against the air",
            separate="a release at half the amplitude, or a plate of twice the area",
            pictures=("rate", "force-velocity"), amount=lambda known: 0.01 * known["c"] / (known["omega"] * known["e"]),
            law="damping that grows with amplitude",
        ),
    ),
)  # fmt: skip
