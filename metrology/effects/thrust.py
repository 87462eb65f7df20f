"""A thrust that is not what was commanded: gain, lag, delay."""

from metrology.effect import INF, Cause, Effect, Parameter

FIRE = "clamp the module to the cell and fire"
EFFECT = Effect(
    name="thrust",
    title="Thrust off its command: gain, lag, delay",
    equation="F = (G·F_cmd(t − t_d) − F_lagged)/τ_F filtered at first order",
    parameters=(
        Parameter("thrust.gain", "G", "1", 1.0, -INF, INF, (0.8, 1.25), 0.01, "true over commanded force"),
        Parameter("thrust.lag", "τ_F", "s", 0.0, 0.0, INF, (0.0, 1.0), 1e-3, "time constant of the rise"),
        Parameter("thrust.delay", "t_d", "s", 0.0, -INF, INF, (-0.5, 0.5), 1e-3, "dead time of the thrusters"),
    ),
    sign="velocity in the slack phase off by a factor (gain), or late (lag, delay)",
    source="first-order lag with dead time",
    sizes=3, acts="thrust", built_in=True,
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
    ),
)  # fmt: skip
