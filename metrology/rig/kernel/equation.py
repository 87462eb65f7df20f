"""The equation of motion: stretch and tension of the line, forces on the module, y′ = f(y, F, p)."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901

from __future__ import annotations

import math

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    M, K, C, TAUT, LENGTH, WEIGHT, CAP, SETUP, SLIP, FRICTION, BIAS, TOE, TOE_RATIO, FRAME, FRAME_RATE, FRAME_DAMPING,
    ARM, INERTIA, YAW_RATE, YAW_DAMPING, APPENDAGE, APPENDAGE_RATE, APPENDAGE_DAMPING, ZENER, ZENER_TIME, SECOND,
    SECOND_TIME, HYSTERESIS, YIELD, SAG, LAG, CELL_LAG, STOP, STOP_AT, SLACK, SLACK_AT, SLACK_DAMPING, X, V, NOTHING,
    FRAME_U, FRAME_V, YAW_U, YAW_V, APPENDAGE_U, APPENDAGE_V, RELAXED, RELAXED_B, LOOP, THRUST, SHOWN, TIME,
    ATTACHMENT, WEIGHS, N, NO_LINE, CONTACT, SLIDE, TOE_SIDE, TURN_SIDE, LOOP_SIDE, SLIPPED, CAPPED, TOUCHED,
    SLACKENED, HELD, BELOW, STRETCHED, added_force, added_tension, added_slope, added_damping, has_tension,
)  # fmt: skip

THIRD_TURN = math.pi / 3.0
# 1 − asinh(w)/w = w²/6 − 3·w⁴/40 + …: coefficients by falling power of w².
CATENARY = np.array(
    [-((-1) ** n) * math.factorial(2 * n) / (4**n * math.factorial(n) ** 2 * (2 * n + 1)) for n in range(9, 0, -1)]
)


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


def shown(y, T, p, at):
    """Give what the load cell shows of a tension: of a lagging cell, its state."""
    return y[at[SHOWN]] if p[CELL_LAG] > 0.0 else T


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
    """Fill `dy`: (m − m_a)·x″ = F_net − F_c·(sign(v) + β), and the inner states; return what the cell shows."""
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
    read = shown(y, T, p, at)
    if p[CELL_LAG] > 0.0:
        dy[at[SHOWN]] = (T - read) / p[CELL_LAG]
    if at[RELAXED] == NOTHING and at[RELAXED_B] == NOTHING and at[LOOP] == NOTHING:
        return read
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
    return read
