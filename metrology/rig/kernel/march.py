"""A run from event to event: the entry of the compiled program."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    LENGTH, SAG, GAIN, LAG, DELAY, FADING, CLOCK_X, CLOCK_V, CLOCK_T, START_X, START_V, X, V, NOTHING, SIZE, THRUST,
    TIME, WEIGHS, N, TOGETHER, CONTACT, SLIDE, CAPPED, HELD, REGIME, BELOW, WATCHED, RELEASE, FORCE, START, ADDED, OK,
    TOO_MANY_STEPS, TOO_MANY_EVENTS, CHATTER, NOT_FINITE, LINE_TOO_SHORT, MAX_STEPS, BLOCK, KEPT, SINCE, SPAN, PUSH,
    GROWTH, ENDING, PIECE, PART, STATE, RULES,
)  # fmt: skip
from metrology.rig.kernel.equation import tension
from metrology.rig.kernel.exponential import assemble, fastest, reach
from metrology.rig.kernel.regimes import begin, grip, is_linear, switch
from metrology.rig.kernel.samples import linear_leg
from metrology.rig.kernel.steps import EXHAUSTED, curved_leg


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
