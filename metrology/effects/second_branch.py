"""A second branch that relaxes, with a time of its own: a line whose relaxation is no single exponential."""

from metrology.effect import INF, Effect, Parameter
from metrology.effects.zener import branch

EFFECT = Effect(
    name="second_branch",
    title="Second relaxation time",
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
        branch("second_branch", "second branch",
               "hold a constant elongation for ten times as long and watch the tension fall", beside="zener"),
    ),
)  # fmt: skip
