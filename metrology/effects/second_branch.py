"""A second branch that relaxes, with a time of its own: a line whose relaxation is no single exponential."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Scales


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Relaxation times about the period, in equal ratios."""
    return [{"second_branch.time": factor / known["omega"]} for factor in np.geomspace(0.1, 30.0, 8).tolist()]


EFFECT = Effect(
    name="second_branch",
    title="second relaxation time",
    equation="T = k·ε + k₁·(ε − z) + k_b·(ε − z_b), z_b′ = (ε − z_b)/τ_b",
    parameters=(
        Parameter("second_branch.stiffness", "k_b", "N/m", 0.0, 0.0, INF, (0.0, 1e5), 0.1,
                  "stiffness of the second relaxing branch"),
        Parameter("second_branch.time", "τ_b", "s", 1.0, 1e-6, INF, (1e-3, 1e3), 0.01, "its relaxation time"),
    ),
    sign="tension falls fast at first and slowly later, at constant elongation",
    source="Wiechert, Ann. Phys. 286 (1893) 335; Ferry, Viscoelastic Properties of Polymers (1980), 3.3",
    acts="line", built_in=True,
    causes=(
        Cause(
            "response", "second branch", ("second_branch.stiffness", "second_branch.time"), beside="zener",
            consequence="k lies between the slow and the fast stiffness; c depends on frequency",
            advice="state k with its time scale; keep the branch in the model",
            separate="hold a constant elongation for ten times as long and watch the tension fall",
            pictures=("loop",), amount=lambda known: 0.02 * known["k"], shapes=shapes,
            limits=lambda known: {
                "second_branch.stiffness": (0.0, 5 * known["k"]),
                "second_branch.time": (0.02 / known["omega"], 100 / known["omega"]),
            },
        ),
    ),
)  # fmt: skip
