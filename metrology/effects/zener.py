"""A branch that relaxes: spring and dashpot in series beside the line."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Scales


def branch(effect: str, name: str, separate: str, beside: str = "") -> Cause:
    """A relaxing branch as a cause, of an effect with the parameters ``stiffness`` and ``time``."""
    stiffness, time = f"{effect}.stiffness", f"{effect}.time"

    def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
        """Relaxation times about the period, in equal ratios."""
        return [{time: factor / known["omega"]} for factor in np.geomspace(0.1, 30.0, 8).tolist()]

    return Cause(
        "response", name, (stiffness, time), beside=beside,
        consequence="k lies between the slow and the fast stiffness; c depends on frequency",
        advice="state k with its time scale; keep the branch in the model",
        separate=separate,
        pictures=("loop",), amount=lambda known: 0.02 * known["k"], shapes=shapes,
        limits=lambda known: {
            stiffness: (0.0, 5 * known["k"]),
            time: (0.02 / known["omega"], 100 / known["omega"]),
        },
    )  # fmt: skip


EFFECT = Effect(
    name="zener",
    title="Zener relaxation",
    equation="T = k·ε + k₁·(ε − z), z′ = (ε − z)/τ",
    parameters=(
        Parameter("zener.stiffness", "k₁", "N/m", 0.0, 0.0, INF, (0.0, 1e5), 0.1, "stiffness of the relaxing branch"),
        Parameter("zener.time", "τ", "s", 1.0, 1e-6, INF, (1e-3, 1e3), 0.01, "relaxation time"),
    ),
    sign="tension falls at constant elongation; stiffer when fast",
    source="Zener, Elasticity and Anelasticity of Metals (1948), V",
    acts="line", built_in=True,
    causes=(branch("zener", "zener", "hold a constant elongation and watch the tension fall"),),
)  # fmt: skip
