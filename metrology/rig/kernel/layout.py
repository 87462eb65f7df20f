"""Positions in the parameters, the state, the regime and the table of legs, and the terms that effects add."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"

from __future__ import annotations

from metrology.rig import hooks
from metrology.rig.parameters import INDEX

# fmt: off
# Positions in the vector of parameters, of those that the terms below name; all others are read by `hooks`.
M, K, C, TAUT, LENGTH, WEIGHT, GRAVITY, CAP = (INDEX[name] for name in (
    "m", "k", "c", "taut", "length", "weight", "gravity", "cap"))
MASS_FACTOR, LENGTH_SHIFT, SETUP, SLIP = (INDEX[name] for name in (
    "mass.factor", "free_length.shift", "setup.compliance", "slip.set"))
FRICTION, STATIC_RATIO, BIAS = (INDEX[f"friction.{name}"] for name in ("force", "static_ratio", "bias"))
TOE, TOE_RATIO = INDEX["toe.extent"], INDEX["toe.ratio"]
FRAME, FRAME_RATE, FRAME_DAMPING = (INDEX[f"frame.{name}"] for name in ("compliance", "frequency", "damping"))
ARM, INERTIA, YAW_RATE, YAW_DAMPING = (INDEX[f"yaw.{name}"] for name in ("arm", "inertia", "frequency", "damping"))
APPENDAGE, APPENDAGE_RATE, APPENDAGE_DAMPING = (INDEX[f"appendage.{name}"] for name in (
    "mass", "frequency", "damping"))
ZENER, ZENER_TIME, SECOND, SECOND_TIME = (INDEX[name] for name in (
    "zener.stiffness", "zener.time", "second_branch.stiffness", "second_branch.time"))
HYSTERESIS, YIELD, SAG = INDEX["hysteresis.stiffness"], INDEX["hysteresis.yield"], INDEX["sag.weight"]
GAIN, LAG, DELAY, FADING = (INDEX[f"thrust.{name}"] for name in ("gain", "lag", "delay", "fading"))
CELL_LAG = INDEX["cell_lag.time"]
CLOCK_X, CLOCK_V, CLOCK_T = (INDEX[f"clock.{channel}"] for channel in "xvT")
STOP, STOP_AT = INDEX["stop.stiffness"], INDEX["stop.gap"]
SLACK, SLACK_AT, SLACK_DAMPING = (INDEX[f"slack.{name}"] for name in ("share", "place", "damping"))
START_X, START_V = INDEX["start.x"], INDEX["start.v"]
# Positions in the state. X is measured from where the line is taut. What a rig lacks points at NOTHING, which is 0.
X, V, NOTHING, SIZE = 0, 1, 14, 15
# Positions of the other states, kept in the table `at`: frame u, u′, yaw r·φ, r·φ′, appendage y, y′, relaxing branches
# z, z_b, loop h, lagged thrust, what a lagging cell shows, and the time, where a term asks for it.
(FRAME_U, FRAME_V, YAW_U, YAW_V, APPENDAGE_U, APPENDAGE_V, RELAXED, RELAXED_B, LOOP, THRUST, SHOWN,
 TIME) = range(12)
# What the rig is like: the table `kind`.
ATTACHMENT, WEIGHS, N, TOGETHER = range(4)
TETHER, BOTH_WAYS, NO_LINE = range(3)
# The regime r: what holds between two events.
CONTACT, SLIDE, TOE_SIDE, TURN_SIDE, LOOP_SIDE, SIDE, SLIPPED, CAPPED, TOUCHED, SLACKENED, HELD, REGIME = range(12)
BELOW, STRETCHED, LIFTED = range(3)
# What is watched: each is positive in its regime.
(W_EXCESS, W_PULL, W_SPEED, W_GRIP, W_GRIP_BACK, W_TOE, W_TOE_BACK, W_TURN, W_LOOP, W_SIDE, W_CAP, W_STOP,
 W_SLACK, WATCHED) = range(14)
# A leg, the motion between two events: when it begins and how long it lasts, the thrust and its growth, what ends it,
# the pieces of the thrust and of the added force, the state and the regime at its start.
SINCE, SPAN, PUSH, GROWTH, ENDING, PIECE, PART, STATE = range(8)
RULES = STATE + SIZE
LEG = RULES + REGIME
RELEASE, FORCE, CLAMP, START, ADDED = 20, 21, 22, 23, 24
OK, TOO_MANY_STEPS, TOO_MANY_EVENTS, CHATTER, NOT_FINITE, LINE_TOO_SHORT = range(6)
MAX_STEPS, MAX_EVENTS, BLOCK, KEPT = 2_000_000, 20_000, 32, 8
FIRST = 0.3
"""Largest first step over the line's time 1/ω: a twentieth of a turn, which the error of the step then makes longer."""
# fmt: on
# What the files of `metrology.effects` add, each function composed of all of them: force on the module, static tension
# of the line, its slope, force of its damping, stiffness of the force; whether any acts that is not linear, or that
# turns with v or e.
(
    added_force,
    added_tension,
    added_slope,
    added_damping,
    added_stiffness,
    has_tension,
    is_curved_line,
    is_curved_force,
    turns,
    has_sides,
    has_ways,
) = hooks.installed(globals())  # fmt: skip
