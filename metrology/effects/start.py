"""Start state of a run: an input of each run, known within an uncertainty."""

from metrology.effect import INF, Effect, Parameter

EFFECT = Effect(
    name="start",
    title="Start state off its stated value",
    equation="x₀ → x₀ + δx, v₀ → v₀ + δv",
    parameters=(
        Parameter("start.x", "δx", "m", 0.0, -INF, INF, (-0.05, 0.05), 1e-4, "true minus stated start position"),
        Parameter("start.v", "δv", "m/s", 0.0, -INF, INF, (-0.05, 0.05), 1e-4, "true minus stated start velocity"),
    ),
    sign="the first slack phase is displaced as a whole",
    source="JCGM 100:2008, 3.2.3 (systematic effect)",
    sizes=2, built_in=True,
    never="an input of each run, which the campaign states with its uncertainty and every fit seeks within it",
)  # fmt: skip
