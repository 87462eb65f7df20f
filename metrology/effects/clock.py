"""Channels whose stamps are apart."""

from metrology.effect import INF, Cause, Effect, Parameter

TAP = "one tap seen by all channels"
EFFECT = Effect(
    name="clock",
    title="Clocks of the channels apart",
    equation="a sample stamped t was taken at t − δt",
    parameters=(
        Parameter("clock.x", "δt_x", "s", 0.0, -INF, INF, (-0.2, 0.2), 1e-4, "stamp minus true time, position"),
        Parameter("clock.v", "δt_v", "s", 0.0, -INF, INF, (-0.2, 0.2), 1e-4, "stamp minus true time, velocity"),
        Parameter("clock.T", "δt_T", "s", 0.0, -INF, INF, (-0.2, 0.2), 1e-4, "stamp minus true time, tension"),
    ),
    sign="residual of a channel looks like its time derivative",
    source="JCGM 100:2008, F.2.3",
    sizes=3, acts="reading", built_in=True,
    causes=tuple(
        Cause(
            "response", f"clock {channel}", (f"clock.{channel}",),
            consequence=consequence,
            advice=advice,
            separate=TAP,
            pictures=("delay",), kind="input", needs=(channel,), amount=5e-4,
        )
        for channel, consequence, advice in (
            ("x", "c is biased by k·δt where tension and position are compared", "synchronise the clocks"),
            ("v", "velocity out of step with position", "synchronise the clocks, ask how velocity is filtered"),
            ("T", "c is biased by k·δt", "synchronise the clocks"),
        )
    ),
)  # fmt: skip
