"""A thrust that is not what was commanded: gain, lag, delay, fading."""

from metrology.effect import INF, Cause, Effect, Parameter

FIRE = "clamp the module to the cell and fire"
EFFECT = Effect(
    name="thrust",
    title="Thrust off its command: gain, lag, delay, fading",
    equation="F = (G·(1 − φ·(t − t₁))·F_cmd(t − t_d) − F_lagged)/τ_F filtered at first order",
    parameters=(
        Parameter("thrust.gain", "G", "1", 1.0, -INF, INF, (0.8, 1.25), 0.01, "true over commanded force"),
        Parameter("thrust.lag", "τ_F", "s", 0.0, 0.0, INF, (0.0, 1.0), 1e-3, "time constant of the rise"),
        Parameter("thrust.delay", "t_d", "s", 0.0, -INF, INF, (-0.5, 0.5), 1e-3, "dead time of the thrusters"),
        Parameter("thrust.fading", "φ", "1/s", 0.0, -INF, INF, (-0.2, 0.2), 1e-4,
                  "part of the thrust lost in each second from its start t₁ on"),
    ),
    sign="velocity in the slack phase off by a factor (gain), or late (lag, delay); "
    "the pull at rest falls while the thrust lasts (fading)",
    source="first-order lag with dead time; Sutton & Biblarz, Rocket Propulsion Elements (2017), 6.4 (blow-down)",
    sizes=4, acts="thrust", built_in=True,
    causes=(
        Cause(
            "response", "thrust gain", ("thrust.gain",),
            consequence="k and c are off by the same factor where no tension is measured",
            advice="calibrate the thrusters again",
            separate=FIRE,
            pictures=("force-velocity",), kind="input", needs=("thrust",), amount=3e-3,
        ),
        Cause(
            "response", "thrust lag", ("thrust.lag",),
            consequence="thrust acts late; k and c hardly change",
            advice="measure the rise of the thrusters on the cell, keep τ_F in the model",
            separate=FIRE,
            pictures=("delay",), needs=("thrust",), amount=2e-3,
        ),
        Cause(
            "response", "thrust delay", ("thrust.delay",),
            consequence="thrust acts late; k and c hardly change",
            advice="record the valve command on the same clock",
            separate=FIRE,
            pictures=("delay",), kind="input", needs=("thrust",), amount=2e-3,
        ),
        Cause(
            "response", "thrust fading", ("thrust.fading",),
            title="Thrust that falls while it lasts",
            equation="F = (1 − φ·(t − t₁))·F_cmd",
            sign="the pull at rest falls while the thrust lasts",
            consequence="the pull at rest moves with the thrust; k and c are off where no tension is measured",
            advice="regulate the supply pressure, or record it and state the thrust over time",
            separate=FIRE,
            pictures=("time",), needs=("thrust",), amount=lambda known: 3e-3 / known["gap"],
        ),
    ),
)  # fmt: skip
