"""Free motion of a module on a line that holds both ways, by power series in time from one turn to the next.

m·x″ = −F_c·sign v − b·v − b₂·v·|v| − k·e − k₃·e³ − (c + c₁·|e|)·e′, e = x − x_t: between a turn (v = 0) and the next,
and between two passes of e = 0 where c₁ acts, every term is a polynomial of e and v, so the coefficients of e(t) follow
one from another (Jorba & Zou, Experimental Mathematics 14 (2005) 99). One step spans a third of a period to the last
digits and holds its samples and its events as roots of the same polynomial. Forces, sticking and events are those of
`metrology.rig.kernel`, which carries every other effect as well; the two are held to each other by tests.
"""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901

from __future__ import annotations

import numpy as np

from metrology.rig.kernel import (
    CLOCK_T,
    CLOCK_V,
    CLOCK_X,
    FRICTION,
    NOT_FINITE,
    OK,
    START_V,
    START_X,
    STATIC_RATIO,
    TAUT,
    TOO_MANY_STEPS,
    C,
    K,
    M,
)  # fmt: skip
from metrology.rig.parameters import INDEX

AMPLITUDE, CUBIC = INDEX["damping.amplitude"], INDEX["cubic.stiffness"]
VISCOUS, QUADRATIC = INDEX["drag.viscous"], INDEX["drag.quadratic"]
ORDER = 22
"""Coefficients of a step: more cost more than the longer steps save."""
SMALL = 1e-14
"""Last coefficients of a step over its first: what is left out."""
MOST = 2_000_000
"""Steps of a run."""


def develop(a, w, q, e, v, slide, side, p):
    """Coefficients a of e(t), from e, v, and the signs of v and e; w of v, q of e²."""
    m, k, k3, c1, b2 = p[M], p[K], p[CUBIC], side * p[AMPLITUDE], slide * p[QUADRATIC]
    damping, dry = p[C] + p[VISCOUS], slide * p[FRICTION]
    a[0], w[0] = e, v
    for n in range(ORDER - 1):
        a[n + 1] = w[n] / (n + 1)
        force = -k * a[n] - damping * w[n]
        if n == 0:
            force -= dry
        if k3 != 0.0:
            square = 0.0
            for i in range(n + 1):
                square += a[i] * a[n - i]
            q[n] = square
            cube = 0.0
            for i in range(n + 1):
                cube += q[i] * a[n - i]
            force -= k3 * cube
        if b2 != 0.0 or c1 != 0.0:
            for i in range(n + 1):
                force -= (b2 * w[i] + c1 * a[i]) * w[n - i]
        w[n + 1] = force / (m * (n + 1))
    a[ORDER] = w[ORDER - 1] / ORDER


def value(a, order, t):
    """Value of a polynomial of `order` at t."""
    found = a[order]
    for n in range(order - 1, -1, -1):
        found = found * t + a[n]
    return found


def crossing(a, order, sign, length):
    """First time in (0, length] at which sign·a(t) falls through zero, else 2·length; at 0 it is zero or above."""
    low, high = 0.0, 0.0
    for part in range(1, 5):
        high = length * part / 4
        if sign * value(a, order, high) < 0.0:
            break
        low = high
    else:
        return 2.0 * length
    there = 0.5 * (low + high)
    for _ in range(200):
        here = sign * value(a, order, there)
        if here >= 0.0:
            low = there
        else:
            high = there
        slope = a[order] * order
        for n in range(order - 1, 0, -1):
            slope = slope * there + n * a[n]
        step = there - here / (sign * slope) if slope != 0.0 else low
        step = step if low < step < high else 0.5 * (low + high)
        if abs(step - there) <= 4e-16 * length or high - low <= 4e-16 * length:
            break
        there = step
    return there


def stride(a, length):
    """Length of a step whose last coefficients are next to nothing."""
    size = max(abs(a[0]), 1e-300)
    for n in (ORDER, ORDER - 1):
        if a[n] != 0.0:
            # The speed in a time of the step itself counts as motion, where it begins at e = 0.
            first = max(size, abs(a[1]) * length)
            for _ in range(2):
                found = (SMALL * first / abs(a[n])) ** (1.0 / n)
                first = max(size, abs(a[1]) * found)
            length = min(length, found)
    return length


def departs(e, p):
    """Sense in which a module at rest begins to slide; 0 where it sticks."""
    net = -p[K] * e - p[CUBIC] * e**3
    if p[FRICTION] > 0.0 and abs(net) <= p[STATIC_RATIO] * p[FRICTION]:
        return 0.0
    return 1.0 if net >= 0.0 else -1.0


def put(t, until, last, e, a, w, order, shifts, firsts, grids, outs, p):
    """Write the samples of a step from t to `until`; the last ones too where it ends the run."""
    for channel in range(3):
        i, grid, out = firsts[channel], grids[channel], outs[channel]
        while i < grid.shape[0]:
            stamp = grid[i] - shifts[channel]
            if stamp > until or (stamp == until and not last):
                break
            x, v = e, 0.0
            if order > 0:
                x, v = value(a, order, stamp - t), value(w, order - 1, stamp - t)
            if channel == 0:
                out[i] = x + p[TAUT]
            elif channel == 1:
                out[i] = v
            else:
                out[i] = p[K] * x + p[CUBIC] * x**3 + (p[C] + p[AMPLITUDE] * abs(x)) * v
            i += 1
        firsts[channel] = i


def follow(p, start, grids, shifts, outs):
    """Follow one run; gives its status and the last time."""
    a, w, q = np.zeros(ORDER + 1), np.zeros(ORDER), np.zeros(ORDER)
    t, release, end = start[2], max(start[3], start[2]), start[4]
    e, v = start[0] + p[START_X] - p[TAUT], start[1] + p[START_V]
    if release > t:
        v = 0.0
    firsts = np.zeros(3, np.int64)
    for channel in range(3):  # before the start a channel shows the start state
        grid, out, i = grids[channel], outs[channel], 0
        while i < grid.shape[0] and grid[i] - shifts[channel] < t:
            lead = e + v * (grid[i] - shifts[channel] - t)
            out[i] = lead + p[TAUT] if channel == 0 else v
            if channel == 2:
                out[i] = p[K] * e + p[CUBIC] * e**3 + (p[C] + p[AMPLITUDE] * abs(e)) * v
            i += 1
        firsts[channel] = i
    put(t, release, release >= end, e, a, w, 0, shifts, firsts, grids, outs, p)
    t = release
    slide = departs(e, p) if v == 0.0 else (1.0 if v > 0.0 else -1.0)
    turns = p[FRICTION] != 0.0 or p[QUADRATIC] != 0.0
    passes = p[AMPLITUDE] != 0.0
    side = 1.0 if e > 0.0 or (e == 0.0 and slide > 0.0) else -1.0
    for _ in range(MOST):
        if t >= end or slide == 0.0:
            put(t, end, True, e, a, w, 0, shifts, firsts, grids, outs, p)
            return OK, end
        develop(a, w, q, e, v, slide, side, p)
        if not (abs(e) < 1e100 and abs(v) < 1e100 and abs(a[ORDER]) < 1e300):
            return NOT_FINITE, t
        length = stride(a, end - t)
        turned = crossing(w, ORDER - 1, slide, length) if turns else 2.0 * length
        passed = crossing(a, ORDER, side, length) if passes else 2.0 * length
        taken = min(length, turned, passed)
        last = taken == length and t + taken >= end
        put(t, end if last else t + taken, last, e, a, w, ORDER, shifts, firsts, grids, outs, p)
        e, v = value(a, ORDER, taken), value(w, ORDER - 1, taken)
        t += taken
        if last and abs(e) < 1e100:
            return OK, end
        if taken == turned:
            v = 0.0
            slide = departs(e, p)
        if taken == passed:
            e = 0.0
            side = -side
    return TOO_MANY_STEPS, t


def march_many(many, start, grids, outs, states):
    """Follow one run for each row of parameters in `many`, as `kernel.march_many` does; no events are recorded."""
    shifts = np.zeros(3)
    for row in range(many.shape[0]):
        p, out = many[row], (outs[0][row], outs[1][row], outs[2][row])
        shifts[0], shifts[1], shifts[2] = p[CLOCK_X], p[CLOCK_V], p[CLOCK_T]
        status, t = follow(p, start, grids, shifts, out)
        states[row, 0], states[row, 1], states[row, 2] = status, 0, t
        if status != OK:
            for channel in range(3):
                for i in range(grids[channel].shape[0]):
                    if grids[channel][i] - shifts[channel] >= t:
                        out[channel][i] = np.nan
