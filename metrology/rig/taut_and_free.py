"""The base model between two events, in closed form: a taut line, a free module, and when each of them ends."""

# Types are inferred by the compiler; long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"

from __future__ import annotations

import math

from metrology.rig.kernel.layout import BELOW, BOTH_WAYS, LIFTED, NO_LINE, STRETCHED

NEVER = math.inf


def propagate(decay, square, t):
    """Return a, b, a′, b′ of u(t) = a·u₀ + b·u₀′, u′(t) = a′·u₀ + b′·u₀′ for u″ + 2δ·u′ + ω₀²·u = 0."""
    rest = square - decay * decay
    if rest > 0.0:
        omega = math.sqrt(rest)
        fall = math.exp(-decay * t)
        even, odd = fall * math.cos(omega * t), fall * math.sin(omega * t) / omega
    elif rest < 0.0:  # in the slow exponential and the difference of the two: no digits lost near critical damping
        beta = math.sqrt(-rest)
        fall, gap = math.exp(-square / (decay + beta) * t), math.expm1(-2.0 * beta * t)
        even, odd = fall * (1.0 + 0.5 * gap), -fall * gap / (2.0 * beta)
    else:
        even = math.exp(-decay * t)
        odd = even * t
    return even + decay * odd, odd, -square * odd, even - decay * odd


def falling(decay, square, q, dq, length):
    """Span of time in which q = a·q₀ + b·q₀′ falls to its deepest value up to `length`."""
    low, high = 0.0, length
    rest = square - decay * decay
    if rest > 0.0:
        omega = math.sqrt(rest)
        phase = -0.5 * math.pi - math.atan2((decay * dq + square * q) / omega, dq)
        phase -= 2.0 * math.pi * math.floor(phase / (2.0 * math.pi))
        return max(0.0, (phase - math.pi) / omega), min(length, phase / omega)
    beta, slope = math.sqrt(-rest), decay * dq + square * q
    if dq * slope > 0.0:
        ratio = dq / slope
        turn = ratio if beta == 0.0 else (math.atanh(beta * ratio) / beta if beta * ratio < 1.0 else NEVER)
    else:
        turn = NEVER
    if dq > 0.0:
        low = turn
    elif dq < 0.0:
        high = min(length, turn)
    return low, high


def slack_time(force, decay, square, q, dq, length):
    """Time at which the tension F + q(t) of a taut line reaches 0, `NEVER` where it does not within `length`.

    The first minimum of q is its deepest, so that one fall decides; Newton's steps are kept inside it.
    """
    low, high = falling(decay, square, q, dq, length)
    if not low < high:
        return NEVER
    a, b, _, _ = propagate(decay, square, high)
    if force + a * q + b * dq >= 0.0:
        return NEVER
    a, b, _, _ = propagate(decay, square, low)
    if force + a * q + b * dq <= 0.0:
        return low
    t, scale = 0.5 * (low + high), high
    for _ in range(100):
        a, b, da, db = propagate(decay, square, t)
        value, slope = force + a * q + b * dq, da * q + db * dq
        if value > 0.0:
            low = t
        else:
            high = t
        after = t - value / slope if slope < 0.0 else low
        if slope >= 0.0 or not low <= after <= high:
            after = 0.5 * (low + high)
        if abs(after - t) <= 1e-15 * scale:
            return after
        t = after
    return t


def rising_root(value, rate, half):
    """First time from which value + rate·t + half·t² is positive, for a start at or below 0."""
    inside = rate * rate - 4.0 * half * value
    if inside < 0.0:
        return NEVER
    if rate > 0.0:
        return max(0.0, -2.0 * value / (rate + math.sqrt(inside)))
    if half > 0.0:
        return (-rate + math.sqrt(inside)) / (2.0 * half)
    return NEVER


def end_of_contact(contact, attachment, x, v, force, m, k, c, length):
    """Time to the next change of contact within `length`, and the contact that follows."""
    if contact == STRETCHED:
        if attachment == BOTH_WAYS:
            return NEVER, contact
        decay, square, u = 0.5 * c / m, k / m, x - force / k
        acceleration = -2.0 * decay * v - square * u
        t = slack_time(force, decay, square, k * u + c * v, k * v + c * acceleration, length)
        return t, LIFTED if c > 0.0 else BELOW
    if attachment == NO_LINE:
        return NEVER, contact
    a = force / m
    if contact == BELOW:
        return rising_root(x, v, 0.5 * a), STRETCHED
    back = rising_root(-x, -v, -0.5 * a)
    pulled = rising_root(k * x + c * v, k * v + c * a, 0.5 * k * a)
    return (back, BELOW) if back <= pulled else (pulled, STRETCHED)


def moved(contact, x, v, force, m, k, c, t):
    """Position beyond taut and velocity after the time t in one regime."""
    if contact != STRETCHED:
        a = force / m
        return x + v * t + 0.5 * a * t * t, v + a * t
    a, b, da, db = propagate(0.5 * c / m, k / m, t)
    u = x - force / k
    return force / k + a * u + b * v, da * u + db * v
