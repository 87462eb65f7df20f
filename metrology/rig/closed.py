"""The base model in closed form: a line that is slack or taut, a constant thrust between edges, nothing else.

The equation of motion stands in `kernel`; this is its solution where only two linear regimes are left (`docs/model.md`,
"Closed form of the base model"). Plain Python that `engines` runs with vectorised samples or compiled, in seconds, so
that a base model never waits for the kernel that carries every effect.
"""

# Types are inferred by the compiler; long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901

from __future__ import annotations

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the kernel's own order
    M, K, C, TAUT, MASS_FACTOR, LENGTH_SHIFT, GAIN, DELAY, CLOCK_X, CLOCK_V, CLOCK_T, START_X, START_V,
    ATTACHMENT, TOGETHER, BOTH_WAYS, NO_LINE, BELOW, STRETCHED, LIFTED,
    W_EXCESS, W_PULL, RELEASE, FORCE, START, OK, TOO_MANY_EVENTS, CHATTER, NOT_FINITE,
)  # fmt: skip
from metrology.rig.taut_and_free import end_of_contact, moved, propagate

BLOCK = 128
# A leg, the motion between two events: taut (1) or free (0), start beyond taut, force if taut and acceleration if free,
# tension if free, and from when to when.
PULLS, LEG_X, LEG_V, DRIVE, LEG_T, SINCE, UNTIL, LEG = range(8)


# ---- samples --------------------------------------------------------------------------------------------------------
def before(grid, first, stamp, last):
    """Index of the first sample after `stamp`, from `first` on; of the first one at it, too, unless `last`."""
    low, high = first, grid.shape[0]
    while low < high:
        middle = (low + high) // 2
        if grid[middle] < stamp or (last and grid[middle] == stamp):
            low = middle + 1
        else:
            high = middle
    return low


def tabulate(table, dt, decay, square):
    """Fill `table` (4, BLOCK) with `propagate` at multiples of dt: twice as many at a time, P(s + t) = P(s)·P(t)."""
    table[0, 0], table[1, 0], table[2, 0], table[3, 0] = 1.0, 0.0, 0.0, 1.0
    width = 1
    while width < BLOCK:
        a, b, da, db = propagate(decay, square, dt * width)
        for i in range(width):
            table[0, width + i] = a * table[0, i] + b * table[2, i]
            table[1, width + i] = a * table[1, i] + b * table[3, i]
            table[2, width + i] = da * table[0, i] + db * table[2, i]
            table[3, width + i] = da * table[1, i] + db * table[3, i]
        width *= 2


def put(leg, m, k, c, taut, grid, span, spacing, shift, first, stop, outs, low, high, table, known):
    """Write the samples `first` to `stop` − 1 of the channels `low` to `high` − 1, all of them within one leg.

    Evenly spaced samples of a taut line go a block at a time from one state; `known[0]` is the spacing of `table`.
    """
    x, v, drive, tension, t = leg[LEG_X], leg[LEG_V], leg[DRIVE], leg[LEG_T], leg[SINCE]
    decay, square, i = 0.5 * c / m, k / m, first
    while i < stop:
        end, dt, span_t = i + 1, 0.0, grid[i] - shift - t
        if span[i] > i:
            end, dt = min(stop, span[i] + 1), spacing[i]
        if leg[PULLS] == 0.0:
            y, w = taut + x + (v + 0.5 * drive * span_t) * span_t, v + drive * span_t
            for channel in range(low, high):
                out = outs[channel][i:end]
                if channel == 0:
                    for j in range(out.shape[0]):
                        out[j] = y + (w + 0.5 * drive * (dt * j)) * (dt * j)
                elif channel == 1:
                    for j in range(out.shape[0]):
                        out[j] = w + drive * (dt * j)
                else:
                    for j in range(out.shape[0]):
                        out[j] = tension
            i = end
            continue
        a, b, da, db = propagate(decay, square, span_t)
        u = x - drive / k
        u, w = a * u + b * v, da * u + db * v
        if end <= i + 4 and known[0] != dt:
            end = i + 1
        elif known[0] != dt:
            known[0] = dt
            tabulate(table, dt, decay, square)
        if end > i + BLOCK:
            a, b, da, db = propagate(decay, square, dt * BLOCK)
        offset = taut + drive / k
        while i < end:
            part = min(end, i + BLOCK)
            q, dq = k * u + c * w, k * w - c * (c * w + k * u) / m
            for channel in range(low, high):
                out = outs[channel][i:part]
                if channel == 0:
                    for j in range(out.shape[0]):
                        out[j] = offset + table[0, j] * u + table[1, j] * w
                elif channel == 1:
                    for j in range(out.shape[0]):
                        out[j] = table[2, j] * u + table[3, j] * w
                else:
                    for j in range(out.shape[0]):
                        out[j] = drive + table[0, j] * q + table[1, j] * dq
            u, w = a * u + b * w, da * u + db * w
            i = part


def write(legs, closed, m, k, c, taut, grids, spans, spacings, shifts, together, outs, table):
    """Write all samples of the legs of a run, at their very end, too, where the run is `closed`."""
    known = np.zeros(1)
    table[0, 0], table[1, 0], table[2, 0], table[3, 0] = 1.0, 0.0, 0.0, 1.0
    for channel in range(3):
        if channel > 0 and together:
            break
        low, high = (0, 3) if together else (channel, channel + 1)
        grid, shift, first = grids[channel], shifts[channel], 0
        for row in range(legs.shape[0]):
            after = before(grid, first, legs[row, UNTIL] + shift, closed and row == legs.shape[0] - 1)
            if after > first:
                put(
                    legs[row], m, k, c, taut, grid, spans[channel], spacings[channel], shift, first, after, outs,
                    low, high, table, known,
                )  # fmt: skip
            first = after


# ---- a run ----------------------------------------------------------------------------------------------------------
def touch(attachment, x, v, k, c):
    """Contact of the line at the start."""
    if attachment == BOTH_WAYS:
        return STRETCHED
    if attachment == NO_LINE or x < 0.0 or (x == 0.0 and v <= 0.0):
        return BELOW
    return LIFTED if k * x + c * v < 0.0 else STRETCHED


def note(code, contact, held):
    """One number for what happened, as `kernel.march.note` has it."""
    return code * 100 + contact * 10 + (1 if held else 2)


def keep(legs, row, pulls, x, v, drive, tension, since, until):
    """Enter a leg into the table."""
    legs[row, PULLS], legs[row, LEG_X], legs[row, LEG_V], legs[row, DRIVE] = pulls, x, v, drive
    legs[row, LEG_T], legs[row, SINCE], legs[row, UNTIL] = tension, since, until


def march(p, kind, start, edges, forces, legs, times, codes):
    """Follow one run from event to event; gives status, events, legs, last time (see `kernel.march.march_many`)."""
    attachment = kind[ATTACHMENT]
    m, k, c, taut = float(p[M] * p[MASS_FACTOR]), float(p[K]), float(p[C]), float(p[TAUT] + p[LENGTH_SHIFT])
    t, release, end, delay = float(start[2]), float(start[3]), float(start[4]), float(p[DELAY])
    piece, force = -1, 0.0
    while piece + 1 < edges.shape[0] and edges[piece + 1] + delay <= t:
        piece += 1
        force = float(p[GAIN] * forces[piece])
    held = release > t
    x, v = float(start[0] + p[START_X]) - taut, 0.0 if held else float(start[1] + p[START_V])
    contact = touch(attachment, x, v, k, c)
    tension = k * x + c * v if contact == STRETCHED else 0.0
    keep(legs, 0, 0.0, x, v, 0.0, tension, t, t)  # before the start a channel shows the start state
    count = 1
    times[0], codes[0] = t, note(START, contact, held)
    events, still = 1, 0
    while True:
        stop, edge = end, 0
        if piece + 1 < edges.shape[0] and edges[piece + 1] + delay < stop:
            stop, edge = max(float(edges[piece + 1]) + delay, t), FORCE
        if held and release <= stop:
            stop, edge = release, RELEASE
        length, follows, change = stop - t, contact, False
        drive, rest = force, contact
        if held:  # as if the thrust balanced the line
            drive = k * x if contact == STRETCHED else 0.0
        else:
            ends, follows = end_of_contact(contact, attachment, x, v, force, m, k, c, length)
            change = ends < length or (ends == length and contact != STRETCHED)
            length = ends if change else length
        until = t + length if change else stop
        if contact == STRETCHED:
            keep(legs, count, 1.0, x, v, drive, 0.0, t, until)
        else:
            keep(legs, count, 0.0, x, v, drive / m, 0.0, t, until)
        count += 1
        if not held:
            x, v = moved(contact, x, v, force, m, k, c, length)
        if not (abs(x) < 1e100 and abs(v) < 1e100):
            return NOT_FINITE, events, count, t
        if not change and edge == 0:
            return OK, events, count, end
        still = still + 1 if length <= 1e-15 * max(1.0, abs(t)) else 0
        if still > 60:
            return CHATTER, events, count, t
        t = until
        if change:
            # What defines the event holds to the last digit, so that none is met twice.
            code = W_EXCESS if BELOW in (rest, follows) else W_PULL
            x = 0.0 if code == W_EXCESS else -c * v / k
            contact = follows
        else:
            code = edge
            if edge == RELEASE:
                held = False
            else:
                piece += 1
                force = float(p[GAIN] * forces[piece])
        if events >= times.shape[0]:
            return TOO_MANY_EVENTS, events, count, t
        times[events], codes[events] = t, note(code, contact, held)
        events += 1


def march_many(many, kind, start, edges, forces, grids, spans, spacings, outs, times, codes, states, legs):
    """Follow one run for each row of parameters in `many`, as `kernel.march.march_many` does."""
    table = np.empty((4, BLOCK))
    for row in range(many.shape[0]):
        p = many[row]
        status, events, count, t = march(p, kind, start, edges, forces, legs, times, codes)
        shifts = (p[CLOCK_X], p[CLOCK_V], p[CLOCK_T])
        together = kind[TOGETHER] == 1 and shifts[0] == shifts[1] and shifts[1] == shifts[2]
        write(
            legs[:count], status == OK, p[M] * p[MASS_FACTOR], p[K], p[C], p[TAUT] + p[LENGTH_SHIFT], grids, spans,
            spacings, shifts, together, (outs[0][row], outs[1][row], outs[2][row]), table,
        )  # fmt: skip
        states[row, 0], states[row, 1], states[row, 2], states[row, 3] = status, events, t, 0
        if status != OK:
            for channel in range(3):
                for i in range(grids[channel].shape[0]):
                    if grids[channel][i] >= t:
                        outs[channel][row, i] = np.nan
