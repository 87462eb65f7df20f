"""The stated mass is wrong by a factor."""

from metrology.effect import INF, Cause, Effect, Parameter

EFFECT = Effect(
    name="mass",
    title="Mass of the module off its stated value",
    equation="m → μ·m",
    parameters=(Parameter("mass.factor", "μ", "1", 1.0, 1e-6, INF, (0.8, 1.25), 0.01, "true mass over stated mass"),),
    sign="acceleration under thrust, slack, off by one factor; frequency off by its root",
    source="JCGM 100:2008, 3.2.3 (systematic effect)",
    built_in=True,
    causes=(
        Cause(
            "response", "mass", ("mass.factor",),
            consequence="k and c are off by the same factor where no tension is measured",
            advice="weigh the module",
            separate="weigh the module",
            pictures=("time",), kind="input", amount=3e-3,
        ),
    ),
)  # fmt: skip
