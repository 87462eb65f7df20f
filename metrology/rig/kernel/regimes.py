"""Regimes of contact, sliding, loops and stops: what holds, what ends it, and which one follows."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901

from __future__ import annotations

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    K, TAUT, CAP, SLIP, FRICTION, STATIC_RATIO, BIAS, TOE, FRAME, ARM, INERTIA, YAW_RATE, ZENER, SECOND, HYSTERESIS,
    SAG, CELL_LAG, STOP, SLACK, X, V, NOTHING, SIZE, FRAME_U, YAW_U, RELAXED, RELAXED_B, LOOP, THRUST, SHOWN,
    ATTACHMENT, WEIGHS, TETHER, BOTH_WAYS, NO_LINE, CONTACT, SLIDE, TOE_SIDE, TURN_SIDE, LOOP_SIDE, SIDE, SLIPPED,
    CAPPED, TOUCHED, SLACKENED, HELD, BELOW, STRETCHED, LIFTED, W_EXCESS, W_PULL, W_SPEED, W_GRIP, W_GRIP_BACK, W_TOE,
    W_TOE_BACK, W_TURN, W_LOOP, W_SIDE, W_CAP, W_STOP, W_SLACK, WATCHED, CLAMP, added_slope, is_curved_line,
    is_curved_force, turns, has_sides, has_ways,
)  # fmt: skip
from metrology.rig.kernel.equation import beyond, excess, net_force, pull, relaxed, slackened, stretch, tension


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
    if p[CELL_LAG] > 0.0:
        y[at[SHOWN]] = tension(y, r, p, kind, at)
    r[SLIDE] = 1
    grip(y, thrust, r, p, kind, at)
