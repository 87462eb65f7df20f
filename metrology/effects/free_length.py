"""The position at which the line is taut is not the stated one."""

from metrology.effect import INF, Cause, Effect, Parameter

EFFECT = Effect(
    name="free_length",
    title="Free length off its stated value",
    equation="x_t → x_t + δ",
    parameters=(
        Parameter("free_length.shift", "δ", "m", 0.0, -INF, INF, (-0.05, 0.05), 1e-4,
                  "true minus stated taut position"),
    ),
    sign="first tension earlier or later than the position says",
    source="JCGM 100:2008, 3.2.3 (systematic effect)",
    acts="line", built_in=True,
    causes=(
        Cause(
            "response", "free length", ("free_length.shift",),
            consequence="the first contact is early or late; k hardly changes, E by the ratio of lengths",
            advice="measure the taut position again",
            separate="measure the taut position at a small dead load",
            pictures=("force-elongation",), kind="input", amount=3e-4,
        ),
    ),
)  # fmt: skip
