"""The equation of motion and its integration between located events; one file, so that a compiled copy is never stale.

Plain Python throughout: `engines` runs it as it is, with vectorised segments, or compiled. The physics stands in
`stretch`, `pull`, `tension`, `net_force` and `motion`; `watch` and `switch` say where one regime ends and which one
follows; the rest solves it: exactly, by matrix exponentials, where a regime is linear (the matrices are read off
`motion` itself, so that the equation stands nowhere else), by Dormand and Prince's 8(5,3) pairs where it is not.
"""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

import math

import numpy as np

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
CLOCK_X, CLOCK_V, CLOCK_T = (INDEX[f"clock.{channel}"] for channel in "xvT")
STOP, STOP_AT = INDEX["stop.stiffness"], INDEX["stop.gap"]
SLACK, SLACK_AT, SLACK_DAMPING = (INDEX[f"slack.{name}"] for name in ("share", "place", "damping"))
START_X, START_V = INDEX["start.x"], INDEX["start.v"]
# Positions in the state. X is measured from where the line is taut. What a rig lacks points at NOTHING, which is 0.
X, V, NOTHING, SIZE = 0, 1, 13, 14
# Positions of the other states, kept in the table `at`: frame u, u′, yaw r·φ, r·φ′, appendage y, y′, relaxing branches
# z, z_b, loop h, lagged thrust, and the time, where a term asks for it.
FRAME_U, FRAME_V, YAW_U, YAW_V, APPENDAGE_U, APPENDAGE_V, RELAXED, RELAXED_B, LOOP, THRUST, TIME = range(11)
# What the rig is like: the table `kind`.
ATTACHMENT, WEIGHS, N, TOGETHER = range(4)
TETHER, BOTH_WAYS, NO_LINE = range(3)
# The regime r: what holds between two events.
CONTACT, SLIDE, TOE_SIDE, TURN_SIDE, LOOP_SIDE, SIDE, SLIPPED, CAPPED, TOUCHED, SLACKENED, HELD, REGIME = range(12)
BELOW, STRETCHED, LIFTED = range(3)
# What is watched: each is positive in its regime.
(W_EXCESS, W_PULL, W_SPEED, W_GRIP, W_GRIP_BACK, W_TOE, W_TOE_BACK, W_TURN, W_LOOP, W_SIDE, W_CAP, W_STOP,
 W_SLACK, WATCHED) = range(14)
RELEASE, FORCE, CLAMP, START, ADDED = 20, 21, 22, 23, 24
OK, TOO_MANY_STEPS, TOO_MANY_EVENTS, CHATTER, NOT_FINITE, LINE_TOO_SHORT = range(6)
MAX_STEPS, MAX_EVENTS, BLOCK, KEPT = 2_000_000, 20_000, 32, 8
# Steps between two events: for each radian of the fastest rate, and as many more. They take two or three for a radian;
# a motion that runs away under a drag takes ever shorter ones, for seconds, before any bound of its size is reached.
PER_RADIAN, LEG_STEPS, EXHAUSTED = 100.0, 20_000, -2
FIRST = 0.3
"""Largest first step over the line's time 1/ω: a twentieth of a turn, which the error of the step then makes longer."""
RTOL = 3e-10
# Error of a step, over what is allowed, below which the next is twice as long: rounding makes errors of 1e-6, which
# else choose the sizes of all later steps anew for every last digit of a parameter.
LEAST_ERROR = 1.7e-3
THIRD_TURN = math.pi / 3.0
# 1 − asinh(w)/w = w²/6 − 3·w⁴/40 + …: coefficients by falling power of w².
CATENARY = np.array([
    -((-1) ** n) * math.factorial(2 * n) / (4**n * math.factorial(n) ** 2 * (2 * n + 1)) for n in range(9, 0, -1)
])
# Between uneven stamps: spacing of even nodes, times the fastest rate; nodes of a polynomial, those of them before a
# stamp, and barycentric weights. It leaves (0.5·1.5·…·5.5)²/12!·0.25¹² = 3e-12 of a sine.
FINE, NODES, BEFORE = 0.25, 12, 5
EVEN = np.arange(float(NODES))
BARY = np.array([(-1.0) ** q * math.comb(NODES - 1, q) for q in range(NODES)])
FEW, SPARSE = 16, 400  # stamps, and nodes for each of them, where polynomials and power series take as long
INVERSE = 1.0 / np.maximum(np.arange(40), 1)  # division is slow where it is waited for
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


# ---- the equation of motion -----------------------------------------------------------------------------------------
def hanging(T, q, s):
    """How much nearer the ends of a line hang than its length s, s·(1 − asinh(w)/w), w = q·s/(2·T); −d/dT, d²/dT²."""
    w = 0.5 * q * s / T
    square = w * w
    root = math.sqrt(1.0 + square)
    if square < 0.02:  # the power series in w²: the difference would lose its digits
        series, rate = 0.0, 0.0
        for i in range(CATENARY.shape[0]):
            rate = rate * square + series
            series = series * square + CATENARY[i]
        near, fall = square * series, 2.0 * square * (series + square * rate)
    else:
        ratio = math.log(w + root) / w  # asinh
        near, fall = 1.0 - ratio, ratio - 1.0 / root
    rate = s / T
    return s * near, rate * fall, rate / T * square / (root * (1.0 + square))


def shallow(e, k, q, s, x):
    """Tension of a line of stiffness k that hangs nearly in a parabola: T³/k − e·T² = q²·(s + x)³/24·(1 + …).

    The last factor, fitted to the catenary, leaves an error of T below 1e-3 up to a slack x = −0.3·s.
    """
    part = max(1.0 + x / s, 1e-3)
    third, rest = k * e / 3.0, k * q**2 * (s * part) ** 3 * (1.0 - (0.3 - 0.28 * x / s) * x / s) / 48.0
    cube = third * third * third
    if rest < 1e-4 * abs(cube):  # by power series: deep in the slack the root is a small difference of large numbers
        if third < 0.0:
            root = math.sqrt(-2.0 * rest / (3.0 * third))
            part = -root / third
            return root * (1.0 - part * (1.0 / 6.0 - part * 5.0 / 72.0))
        part = rest / (13.5 * cube)
        return 3.0 * third * (1.0 + part * (1.0 - part * (2.0 - 7.0 * part)))
    inside = rest * (rest + 2.0 * cube)
    if inside >= 0.0:
        root = (cube + rest + math.sqrt(inside)) ** (1.0 / 3.0)
        return third + root + third**2 / root
    return third - 2.0 * third * math.cos(math.acos(1.0 + rest / cube) / 3.0 - THIRD_TURN)


def relaxed(y, p, at):
    """Force that the relaxing branches have lost: k₁·z + k_b·z_b."""
    return p[ZENER] * y[at[RELAXED]] + p[SECOND] * y[at[RELAXED_B]]


def stretch(e, lost, h, r, p):
    """Elongation ε of the line, its static tension T and dε/de: e = ε − s·(1 − asinh(w)/w) + C·T, w = q·s/(2·T).

    `lost` is the force that the relaxing branches have lost.
    """
    k, compliance = p[K], p[SETUP]
    a, b = 0.0, k
    if p[TOE] > 0.0:
        if r[TOE_SIDE] == 0:
            b = p[TOE_RATIO] * k
        else:
            a = -r[TOE_SIDE] * (1.0 - p[TOE_RATIO]) * k * p[TOE]
    a = a - lost + p[HYSTERESIS] * h
    b = b + p[ZENER] + p[SECOND]
    sags, adds = p[SAG] > 0.0, has_tension(p)
    if not sags and not adds:
        share = 1.0 / (1.0 + compliance * b)
        epsilon = (e - compliance * a) * share
        return epsilon, a + b * epsilon, share
    if (
        sags
    ):  # with its ends at one place a line hangs without any pull between them: nearer than this it is as good as 0
        e = max(e, -0.999 * p[LENGTH])
    epsilon, near, fall, change = e, 0.0, 0.0, 0.0
    if sags:
        epsilon = (shallow(e + a / b, b / (1.0 + compliance * b), p[SAG], p[LENGTH], e) - a) / b
    for _ in range(80):
        force, slope = a + b * epsilon, b
        if adds:
            force, slope = force + added_tension(epsilon, p), b + added_slope(epsilon, p)
        size = abs(slope * epsilon)
        if sags:
            near, fall, change = hanging(force, p[SAG], p[LENGTH])
            size = force
        step = (epsilon + compliance * force - near - e) / (1.0 + (compliance + fall) * slope)
        if sags and slope * step > 0.7 * force:  # a sagging line always pulls
            step = 0.7 * force / slope
        epsilon -= step
        if abs(slope * step) <= 3e-7 * size:  # the next step would be the square of this one
            fall += change * slope * step
            break
    force, slope = a + b * epsilon, b
    if adds:
        force, slope = force + added_tension(epsilon, p), b + added_slope(epsilon, p)
    return epsilon, force, 1.0 / (1.0 + (compliance + fall) * slope)


def excess(y, at):
    """Distance beyond taut that is left for the line, and its rate: e = x − x_t − u − r·φ."""
    return y[X] - y[at[FRAME_U]] - y[at[YAW_U]], y[V] - y[at[FRAME_V]] - y[at[YAW_V]]


def pull(y, r, p, at):
    """Tension that a taut line has: T = g(ε) + Σ k_i·(ε − z_i) + k_h·h + (c·ε′ + d(ε, ε′))·dε/de, ε′ = dε/de·e′.

    Where a part of it is slack, less by what that would push, s·(k·(e − e_s) + q·c·e′).
    """
    e, rate = excess(y, at)
    epsilon, force, share = stretch(e, relaxed(y, p, at), y[at[LOOP]], r, p)
    T = force + p[C] * share**2 * rate + share * added_damping(epsilon, share * rate, r, p)
    if r[SLACKENED] == 1:
        T -= p[SLACK] * pushed(e, rate, p)
    return T


def slack_weight(y, r, p, kind, at):
    """Tension of the slack line, eq. 3 of the paper: T = q·L²/(8·√(3·L·(s − L)/8)), s − L ≥ cap."""
    if kind[WEIGHS] == 0:
        return 0.0
    gap = p[CAP]
    if r[CAPPED] == 0:
        gap = -excess(y, at)[0]
    span = p[LENGTH] - gap
    if span <= 0.0 or gap <= 0.0:
        return 0.0
    return p[WEIGHT] * span**2 / (8.0 * math.sqrt(3.0 * span * gap / 8.0))


def tension(y, r, p, kind, at):
    """Tension of the line, T ≥ 0 for a line that only pulls."""
    if kind[ATTACHMENT] == NO_LINE:
        return 0.0
    if r[CONTACT] == STRETCHED:
        return pull(y, r, p, at)
    return slack_weight(y, r, p, kind, at)


def pushed(e, rate, p):
    """Pull of all that can go slack, counted from where it does: k·(e − e_s) + q·c·e′."""
    return p[K] * (e - p[SLACK_AT]) + p[SLACK_DAMPING] * p[C] * rate


def slackened(e, rate, p):
    """The same, positive where it would have to push: beyond e_s, from the side on which zero lies."""
    return pushed(e, rate, p) if p[SLACK_AT] >= 0.0 else -pushed(e, rate, p)


def from_stop(y, r, p):
    """Where the module is, counted from the stop: x − x_s."""
    return y[X] + p[TAUT] + p[SLIP] * r[SLIPPED] - p[STOP_AT]


def beyond(y, r, p):
    """How far the module is beyond the stop, from the side on which zero lies."""
    return from_stop(y, r, p) if p[STOP_AT] >= 0.0 else -from_stop(y, r, p)


def net_force(y, thrust, T, r, p, at):
    """All but friction: F_thrust + F_added − T − k_s·(x − x_s) + m_a·(ω_a²·y + 2·ζ_a·ω_a·y′)."""
    if p[LAG] > 0.0:
        thrust = y[at[THRUST]]
    force = thrust + added_force(y, T, r, p, at) - T
    if r[TOUCHED] == 1:
        force -= p[STOP] * from_stop(y, r, p)
    if p[APPENDAGE] > 0.0:
        omega = p[APPENDAGE_RATE]
        force += p[APPENDAGE] * omega * (omega * y[at[APPENDAGE_U]] + 2.0 * p[APPENDAGE_DAMPING] * y[at[APPENDAGE_V]])
    return force


def motion(y, thrust, r, p, kind, at, dy):
    """Fill `dy`: (m − m_a)·x″ = F_net − F_c·(sign(v) + β), and the inner states; return T."""
    dy[X], dy[V] = 0.0, 0.0
    T = tension(y, r, p, kind, at)
    if r[SLIDE] != 0 and r[HELD] == 0:
        dy[X] = y[V]
        dy[V] = (net_force(y, thrust, T, r, p, at) - (r[SLIDE] + p[BIAS]) * p[FRICTION]) / (p[M] - p[APPENDAGE])
    if kind[N] == 2:
        return T
    dy[at[TIME]] = 1.0
    u, du = y[at[FRAME_U]], y[at[FRAME_V]]
    omega = p[FRAME_RATE]
    dy[at[FRAME_U]] = du
    dy[at[FRAME_V]] = omega**2 * (p[FRAME] * T - u) - 2.0 * p[FRAME_DAMPING] * omega * du
    w, dw = y[at[YAW_U]], y[at[YAW_V]]
    omega = p[YAW_RATE]
    dy[at[YAW_U]] = dw
    dy[at[YAW_V]] = p[ARM] ** 2 * T / p[INERTIA] - omega**2 * w - 2.0 * p[YAW_DAMPING] * omega * dw
    u, du = y[at[APPENDAGE_U]], y[at[APPENDAGE_V]]
    omega = p[APPENDAGE_RATE]
    dy[at[APPENDAGE_U]] = du
    dy[at[APPENDAGE_V]] = -dy[V] - omega**2 * u - 2.0 * p[APPENDAGE_DAMPING] * omega * du
    if p[LAG] > 0.0:
        dy[at[THRUST]] = (thrust - y[at[THRUST]]) / p[LAG]
    if at[RELAXED] == NOTHING and at[RELAXED_B] == NOTHING and at[LOOP] == NOTHING:
        return T
    h = y[at[LOOP]]
    epsilon, speed = 0.0, 0.0
    if r[CONTACT] != BELOW:
        e, rate = excess(y, at)
        epsilon, _, share = stretch(e, relaxed(y, p, at), h, r, p)
        speed = share * rate
    dy[at[RELAXED]] = (epsilon - y[at[RELAXED]]) / p[ZENER_TIME]
    dy[at[RELAXED_B]] = (epsilon - y[at[RELAXED_B]]) / p[SECOND_TIME]
    yielded = 0.0
    if r[TURN_SIDE] == r[LOOP_SIDE]:
        yielded = r[LOOP_SIDE] * h / p[YIELD]
    dy[at[LOOP]] = 0.0
    if p[HYSTERESIS] > 0.0:  # else its turns are not watched, and it would run away
        dy[at[LOOP]] = speed * (1.0 - yielded)
    return T


# ---- regimes --------------------------------------------------------------------------------------------------------
def watch(y, thrust, r, p, kind, at, g):
    """Fill `g`: each entry is positive in the regime `r`, and its zero is where the regime ends."""
    for i in range(WATCHED):
        g[i] = 1.0
    e, rate = excess(y, at)
    contact = r[CONTACT]
    tether = kind[ATTACHMENT] == TETHER
    if tether:
        if p[SAG] == 0.0:
            g[W_EXCESS] = -e if contact == BELOW else e
        if contact != BELOW:
            T = pull(y, r, p, at)
            g[W_PULL] = T if contact == STRETCHED else -T
        if kind[WEIGHS] == 1 and contact == BELOW:
            g[W_CAP] = e + p[CAP] if r[CAPPED] == 1 else -e - p[CAP]
        if p[SAG] > 0.0:  # no change of the equation, but what is reported as taut and slack
            g[W_CAP] = -e if r[CAPPED] == 1 else e
    if p[STOP] > 0.0:
        g[W_STOP] = beyond(y, r, p) if r[TOUCHED] == 1 else -beyond(y, r, p)
    if p[SLACK] > 0.0:
        g[W_SLACK] = slackened(e, rate, p) if r[SLACKENED] == 1 else -slackened(e, rate, p)
    if r[HELD] == 0:
        if r[SLIDE] == 0:
            net = net_force(y, thrust, tension(y, r, p, kind, at), r, p, at)
            g[W_GRIP] = p[STATIC_RATIO] * p[FRICTION] * (1.0 + p[BIAS]) - net
            g[W_GRIP_BACK] = p[STATIC_RATIO] * p[FRICTION] * (1.0 - p[BIAS]) + net
        elif p[FRICTION] > 0.0 or turns(p):
            g[W_SPEED] = r[SLIDE] * y[V]
    if contact == BELOW:
        return
    if p[TOE] > 0.0:
        epsilon = stretch(e, relaxed(y, p, at), y[at[LOOP]], r, p)[0]
        if r[TOE_SIDE] == 0:
            g[W_TOE] = p[TOE] - epsilon
            if not tether:
                g[W_TOE_BACK] = p[TOE] + epsilon
        else:
            g[W_TOE] = r[TOE_SIDE] * epsilon - p[TOE]
    if p[HYSTERESIS] > 0.0 or (p[SLIP] > 0.0 and r[SLIPPED] == 0) or has_ways(p):
        g[W_TURN] = r[TURN_SIDE] * rate
    if p[HYSTERESIS] > 0.0:
        g[W_LOOP] = r[LOOP_SIDE] * y[at[LOOP]]
    if not tether and has_sides(p):
        g[W_SIDE] = r[SIDE] * e


def touch(y, r, p, kind, at):
    """Find which contact the line has here: below taut, stretched, or lifted (beyond taut, yet without pull)."""
    if kind[ATTACHMENT] == NO_LINE:
        r[CONTACT] = BELOW
        return
    r[CONTACT] = STRETCHED
    if kind[ATTACHMENT] == BOTH_WAYS:
        return
    e, rate = excess(y, at)
    if p[SAG] == 0.0 and (e < 0.0 or (e == 0.0 and rate <= 0.0)):
        r[CONTACT] = BELOW
    elif pull(y, r, p, at) < 0.0:
        r[CONTACT] = LIFTED


def grip(y, thrust, r, p, kind, at):
    """Find whether a module at rest sticks, and which way it slides otherwise."""
    if y[V] > 0.0:
        r[SLIDE] = 1
    elif y[V] < 0.0:
        r[SLIDE] = -1
    else:
        r[SLIDE] = 0
        net = net_force(y, thrust, tension(y, r, p, kind, at), r, p, at)
        way = 1 if net >= 0.0 else -1
        if p[FRICTION] == 0.0 or abs(net) > p[STATIC_RATIO] * p[FRICTION] * (1.0 + way * p[BIAS]):
            r[SLIDE] = way


def turn(y, r, p, kind, at):
    """Turn of the line's elongation; at the first one, outward, the clamp slips."""
    slips = r[TURN_SIDE] > 0 and r[SLIPPED] == 0 and p[SLIP] > 0.0 and r[CONTACT] == STRETCHED
    r[TURN_SIDE] = -r[TURN_SIDE]
    if slips:
        r[SLIPPED] = 1
        y[X] -= p[SLIP]
        if p[TOE] > 0.0 and y[X] < p[TOE]:
            r[TOE_SIDE] = 0
        touch(y, r, p, kind, at)
    return slips


def switch(event, y, thrust, r, p, kind, at):
    """Enter the regime that follows `event`; give the event's code for the record."""
    code = event
    if event == W_EXCESS:
        if r[CONTACT] == BELOW:
            r[CONTACT] = STRETCHED
            r[TURN_SIDE] = 1  # a line comes taut while it is drawn out, whichever way it turned last
            if pull(y, r, p, at) < 0.0:
                r[CONTACT] = LIFTED
        else:
            r[CONTACT] = BELOW
    elif event == W_PULL:
        r[CONTACT] = LIFTED if r[CONTACT] == STRETCHED else STRETCHED
    elif event == W_SPEED:
        y[V] = 0.0
        outward = r[TURN_SIDE]
        if r[CONTACT] != BELOW and outward * r[SLIDE] > 0 and outward * excess(y, at)[1] <= 0.0:
            turn(y, r, p, kind, at)  # the line turns with the module, even where the module then sticks
        grip(y, thrust, r, p, kind, at)
    elif event in (W_GRIP, W_GRIP_BACK):
        r[SLIDE] = 1 if event == W_GRIP else -1
        # The net force may miss σ·F_c by its last digit here: at rest, the module would stick again at once, for ever.
        y[V] = r[SLIDE] * 1e-20
    elif event in (W_TOE, W_TOE_BACK):
        r[TOE_SIDE] = 0 if r[TOE_SIDE] != 0 else (1 if event == W_TOE else -1)
    elif event == W_TURN:
        if turn(y, r, p, kind, at):
            code = CLAMP
    elif event == W_LOOP:
        r[LOOP_SIDE] = -r[LOOP_SIDE]
    elif event == W_SIDE:
        r[SIDE] = -r[SIDE]
    elif event == W_CAP:
        r[CAPPED] = 1 - r[CAPPED]
    elif event == W_STOP:
        r[TOUCHED] = 1 - r[TOUCHED]
    elif event == W_SLACK:
        r[SLACKENED] = 1 - r[SLACKENED]
    return code


def is_linear(r, p, kind):
    """Whether the equation is linear while the regime `r` lasts."""
    if is_curved_force(r, p):
        return False
    if r[CONTACT] == BELOW:
        return kind[WEIGHS] == 0 or r[CAPPED] == 1
    return p[HYSTERESIS] == 0.0 and p[SAG] == 0.0 and not is_curved_line(p)


def begin(y, thrust, r, p, kind, at, x0, v0):
    """Start state: the inner states at rest, in equilibrium with the position."""
    for i in range(SIZE):
        y[i] = 0.0
    y[X], y[V] = x0 - p[TAUT], v0
    e = y[X]
    r[CONTACT] = BELOW
    if kind[ATTACHMENT] == BOTH_WAYS or (kind[ATTACHMENT] == TETHER and (e > 0.0 or p[SAG] > 0.0)):
        r[CONTACT] = STRETCHED
    r[TURN_SIDE], r[LOOP_SIDE] = (1, 1) if v0 >= 0.0 else (-1, -1)
    r[SIDE] = 1 if e >= 0.0 or kind[ATTACHMENT] == TETHER else -1
    r[CAPPED] = 1 if -e < p[CAP] else 0
    if p[SAG] > 0.0:
        r[CAPPED] = 1 if e < 0.0 else 0
    r[TOUCHED] = 1 if p[STOP] > 0.0 and beyond(y, r, p) > 0.0 else 0
    r[SLACKENED] = 1 if p[SLACK] > 0.0 and slackened(e, v0, p) > 0.0 else 0
    r[TOE_SIDE] = 0
    soft = p[FRAME]
    if p[ARM] != 0.0 and p[YAW_RATE] > 0.0:
        soft += p[ARM] ** 2 / (p[INERTIA] * p[YAW_RATE] ** 2)
    if r[CONTACT] == STRETCHED:
        T, epsilon = 0.0, e
        for _ in range(200):  # the series of springs at rest: bisection-free, since each pass contracts
            epsilon, force, share = stretch(e - soft * T, 0.0, 0.0, r, p)
            # Fully relaxed: the branches carry nothing.
            force = force - (p[ZENER] + p[SECOND]) * epsilon
            slope = (p[K] + added_slope(epsilon, p)) * share
            change = (force - T) / (1.0 + soft * slope)
            T += change
            if p[TOE] > 0.0 and abs(epsilon) > p[TOE]:
                r[TOE_SIDE] = 1 if epsilon > 0.0 else -1
            if abs(change) <= 1e-15 * abs(T):
                break
        y[at[FRAME_U]] = p[FRAME] * T
        if p[ARM] != 0.0 and p[YAW_RATE] > 0.0:
            y[at[YAW_U]] = p[ARM] ** 2 / (p[INERTIA] * p[YAW_RATE] ** 2) * T
        y[at[RELAXED]] = epsilon
        y[at[RELAXED_B]] = epsilon
    y[at[THRUST]] = 0.0
    y[NOTHING] = 0.0
    touch(y, r, p, kind, at)
    r[SLIDE] = 1
    grip(y, thrust, r, p, kind, at)


# ---- exact steps of a linear regime ---------------------------------------------------------------------------------
def assemble(r, p, kind, at, A, W, rows):
    """Read the matrices of a linear regime off `motion`, `watch` and the channels; Y = (y, F, F′, 1)."""
    n = kind[N]
    last = n + 2
    y, dy, g = np.zeros(SIZE), np.zeros(SIZE), np.zeros(WATCHED)
    d0, g0 = np.zeros(SIZE), np.zeros(WATCHED)
    for i in range(n + 3):
        for j in range(n + 3):
            A[i, j] = 0.0
        for j in range(3):
            rows[j, i] = 0.0
    t0 = 0.0
    for j in range(-1, n + 1):  # first at rest, then with one state or the thrust at 1
        if j >= 0:
            y[j] = 1.0 if j < n else y[j]
        thrust = 1.0 if j == n else 0.0
        motion(y, thrust, r, p, kind, at, dy)
        watch(y, thrust, r, p, kind, at, g)
        T = tension(y, r, p, kind, at)
        if j < 0:
            t0 = T
            for i in range(n):
                d0[i] = dy[i]
            for i in range(WATCHED):
                g0[i] = g[i]
            continue
        for i in range(n):
            A[i, j] = dy[i] - d0[i]
        for i in range(WATCHED):
            W[i, j] = g[i] - g0[i]
        rows[2, j] = T - t0
        if j < n:
            y[j] = 0.0
    for i in range(n):
        A[i, last] = d0[i]
    A[n, n + 1] = 1.0
    for i in range(WATCHED):
        W[i, n + 1] = 0.0
        W[i, last] = g0[i]
    rows[0, X], rows[1, V], rows[2, last] = 1.0, 1.0, t0
    rows[0, last] = p[TAUT] + p[SLIP] * r[SLIPPED]


def fastest(r, p, kind):
    """Bound on the angular frequency of the regime, rad/s."""
    k = p[K] * max(1.0, p[TOE_RATIO] if p[TOE] > 0.0 else 1.0) + p[ZENER] + p[SECOND] + p[HYSTERESIS]
    if kind[ATTACHMENT] == NO_LINE or r[CONTACT] != STRETCHED:
        k = 0.0
    rate = (k + max(added_stiffness(p), 0.0) + p[STOP] * r[TOUCHED]) / (p[M] - p[APPENDAGE])
    if p[APPENDAGE] > 0.0:
        rate += p[APPENDAGE_RATE] ** 2 / (1.0 - p[APPENDAGE] / p[M])
    if p[FRAME] > 0.0:
        rate += p[FRAME_RATE] ** 2 * (1.0 + p[FRAME] * k)
    if p[ARM] != 0.0:
        rate += p[YAW_RATE] ** 2 + p[ARM] ** 2 * k / p[INERTIA]
    return math.sqrt(rate)


def reach(A, n, omega):
    """Norm of A for states scaled to one another: how fast the power series in A·h begins to converge.

    Position and velocity alone are scaled by ω. With more states, each is scaled until what drives it is as large as
    what it drives (Osborne, J. ACM 7 (1960) 338): a second velocity, too, is as large as its frequency.
    """
    scale = np.full(n, 1.0)
    scale[V] = omega
    if omega == 0.0:  # a free motion's series ends by itself, however long the time
        scale[V] = 1e-6 if n == 2 else 1.0
    for _ in range(0 if n == 2 else 6):
        for i in range(n):
            driven, drives = 0.0, 0.0
            for j in range(n):
                if j != i:
                    driven += abs(A[i, j]) * scale[j] / scale[i]
                    drives += abs(A[j, i]) * scale[i] / scale[j]
            if driven > 0.0 and drives > 0.0:
                scale[i] *= math.sqrt(driven / drives)
    largest = 0.0
    for j in range(n):
        total = 0.0
        for i in range(n):
            total += abs(A[i, j]) * scale[j] / scale[i]
        largest = max(largest, total)
    return largest


def grow(A, size, reached, h):
    """exp(A·h) − 1, by squaring the difference itself: the difference keeps the digits that the sum would lose.

    The last three rows of A say that F grows by F′ and that F′ and 1 stay: they are not multiplied out.
    """
    n = size - 3
    halvings = 0
    while reached * h > 0.25 and halvings < 60:
        h *= 0.5
        halvings += 1
    E = np.zeros((size, size))
    F = np.zeros((size, size))
    for order in range(14, 0, -1):
        for i in range(n):
            for j in range(size):
                total = A[i, j]
                for l in range(n):
                    total += A[i, l] * E[l, j]
                F[i, j] = total * h / order
            F[i, n + 1] += A[i, n] * E[n, n + 1] * h / order
        F[n, n + 1] = h / order
        E, F = F, E
    for _ in range(halvings):
        square(E, F)
        E, F = F, E
    return E


def square(E, F):
    """F + 1 = (E + 1)², both of them of the form that `grow` has."""
    size = E.shape[0]
    n = size - 3
    for i in range(n):
        for j in range(size):
            total = 2.0 * E[i, j]
            for l in range(n):
                total += E[i, l] * E[l, j]
            F[i, j] = total
        F[i, n + 1] += E[i, n] * E[n, n + 1]
    F[n, n + 1] = 2.0 * E[n, n + 1]


def copy(E, into):
    """Copy a square matrix."""
    for i in range(E.shape[0]):
        for j in range(E.shape[0]):
            into[i, j] = E[i, j]


def advance(A, size, reached, Y, h, out, work):
    """Y after the time h: by the power series, in a few steps, or by the matrix exponential where those are many."""
    n = size - 3
    for i in range(size):
        out[i] = Y[i]
    if h == 0.0:
        return
    turns = reached * abs(h)
    if turns > 6.0:
        E = grow(A, size, reached, h)
        for i in range(n + 1):
            for j in range(size):
                out[i] += E[i, j] * Y[j]
        return
    steps = int(turns) + 1
    h = h / steps
    order = 9 + int(12.0 * turns / steps)
    for _ in range(steps):
        for i in range(n):  # the first term carries the force, its growth and the constant
            total = A[i, n] * out[n] + A[i, n + 2]
            for j in range(n):
                total += A[i, j] * out[j]
            work[0, i] = total * h
        rise = out[n + 1] * h
        for i in range(n):
            out[i] += work[0, i]
        now, then = 0, 1
        for o in range(2, order + 1):
            scale = h * INVERSE[o]
            idle = True
            for i in range(n):
                total = 0.0
                for j in range(n):
                    total += A[i, j] * work[now, j]
                if o == 2:
                    total += A[i, n] * rise
                work[then, i] = total * scale
                out[i] += work[then, i]
                idle = idle and total == 0.0
            if idle:  # the series of a free motion ends by itself
                break
            now, then = then, now
        out[n] += rise


def dip(a, da, b, db, h):
    """Where in (0, h) the cubic through two values and slopes is least; −1 where it is not inside."""
    if not (da < 0.0 < db):
        return -1.0
    slope = (b - a) / h
    alpha = 3.0 * (da + db - 2.0 * slope)
    beta = 2.0 * (3.0 * slope - 2.0 * da - db)
    if abs(alpha) < 1e-12 * abs(beta):
        return -da / beta * h if beta > 0.0 else -1.0
    inside = beta * beta - 4.0 * alpha * da
    if inside < 0.0:
        return -1.0
    place = (-beta + math.sqrt(inside)) / (2.0 * alpha)
    return place * h if 0.0 < place < 1.0 else -1.0


def is_quiet(Y, A, W, n, slope):
    """Whether the oscillation about equilibrium is too small for any event, up to the end of the thrust segment."""
    if n != 2 or slope != 0.0 or not (A[V, X] < 0.0 and A[V, V] <= 0.0 and A[X, V] == 1.0):
        return False
    stiffness = -A[V, X]
    centre = (A[V, n] * Y[n] + A[V, n + 2]) / stiffness
    size = math.sqrt((Y[X] - centre) ** 2 + Y[V] ** 2 / stiffness)
    for i in range(WATCHED):
        rest = W[i, X] * centre + W[i, n] * Y[n] + W[i, n + 2]
        swing = math.sqrt(W[i, X] ** 2 + W[i, V] ** 2 * stiffness) * size
        if rest <= swing and swing > 0.0:
            return False
        if swing == 0.0 and rest < 0.0:
            return False
    return True


def linear_root(A, W, G, i, size, reached, Y, low, high, guess, probe, work):
    """Time in (low, high) at which row i of W·Y falls through zero: Newton's steps kept inside a shrinking bracket.

    Where the power series of the state converges over the bracket, that of row i is made once and then evaluated.
    """
    n = size - 3
    order = 0
    series, term = work[9], work[10]
    if reached * high <= 2.0:
        order = 9 + int(12.0 * reached * high)
        for j in range(size):
            term[j] = Y[j]
        series[0] = inner(W, i, Y, size)
        for o in range(1, order + 1):
            for j in range(n):
                total = 0.0
                for l in range(n + 1):
                    total += A[j, l] * term[l]
                work[0, j] = (total + A[j, n + 2] * term[n + 2]) * INVERSE[o]
            term[n], term[n + 1], term[n + 2] = term[n + 1] * INVERSE[o], 0.0, 0.0
            total = W[i, n] * term[n]
            for j in range(n):
                term[j] = work[0, j]
                total += W[i, j] * term[j]
            series[o] = total
    t = guess
    for _ in range(100):
        value, slope = 0.0, 0.0
        if order > 0:
            for o in range(order, -1, -1):
                slope = slope * t + value
                value = value * t + series[o]
        else:
            advance(A, size, reached, Y, t, probe, work)
            value, slope = inner(W, i, probe, size), inner(G, i, probe, size)
        if value > 0.0:
            low = t
        else:
            high = t
        step = value / slope if slope < 0.0 else 0.0
        t_next = t - step
        if slope >= 0.0 or not (low <= t_next <= high):
            t_next = 0.5 * (low + high)
        if abs(t_next - t) <= 1e-9 * t_next and slope < 0.0:
            return t_next  # Newton's next step would be the square of this one
        if high - low <= 1e-15 * high:
            return t_next
        t = t_next
    return t


def linear_event(A, W, G, n, reached, omega, Y, length, budget, E, kept, work):
    """First event of a linear regime within `length`: its time and number (−1 for none), and the steps taken.

    `E` keeps exp(A·h) − 1 for the step h, `kept[0]`.
    """
    size = n + 3
    g, dg, gb, dgb = work[2], work[3], work[4], work[5]
    here, there, probe = work[6], work[7], work[8]
    for i in range(size):
        here[i] = Y[i]
    h = 1.0 / omega if omega > 0.0 else 0.25 * length
    live = np.empty(WATCHED, np.int64)
    count = 0
    for i in range(WATCHED):
        moving = False
        for j in range(size - 1):
            moving = moving or W[i, j] != 0.0
        if moving or W[i, size - 1] < 0.0:
            live[count] = i
            count += 1
    measure(W, G, live, count, size, here, g, dg)
    if count == 0 or is_quiet(here, A, W, n, here[n + 1]):
        return length, -1, 0
    done, steps = 0.0, 0
    while done < length and steps < budget:
        steps += 1
        if omega > 0.0 and length - done > h:
            if kept[0] != h:
                kept[0] = h
                copy(grow(A, size, reached, h), E)
            for i in range(size):
                total = here[i]
                for j in range(size):
                    total += E[i, j] * here[j]
                there[i] = total
            step = h
        else:
            step = min(h, length - done)
            advance(A, size, reached, here, step, there, work)
        measure(W, G, live, count, size, there, gb, dgb)
        first, which = 2.0 * step, -1
        for l in range(count):
            i = live[l]
            if g[i] <= 0.0 and (dg[i] < 0.0 or (dg[i] == 0.0 and gb[i] < 0.0)):
                return done, i, steps
            low, high = 0.0, -1.0
            if gb[i] < 0.0:
                high = step
                if g[i] <= 0.0:  # starts on the edge, inward: pass over the hill first
                    low = hill(A, W, size, reached, here, i, step, probe, work)
            else:
                place = dip(g[i], dg[i], gb[i], dgb[i], step)
                if place > 0.0 and g[i] > 0.0:
                    advance(A, size, reached, here, place, probe, work)
                    if inner(W, i, probe, size) < 0.0:
                        high = place
            if high > first > low:  # whether it comes before the one that is known
                advance(A, size, reached, here, first, probe, work)
                if inner(W, i, probe, size) > 0.0:
                    continue
                high = first
            if high > 0.0 and low < first:
                guess = 0.5 * (low + high)
                if low == 0.0 and high == step:
                    guess = step * g[i] / (g[i] - gb[i])
                root = linear_root(A, W, G, i, size, reached, here, low, high, guess, probe, work)
                if root < first:
                    first, which = root, i
        if which >= 0:
            return done + first, which, steps
        for i in range(size):
            here[i] = there[i]
        for l in range(count):
            g[live[l]], dg[live[l]] = gb[live[l]], dgb[live[l]]
        done += step
        if steps % 32 == 0 and is_quiet(here, A, W, n, here[n + 1]):
            break
    return length, -1, steps


def inner(W, i, Y, size):
    """Row i of W times Y."""
    total = 0.0
    for j in range(size):
        total += W[i, j] * Y[j]
    return total


def measure(W, G, live, count, size, Y, g, dg):
    """Values of what is watched, and their rates."""
    for l in range(count):
        g[live[l]] = inner(W, live[l], Y, size)
        dg[live[l]] = inner(G, live[l], Y, size)


def hill(A, W, size, reached, Y, i, step, probe, work):
    """Find a time at which row i is positive, between an inward start on its zero and a negative value at `step`."""
    t = step
    for _ in range(60):
        t *= 0.5
        advance(A, size, reached, Y, t, probe, work)
        if inner(W, i, probe, size) > 0.0:
            return t
    return 0.0


def fill(
    A, n, reached, rows, Y, t, stop, last, grid, span, spacing, shift, first, outs, channels, tables, leap, kept, work
):  # fmt: skip
    """Write some channels' samples from `t` on, those before `stop` (at it, too, where `last`); give the next index.

    The channels share their stamps. Evenly spaced samples go a block at a time: `tables` hold row·exp(A·dt·b) for each
    b of a block, `leap` is exp(A·dt·BLOCK) − 1; both are made once for a regime and a spacing, which is `kept[0]`.
    """
    size = n + 3
    i = first
    y, rest, begun = np.empty(size), np.empty(BLOCK), Y.copy()
    found, basis = np.empty((3, NODES + BLOCK)), np.empty((NODES, 1))
    low, high = channels
    alone = first
    while i < grid.shape[0]:
        stamp = grid[i] - shift
        if stamp > stop or (stamp == stop and not last):
            break
        advance(A, size, reached, begun, stamp - t, y, work)
        # On from here: from the start of a leg each sample would take a matrix exponential.
        t = stamp
        for j in range(size):
            begun[j] = y[j]
        end, dt = span[i], spacing[i]
        alone = uneven(grid, span, shift, max(alone, i), stop)
        if is_dense(grid, i, alone, reached):
            dt = fine(grid, i, alone, reached)
            if kept[0] != dt:
                kept[0] = dt
                tabulate(A, size, reached, rows, dt, channels, tables, leap)
            advance(A, size, reached, begun, -BEFORE * dt, y, work)
            read_even(y, n, tables, leap, grid, shift, i, alone, dt, outs, channels, found, basis, rest)
            i = alone
            continue
        if end == i:
            for channel in range(low, high):
                total = 0.0
                for j in range(size):
                    total += rows[channel, j] * y[j]
                outs[channel][i] = total
            i += 1
            continue
        if grid[end] - shift >= stop:
            end = min(end, i + int((stop - stamp) / dt) + 1)
            while end > i and (grid[end] - shift > stop or (grid[end] - shift == stop and not last)):
                end -= 1
        if kept[0] != dt:
            kept[0] = dt
            tabulate(A, size, reached, rows, dt, channels, tables, leap)
        blocks = (end - i) // BLOCK + 1
        states = np.empty((blocks, n + 1))
        for j in range(n + 1):
            states[0, j] = y[j]
        for q in range(1, blocks):
            for j in range(n):
                total = states[q - 1, j] + leap[j, n + 1] * y[n + 1] + leap[j, n + 2]
                for l in range(n + 1):
                    total += leap[j, l] * states[q - 1, l]
                states[q, j] = total
            states[q, n] = states[q - 1, n] + leap[n, n + 1] * y[n + 1]
        for channel in range(low, high):
            table, out = tables[channel], outs[channel]
            by_x, by_v = table[X], table[V]
            for q in range(blocks):
                part = out[i + q * BLOCK : min(i + (q + 1) * BLOCK, end + 1)]
                if q == 0 or y[n + 1] != 0.0:
                    for b in range(BLOCK):
                        rest[b] = table[n, b] * states[q, n] + table[n + 1, b] * y[n + 1] + table[n + 2, b]
                if n == 2:
                    x, v = states[q, X], states[q, V]
                    for b in range(part.shape[0]):
                        part[b] = rest[b] + by_x[b] * x + by_v[b] * v
                else:
                    for b in range(part.shape[0]):
                        total = rest[b]
                        for j in range(n):
                            total += table[j, b] * states[q, j]
                        part[b] = total
        i = end + 1
    return i


def uneven(grid, span, shift, alone, stop):
    """Give the end of the stretch, known to last to `alone`, in which no spacing recurs, before `stop`."""
    while alone < grid.shape[0] and span[alone] == alone and grid[alone] - shift < stop:
        alone += 1
    return alone


def is_dense(grid, i, alone, reached):
    """Whether stamps from `i` to before `alone` are read sooner from even nodes than each by itself."""
    return alone - i >= FEW and (grid[alone - 1] - grid[i]) * reached < FINE * SPARSE * (alone - i)


def fine(grid, i, alone, reached):
    """Spacing of even nodes / s; no longer than the stretch, where a free motion has no rate."""
    long = grid[alone - 1] - grid[i]
    return long if long * reached <= FINE else FINE / reached


def lagrange(theta, nodes, bary, basis, at):
    """Fill column `at` of `basis` with the Lagrange polynomials of the nodes at `theta`."""
    total = 0.0
    for q in range(nodes.shape[0]):
        apart = theta - nodes[q]
        if apart == 0.0:
            for l in range(nodes.shape[0]):
                basis[l, at] = 0.0
            basis[q, at] = 1.0
            return
        basis[q, at] = bary[q] / apart
        total += basis[q, at]
    for q in range(nodes.shape[0]):
        basis[q, at] /= total


def window(since, dt, held, basis):
    """Give the first of the `NODES` even nodes around an instant, and their polynomials there; −1 if not yet held."""
    where = since / dt
    node = max(int(where) - BEFORE, 0)
    if node + NODES > held:
        return -1
    lagrange(where - node, EVEN, BARY, basis, 0)
    return node


def read_even(y, n, tables, leap, grid, shift, i, alone, dt, outs, channels, found, basis, rest):
    """Write the samples from `i` to before `alone` by polynomials through even nodes; `y` is `BEFORE`·dt before them.

    The linear flow goes on beyond both ends of its leg, so that each stamp stands in the middle of its nodes.
    """
    low, high = channels
    begun, held = grid[i] - shift - BEFORE * dt, 0
    while i < alone:
        kept = min(held, NODES - 1)
        for channel in range(low, high):
            part, table = found[channel], tables[channel]
            for b in range(kept):
                part[b] = part[held - kept + b]
            for b in range(BLOCK):
                part[kept + b] = table[n + 2, b]
            for j in range(n + 2):
                for b in range(BLOCK):
                    part[kept + b] += table[j, b] * y[j]
        begun += (held - kept) * dt
        held = kept + BLOCK
        for j in range(n):
            total = y[j] + leap[j, n + 1] * y[n + 1] + leap[j, n + 2]
            for l in range(n + 1):
                total += leap[j, l] * y[l]
            rest[j] = total
        for j in range(n):
            y[j] = rest[j]
        y[n] += leap[n, n + 1] * y[n + 1]
        while i < alone:
            node = window(grid[i] - shift - begun, dt, held, basis)
            if node < 0:
                break
            for channel in range(low, high):
                total = 0.0
                for b in range(NODES):
                    total += basis[b, 0] * found[channel, node + b]
                outs[channel][i] = total
            i += 1


def tabulate(A, size, reached, rows, dt, channels, tables, leap):
    """Fill `tables` and `leap` of `fill`."""
    E = grow(A, size, reached, dt)
    for channel in range(channels[0], channels[1]):
        table = tables[channel]
        for j in range(size):
            table[j, 0] = rows[channel, j]
        for b in range(1, BLOCK):
            for j in range(size):
                entry = table[j, b - 1]
                for l in range(size - 2):
                    entry += table[l, b - 1] * E[l, j]
                table[j, b] = entry
    width = 1
    while width < BLOCK:
        square(E, leap)
        copy(leap, E)
        width *= 2


def linear_leg(
    A, W, G, rows, n, reached, omega, Y, t, stop, last, grids, spans, spacings, shifts, firsts, outs, budget, together,
    tables, leaps, kept, work,
):  # fmt: skip
    """Follow a linear regime from `t` to its first event, or to `stop`: samples written, Y moved on."""
    length, which, steps = linear_event(A, W, G, n, reached, omega, Y, stop - t, budget, leaps[3], kept[3:], work)
    ends = stop if which < 0 else t + length
    for channel in range(3):
        if channel > 0 and together:
            firsts[channel] = firsts[0]
            continue
        channels = (0, 3) if together else (channel, channel + 1)
        firsts[channel] = fill(
            A, n, reached, rows, Y, t, ends, last and which < 0,
            grids[channel], spans[channel], spacings[channel], shifts[channel], firsts[channel], outs, channels,
            tables, leaps[channel], kept[channel:], work,
        )  # fmt: skip
    after = np.empty(n + 3)
    advance(A, n + 3, reached, Y, length, after, work)
    for i in range(n + 3):
        Y[i] = after[i]
    return length, which, steps


# ---- steps of a nonlinear regime ------------------------------------------------------------------------------------
def lagged(y, F, slope, after, p, at, out):
    """Put the lagging thrust, known in closed form, into the state `out` some time after `y`.

    A short lag would be stiff otherwise: the steps would follow it for ever, long after it has died away.
    """
    if p[LAG] > 0.0:
        behind = F - slope * p[LAG]
        out[at[THRUST]] = behind + slope * after + (y[at[THRUST]] - behind) * math.exp(-after / p[LAG])


def take_step(y, F, slope, h, r, p, kind, at, pair, stages, new, probe):
    """One step of the 8th-order pair: fills `stages` and `new`; `stages[0]` has to be there."""
    a, b, c = pair[0], pair[1], pair[2]
    n = kind[N]
    for s in range(1, 12):
        for i in range(n):
            total = 0.0
            for j in range(s):
                total += a[s, j] * stages[j, i]
            probe[i] = y[i] + h * total
        lagged(y, F, slope, c[s] * h, p, at, probe)
        motion(probe, F + slope * c[s] * h, r, p, kind, at, stages[s])
    for i in range(n):
        total = 0.0
        for j in range(12):
            total += b[j] * stages[j, i]
        new[i] = y[i] + h * total
    lagged(y, F, slope, h, p, at, new)
    motion(new, F + slope * h, r, p, kind, at, stages[12])


def misfit(y, new, largest, h, n, at, pair, stages):
    """Estimated error of the step over what is allowed.

    Displacements of frame, yaw and line act through e alone, an appendage through its acceleration, so that what is
    small beside x need not be followed.
    """
    e3, e5 = pair[3], pair[4]
    sum3, sum5 = 0.0, 0.0
    for i in range(n):
        if i == at[THRUST] or i == at[TIME]:  # exact
            continue
        scale = largest[i]
        line = i == at[RELAXED] or i == at[RELAXED_B] or i == at[LOOP]
        if line or i == at[FRAME_U] or i == at[YAW_U] or i == at[APPENDAGE_U]:
            scale = max(scale, largest[X])
        elif i == at[FRAME_V] or i == at[YAW_V] or i == at[APPENDAGE_V]:
            scale = max(scale, largest[V])
        err3, err5 = 0.0, 0.0
        for j in range(13):
            err3 += e3[j] * stages[j, i]
            err5 += e5[j] * stages[j, i]
        allowed = RTOL * (max(abs(y[i]), abs(new[i])) + 1e-3 * scale) + 1e-17
        sum3 += (err3 / allowed) ** 2
        sum5 += (err5 / allowed) ** 2
    if sum5 == 0.0 and sum3 == 0.0:
        return 0.0
    return abs(h) * sum5 / math.sqrt((sum5 + 0.01 * sum3) * n)


def growth(error):
    """Factor from a step that was taken to the next, at most 2."""
    return 0.9 * max(error, LEAST_ERROR) ** -0.125


def make_dense(y, new, F, slope, h, r, p, kind, at, pair, stages, dense, probe):
    """Coefficients of the 7th-order interpolant of a step."""
    d, a_extra, c_extra = pair[5], pair[6], pair[7]
    n = kind[N]
    for s in range(3):
        for i in range(n):
            total = 0.0
            for j in range(13 + s):
                total += a_extra[s, j] * stages[j, i]
            probe[i] = y[i] + h * total
        lagged(y, F, slope, c_extra[s] * h, p, at, probe)
        motion(probe, F + slope * c_extra[s] * h, r, p, kind, at, stages[13 + s])
    for i in range(n):
        change = new[i] - y[i]
        dense[0, i] = change
        dense[1, i] = h * stages[0, i] - change
        dense[2, i] = 2.0 * change - h * (stages[12, i] + stages[0, i])
        for q in range(4):
            total = 0.0
            for j in range(16):
                total += d[q, j] * stages[j, i]
            dense[3 + q, i] = h * total


def read_dense(y, F, slope, h, p, kind, at, dense, theta, out):
    """State at the share `theta` of the step."""
    rest = 1.0 - theta
    for i in range(kind[N]):
        total = dense[3, i] + theta * (dense[4, i] + rest * (dense[5, i] + theta * dense[6, i]))
        out[i] = y[i] + theta * (dense[0, i] + rest * (dense[1, i] + theta * (dense[2, i] + rest * total)))
    lagged(y, F, slope, theta * h, p, at, out)


def rates(y, F, slope, dy, g, r, p, kind, at, probe, other, dg):
    """Rates of what is watched along the motion."""
    step = 1e-6
    for i in range(kind[N]):
        probe[i] = y[i] + step * dy[i]
    watch(probe, F + slope * step, r, p, kind, at, other)
    for i in range(WATCHED):
        dg[i] = (other[i] - g[i]) / step


def dense_root(y, F, slope, h, i, low, high, r, p, kind, at, dense, probe, other):
    """Share of the step in (low, high) at which entry i of `watch` falls through zero, by the secant in a bracket."""
    read_dense(y, F, slope, h, p, kind, at, dense, low, probe)
    watch(probe, F + slope * low * h, r, p, kind, at, other)
    a = max(other[i], 0.0)
    read_dense(y, F, slope, h, p, kind, at, dense, high, probe)
    watch(probe, F + slope * high * h, r, p, kind, at, other)
    b = other[i]
    side = 0
    for _ in range(200):
        theta = high - b * (high - low) / (b - a) if b != a else 0.5 * (low + high)
        if not (low < theta < high):
            theta = 0.5 * (low + high)
        read_dense(y, F, slope, h, p, kind, at, dense, theta, probe)
        watch(probe, F + slope * theta * h, r, p, kind, at, other)
        if other[i] > 0.0:
            low, a = theta, other[i]
            if side == 1:
                b *= 0.5
            side = 1
        else:
            high, b = theta, other[i]
            if side == -1:
                a *= 0.5
            side = -1
        if high - low <= 1e-15 or other[i] == 0.0:
            break
    return high


def step_event(y, F, slope, h, g, dg, gb, dgb, r, p, kind, at, dense, probe, other):
    """First event within a step: its share of the step and its number, −1 for none."""
    first, which = 2.0, -1
    for i in range(WATCHED):
        if g[i] <= 0.0 and (dg[i] < 0.0 or (dg[i] == 0.0 and gb[i] < 0.0)):
            return 0.0, i
        low, high = 0.0, -1.0
        if gb[i] < 0.0:
            high = 1.0
            if g[i] <= 0.0:
                theta = 1.0
                for _ in range(60):
                    theta *= 0.5
                    read_dense(y, F, slope, h, p, kind, at, dense, theta, probe)
                    watch(probe, F + slope * theta * h, r, p, kind, at, other)
                    if other[i] > 0.0:
                        low = theta
                        break
        else:
            place = dip(g[i], dg[i], gb[i], dgb[i], h) / h
            if place > 0.0 and g[i] > 0.0:
                read_dense(y, F, slope, h, p, kind, at, dense, place, probe)
                watch(probe, F + slope * place * h, r, p, kind, at, other)
                if other[i] < 0.0:
                    high = place
        if high > 0.0 and low < first:
            root = dense_root(y, F, slope, h, i, low, high, r, p, kind, at, dense, probe, other)
            if root < first:
                first, which = root, i
    return first, which


def first_size(y, dy, length, omega, largest):
    """Size of a first step."""
    h = length
    if omega > 0.0:
        h = min(h, FIRST / omega)
    if abs(dy[V]) > 0.0:
        speed = max(abs(y[V]), 1e-3 * largest[V])
        h = min(h, max(0.1 * speed / abs(dy[V]), 1e-3 * length))
    return h


def put_step(
    y, F, slope, h, t, ends, closed, r, p, kind, at, dense, grids, shifts, firsts, outs, together, probe
):  # fmt: skip
    """Write the samples of a step that begins at `t`, those before `ends` (at it, too, where `closed`)."""
    for channel in range(1 if together else 3):
        i, grid, shift = firsts[channel], grids[channel], shifts[channel]
        while i < grid.shape[0]:
            stamp = grid[i] - shift
            if stamp > ends or (stamp == ends and not closed):
                break
            read_dense(y, F, slope, h, p, kind, at, dense, (stamp - t) / h, probe)
            if channel == 0:
                outs[0][i] = probe[X] + p[TAUT] + p[SLIP] * r[SLIPPED]
            if channel == 1 or together:
                outs[1][i] = probe[V]
            if channel == 2 or together:
                outs[2][i] = tension(probe, r, p, kind, at)
            i += 1
        firsts[channel] = i
    if together:
        firsts[1], firsts[2] = firsts[0], firsts[0]


def curved_leg(
    F, slope, y, r, p, kind, at, pair, largest, t, stop, last, grids, shifts, firsts, outs, budget, together
):  # fmt: skip
    """Follow a nonlinear regime from `t` to its first event, or to `stop`: samples written, y moved on."""
    n = kind[N]
    stages, dense = np.zeros((16, SIZE)), np.zeros((7, SIZE))
    new, probe, probe2, other = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE), np.zeros(WATCHED)
    g, dg, gb, dgb = np.zeros(WATCHED), np.zeros(WATCHED), np.zeros(WATCHED), np.zeros(WATCHED)
    omega = fastest(r, p, kind)
    length, done, steps = stop - t, 0.0, 0
    motion(y, F, r, p, kind, at, stages[0])
    watch(y, F, r, p, kind, at, g)
    rates(y, F, slope, stages[0], g, r, p, kind, at, probe, other, dg)
    h = first_size(y, stages[0], length, omega, largest)
    if p[LAG] > 0.0 and y[at[THRUST]] != F:
        h = min(h, p[LAG])
    limit = 2.0 / omega if omega > 0.0 else length
    limit = min(limit, length / 4.0)
    budget = min(budget, int(LEG_STEPS + PER_RADIAN * omega * length))
    while done < length and steps < budget:
        steps += 1
        h = min(h, limit)
        if done + h * 1.0000001 >= length:
            h = length - done
        take_step(y, F, slope, h, r, p, kind, at, pair, stages, new, probe)
        error = misfit(y, new, largest, h, n, at, pair, stages)
        if not error < 1.0 and h <= 1e-14 * max(1.0, abs(t)):
            y[X] = np.nan
            return done, -1, steps
        if not error < 1.0:
            h *= max(0.2, 0.9 * error**-0.125) if error == error and error < 1e300 else 0.1
            continue
        make_dense(y, new, F, slope, h, r, p, kind, at, pair, stages, dense, probe)
        watch(new, F + slope * h, r, p, kind, at, gb)
        rates(new, F + slope * h, slope, stages[12], gb, r, p, kind, at, probe, other, dgb)
        theta, which = step_event(y, F, slope, h, g, dg, gb, dgb, r, p, kind, at, dense, probe, other)
        ends = t + done + (h if which < 0 else theta * h)
        at_stop = which < 0 and done + h >= length
        if at_stop:
            ends = stop
        put_step(
            y, F, slope, h, t + done, ends, at_stop and last, r, p, kind, at, dense,
            grids, shifts, firsts, outs, together, probe2,
        )  # fmt: skip
        if which >= 0:
            read_dense(y, F, slope, h, p, kind, at, dense, theta, probe2)
            for i in range(n):
                y[i] = probe2[i]
            return done + theta * h, which, steps
        for i in range(n):
            y[i] = new[i]
            stages[0, i] = stages[12, i]
            largest[i] = max(largest[i], abs(y[i]))
        for i in range(WATCHED):
            g[i], dg[i] = gb[i], dgb[i]
        F += slope * h
        done += h
        h *= growth(error)
    if done < length:
        return done, EXHAUSTED, steps
    return length, -1, steps


# ---- a run ----------------------------------------------------------------------------------------------------------
def regime_code(r):
    """One number for a regime."""
    code = 0
    for i in range(REGIME):
        code = code * 4 + r[i] + 1
    return code


def note(code, r, p):
    """One number for what happened, and the contact and the sliding that followed.

    A sagging line always pulls a little: it is reported as slack where its ends are nearer than its length.
    """
    contact = r[CONTACT]
    if p[SAG] > 0.0 and r[CAPPED] == 1:
        contact = BELOW
    return code * 100 + contact * 10 + r[SLIDE] + 1


def thrust_at(t, piece, part, edges, forces, slopes, added, p):
    """Force F on the module and its growth: G·F_cmd(t − t_d), and the added one, which the thrusters leave as it is.

    A thrust that fades falls in proportion to the time since its first edge, by what it is at the edge of each piece.
    A lagging thruster follows F_cmd by F′_l = (F_cmd − F_l)/τ; then F_l + F_a follows F_cmd + F_a + τ·F_a′.
    """
    F, slope = 0.0, 0.0
    if piece >= 0:
        left = 1.0 - p[FADING] * (edges[piece] - edges[0])
        slope = p[GAIN] * (left * slopes[piece] - p[FADING] * forces[piece])
        F = p[GAIN] * left * forces[piece] + slope * (t - p[DELAY] - edges[piece])
    if part >= 0:
        F += added[1, part] + added[2, part] * (t - added[0, part] + p[LAG])
        slope += added[2, part]
    return F, slope


def lead_in(start, grids, shifts, firsts, x0, v0, tension0, outs):
    """Write the samples before the start: the start state."""
    for channel in range(3):
        grid, i = grids[channel], 0
        while i < grid.shape[0] and grid[i] - shifts[channel] < start[2]:
            lead = grid[i] - shifts[channel] - start[2]
            outs[channel][i] = x0 + v0 * lead if channel == 0 else (v0 if channel == 1 else tension0)
            i += 1
        firsts[channel] = i


# A leg, the motion between two events: when it begins and how long it lasts, the thrust and its growth, what ends it,
# the pieces of the thrust and of the added force, the state and the regime at its start.
SINCE, SPAN, PUSH, GROWTH, ENDING, PIECE, PART, STATE = range(8)
RULES = STATE + SIZE
LEG = RULES + REGIME


def keep_leg(legs, row, t, F, slope, piece, part, y, r):
    """Enter the start of a leg into the table, where there is one, and the end of the table after it."""
    if row + 1 >= legs.shape[0]:
        return
    legs[row, SINCE], legs[row, PUSH], legs[row, GROWTH] = t, F, slope
    legs[row, PIECE], legs[row, PART], legs[row + 1, SINCE] = piece, part, np.nan
    for i in range(SIZE):
        legs[row, STATE + i] = y[i]
    for i in range(REGIME):
        legs[row, RULES + i] = r[i]


def prepare(r, p, kind, at, A, W, G, rows, kept):
    """Fill the matrices of a linear regime; give its bounds."""
    n = kind[N]
    size = n + 3
    for channel in range(4):
        kept[channel] = 0.0
    assemble(r, p, kind, at, A, W, rows)
    for i in range(WATCHED):
        for j in range(size):
            G[i, j] = 0.0
            for l in range(size):
                G[i, j] += W[i, l] * A[l, j]
    omega = fastest(r, p, kind)
    return reach(A, n, omega), omega


def clear(r, known, largest):
    """Begin a run afresh."""
    for i in range(REGIME):
        r[i] = 0
    for i in range(KEPT):
        known[i] = -1
    for i in range(SIZE):
        largest[i] = 0.0


def unwritten(outs, grids, t):
    """Leave no number from `t` on."""
    for channel in range(3):
        for i in range(grids[channel].shape[0]):
            if grids[channel][i] >= t:
                outs[channel][i] = np.nan


def march_many(
    many, kind, at, pair, start, edges, forces, slopes, added, grids, spans, spacings, outs, times, codes, states, legs
):  # fmt: skip
    """Follow one run for each row of parameters in `many`; `outs` hold a row each, `states` (rows, 4) the outcome.

    `start` = (x0, v0, t0, release, end). `edges`, `forces`, `slopes` (n,): from an edge on, F = force + slope·(t −
    edge); none before the first; `added` (3, n): the same of the added force. `grids`, `spans`, `spacings`, `outs`:
    three channels' stamps, for each stamp the last one of its evenly spaced stretch and the spacing there, and the
    samples. `times`, `codes`: the events. The outcome is status, number of events, last time. `legs` (n, LEG) takes the
    legs of the last run; it may be empty.
    """
    n = kind[N]
    size = n + 3
    r, y = np.zeros(REGIME, np.int64), np.zeros(SIZE)
    shifts, firsts, largest = np.zeros(3), np.zeros(3, np.int64), np.zeros(SIZE)
    A, W, G = np.zeros((KEPT, size, size)), np.zeros((KEPT, WATCHED, size)), np.zeros((KEPT, WATCHED, size))
    rows, reached, omega = np.zeros((KEPT, 3, size)), np.zeros(KEPT), np.zeros(KEPT)
    known = np.zeros(KEPT, np.int64)
    tables, leaps, kept = np.zeros((KEPT, 3, size, BLOCK)), np.zeros((KEPT, 4, size, size)), np.zeros((KEPT, 4))
    Y, work = np.zeros(size), np.empty((11, 40))
    for row in range(many.shape[0]):
        p, out = many[row], (outs[0][row], outs[1][row], outs[2][row])
        clear(r, known, largest)
        fresh = 0
        shifts[0], shifts[1], shifts[2] = p[CLOCK_X], p[CLOCK_V], p[CLOCK_T]
        together = kind[TOGETHER] == 1 and shifts[0] == shifts[1] and shifts[1] == shifts[2]
        t, end = start[2], start[4]
        piece, part = -1, -1
        while piece + 1 < edges.shape[0] and edges[piece + 1] + p[DELAY] <= t:
            piece += 1
        while part + 1 < added.shape[1] and added[0, part + 1] <= t:
            part += 1
        F, slope = thrust_at(t, piece, part, edges, forces, slopes, added, p)
        x0, v0 = start[0] + p[START_X], start[1] + p[START_V]
        if start[3] > t:
            v0 = 0.0
        begin(y, F, r, p, kind, at, x0, v0)
        if part >= 0 and p[LAG] > 0.0:
            y[at[THRUST]] = added[1, part] + added[2, part] * (t - added[0, part])
            if r[HELD] == 0:
                grip(y, F, r, p, kind, at)
        if at[TIME] != NOTHING:
            y[at[TIME]] = t
            if r[HELD] == 0:
                grip(y, F, r, p, kind, at)
        if start[3] > t:
            r[HELD], r[SLIDE] = 1, 0
        lead_in(start, grids, shifts, firsts, x0, v0, tension(y, r, p, kind, at), out)
        times[0], codes[0] = t, note(START, r, p)
        events, steps, curved, still, status, leg = 1, 0, 0, 0, -1, 0
        while status < 0:
            stop, edge = end, 0
            if piece + 1 < edges.shape[0] and edges[piece + 1] + p[DELAY] < stop:
                stop, edge = max(edges[piece + 1] + p[DELAY], t), FORCE
            if part + 1 < added.shape[1] and added[0, part + 1] < stop:
                stop, edge = max(added[0, part + 1], t), ADDED
            if r[HELD] == 1 and start[3] <= stop:
                stop, edge = start[3], RELEASE
            last = edge == 0
            keep_leg(legs, leg, t, F, slope, piece, part, y, r)
            if is_linear(r, p, kind):
                code = regime_code(r)
                slot = -1
                for q in range(KEPT):
                    if known[q] == code:
                        slot = q
                if slot < 0:
                    slot, fresh = fresh, (fresh + 1) % KEPT
                    known[slot] = code
                    reached[slot], omega[slot] = prepare(
                        r, p, kind, at, A[slot], W[slot], G[slot], rows[slot], kept[slot]
                    )  # fmt: skip
                for i in range(n):
                    Y[i] = y[i]
                Y[n], Y[n + 1], Y[n + 2] = F, slope, 1.0
                length, which, taken = linear_leg(
                    A[slot], W[slot], G[slot], rows[slot], n, reached[slot], omega[slot], Y, t, stop, last,
                    grids, spans, spacings, shifts, firsts, out, MAX_STEPS - steps, together,
                    tables[slot], leaps[slot], kept[slot], work,
                )  # fmt: skip
                for i in range(n):
                    y[i] = Y[i]
            else:
                length, which, taken = curved_leg(
                    F, slope, y, r, p, kind, at, pair, largest, t, stop, last,
                    grids, shifts, firsts, out, MAX_STEPS - steps, together,
                )  # fmt: skip
                curved += taken
            steps += taken
            for i in range(n):
                largest[i] = max(largest[i], abs(y[i]))
                if not abs(y[i]) < 1e100:
                    status = NOT_FINITE
            if status < 0 and (steps >= MAX_STEPS or which == EXHAUSTED):
                status = TOO_MANY_STEPS
            if status < 0 and kind[WEIGHS] == 1 and -y[X] >= p[LENGTH] > 0.0:
                status = LINE_TOO_SHORT
            if status >= 0:
                break
            F += slope * length
            if leg < legs.shape[0]:
                legs[leg, SPAN], legs[leg, ENDING] = length, which if which >= 0 else (edge if edge > 0 else -1)
            leg += 1
            if which < 0 and edge == 0:
                t, status = end, OK
                break
            still = still + 1 if length <= 1e-15 * max(1.0, abs(t)) else 0
            if still > 60:
                status = CHATTER
                break
            if which >= 0:
                t += length
                code = switch(which, y, F, r, p, kind, at)
            else:
                t, code = stop, edge
                if edge == RELEASE:
                    r[HELD] = 0
                else:
                    piece, part = piece + (edge == FORCE), part + (edge == ADDED)
                    F, slope = thrust_at(t, piece, part, edges, forces, slopes, added, p)
                if y[V] == 0.0 and r[HELD] == 0:
                    grip(y, F, r, p, kind, at)
            if events >= times.shape[0]:
                status = TOO_MANY_EVENTS
            elif code != ADDED and (code != FORCE or slopes[piece] == 0.0):
                times[events] = t
                codes[events] = note(code, r, p)
                events += 1
        states[row, 0], states[row, 1], states[row, 2], states[row, 3] = status, events, t, curved
        if status != OK:
            unwritten(out, grids, t)
