"""Derivatives of a run whose legs are known: the entry of the compiled program."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901

from __future__ import annotations

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    TAUT, SLIP, CLOCK_X, CLOCK_V, CLOCK_T, X, V, NOTHING, SIZE, N, TOGETHER, SLIDE, SLIPPED, REGIME, WATCHED, FORCE,
    BLOCK, KEPT, SINCE, SPAN, PUSH, GROWTH, ENDING, PIECE, PART, STATE, RULES,
)  # fmt: skip
from metrology.rig.kernel.equation import motion
from metrology.rig.kernel.exponential import fastest, reach
from metrology.rig.kernel.march import regime_code
from metrology.rig.kernel.regimes import is_linear
from metrology.rig.kernel.samples import NODES
from metrology.rig.tangent.collocation import curved_trace, is_faint
from metrology.rig.tangent.differences import STAMPS, add_steps, add_thrust, extent, partials, plan_steps
from metrology.rig.tangent.events import begin_all, shift_of
from metrology.rig.tangent.exponential import differentiate, drift
from metrology.rig.tangent.samples import linear_samples

SMALL = 1e-6
"""Step of a state over its largest value."""


def lead_in_all(Z, by_T, which, v0, start, grids, shifts, firsts, outs, place):
    """Write the derivatives at the samples before the start, which show the start state."""
    for c in range(3):
        grid, i = grids[c], 0
        while i < grid.shape[0] and grid[i] - shifts[c] < start[2]:
            lead = grid[i] - shifts[c] - start[2]
            for j in range(which.shape[0]):
                if which[j] == STAMPS:
                    outs[c][place[j], i] = -v0 if c == 0 else 0.0
                elif c == 0:
                    outs[c][place[j], i] = Z[X, j] + Z[V, j] * lead + (1.0 if which[j] == TAUT else 0.0)
                else:
                    outs[c][place[j], i] = Z[V, j] if c == 1 else by_T[j]
            i += 1
        firsts[c] = i


def trace(legs, p, which, small, low, kind, at, pair, rule, start, edges, forces, slopes, added, pushes, grids, spans,
          spacings, outs, place):  # fmt: skip
    """Write the derivatives of a run whose legs `kernel.march_many` has left.

    `which` (P,): positions in `p`, `STAMPS` for a shift of the stamps, less than that for the columns of `pushes`
    (edges, columns), small forces on the module from each edge of `added` on; `small`, `low` (P,): first steps of the
    differences and the least values that the equation allows; `rule`: nodes, integrals and weights of the collocation;
    `outs`: three channels' derivatives (rows, samples), those by parameter j in row `place[j]`. The rest as for
    `kernel.march_many`.
    """
    n, many = kind[N], which.shape[0]
    size = n + 3
    largest = extent(legs, p, at, n)
    step, typical = np.zeros(SIZE), np.zeros(SIZE)
    for i in range(SIZE):
        step[i] = SMALL * largest[i] if largest[i] > 0.0 else SMALL
        typical[i] = largest[i]
    typical[NOTHING] = 0.0
    plan, shift = np.zeros((many, 5)), np.zeros(many)
    y, after, r, follows = np.zeros(SIZE), np.zeros(SIZE), np.zeros(REGIME, np.int64), np.zeros(REGIME, np.int64)
    d0, d1, d2 = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE)
    g0, g1, g2 = np.zeros(WATCHED), np.zeros(WATCHED), np.zeros(WATCHED)
    J, by_F, by_p = np.zeros((1, n + 1, n)), np.zeros((1, n)), np.zeros((1, n + 1, many))
    Y, Z = np.zeros(size), np.zeros((size, many))
    room = (np.zeros(size), np.zeros(size), np.zeros((size, many)), np.zeros((size, many)),
            np.zeros((size, size)), np.zeros((size, size)))  # fmt: skip
    held = NODES + BLOCK
    even = (np.zeros(size), np.zeros((size, many)),
            (np.zeros((many, held)), np.zeros((many, held)), np.zeros((many, held))), np.arange(many),
            np.zeros((NODES, 1)))  # fmt: skip
    A1, A2, rows1, rows2 = np.zeros((size, size)), np.zeros((size, size)), np.zeros((3, size)), np.zeros((3, size))
    A, by_A = np.zeros((KEPT, size, size)), np.zeros((KEPT, many, size, size))
    rows, by_rows, W = np.zeros((KEPT, 3, size)), np.zeros((KEPT, many, 3, size)), np.zeros((WATCHED, size))
    tables, by_tables = np.zeros((KEPT, 3, size, BLOCK)), np.zeros((KEPT, many, 3, size, BLOCK))
    leap, by_leap = np.zeros((KEPT, size, size)), np.zeros((KEPT, many, size, size))
    E, L = np.zeros((size, size)), np.zeros((many, size, size))
    active, reached = np.zeros((KEPT, many), np.bool_), np.zeros(KEPT)
    known, kept, fresh = np.full(KEPT, -1), np.zeros((KEPT, 1)), 0
    shifts, firsts = np.zeros(3), np.zeros(3, np.int64)
    shifts[0], shifts[1], shifts[2] = p[CLOCK_X], p[CLOCK_V], p[CLOCK_T]
    together = kind[TOGETHER] == 1 and shifts[0] == shifts[1] and shifts[1] == shifts[2]
    leg, begun = 0, 0.0
    while not np.isnan(legs[leg, SINCE]):
        t, length, ending = legs[leg, SINCE], legs[leg, SPAN], int(legs[leg, ENDING])
        F, slope = legs[leg, PUSH], legs[leg, GROWTH]
        for i in range(SIZE):
            y[i] = legs[leg, STATE + i]
        for i in range(REGIME):
            r[i] = int(legs[leg, RULES + i])
        plan_steps(typical, F, r, p, kind, at, which, small, low, plan, d0, d1)
        piece, part = int(legs[leg, PIECE]), int(legs[leg, PART])
        if leg == 0:
            begin_all(Z, F, r, follows, p, kind, at, start, which, plan, d0, d1, d2)
            add_steps(Z, -1, part, which, pushes, p, at)
        add_thrust(Z, t, piece, part, which, plan, edges, forces, slopes, added, pushes, p, n, slope)
        motion(y, F, r, p, kind, at, d0)
        for j in range(many):
            if which[j] == STAMPS:
                for i in range(n):
                    Z[i, j] = -d0[i]
        if r[SLIDE] == 0:  # held, by hand or by friction: no velocity, whatever the parameters
            for j in range(many):
                Z[V, j] = 0.0
        if leg == 0:
            partials(0, y, F, r, p, kind, at, which, plan, step, J, by_F, by_p, d0, d1, d2)
            for j in range(many):
                for s in range(n):
                    by_p[0, n, j] += J[0, n, s] * Z[s, j]
            lead_in_all(Z, by_p[0, n], which, y[V], start, grids, shifts, firsts, outs, place)
        for i in range(n):
            Y[i] = y[i]
        Y[n], Y[n + 1], Y[n + 2] = F, slope, 1.0
        last = ending < 0
        if is_linear(r, p, kind) and not is_faint(r, p, which):
            code, slot = regime_code(r), -1
            for q in range(KEPT):
                if known[q] == code:
                    slot = q
            if slot < 0:
                slot, fresh = fresh, (fresh + 1) % KEPT
                known[slot] = code
                kept[slot, 0] = 0.0
                differentiate(
                    r, p, kind, at, which, plan, A[slot], W, rows[slot], by_A[slot], by_rows[slot], active[slot],
                    A1, rows1, A2, rows2,
                )  # fmt: skip
                reached[slot] = reach(A[slot], n, fastest(r, p, kind))
            for c in range(1 if together else 3):
                firsts[c] = linear_samples(
                    A[slot], by_A[slot], rows[slot], by_rows[slot], active[slot], reached[slot], Y, Z, t, t + length,
                    last, grids[c], spans[c], spacings[c], shifts[c], firsts[c], outs, place, c,
                    3 if together else c + 1,
                    tables[slot], by_tables[slot], leap[slot], by_leap[slot], E, L, kept[slot], room, even,
                )  # fmt: skip
            if together:
                firsts[1], firsts[2] = firsts[0], firsts[0]
            if not last:
                drift(A[slot], by_A[slot], active[slot], reached[slot], Y, Z, length, E, L, room)
            begun = 0.0
        elif length > 0.0:
            begun = curved_trace(
                Y, Z, t, length, last, r, p, kind, at, pair, largest, step, which, plan, rule, begun, grids, shifts,
                firsts, outs, place, together,
            )  # fmt: skip
        if last:
            break
        for i in range(n):
            y[i] = Y[i]
        F = Y[n]
        leg += 1
        for i in range(SIZE):
            after[i] = legs[leg, STATE + i]
        for i in range(REGIME):
            follows[i] = int(legs[leg, RULES + i])
        motion(y, F, r, p, kind, at, d0)
        motion(after, legs[leg, PUSH], follows, p, kind, at, d1)
        if length > 1e-12 or ending >= WATCHED:  # else it follows at once, at the time of the event before
            shift_of(ending, y, F, slope, r, p, kind, at, which, plan, step, Z, d0, shift, g0, g1, g2)
        if ending != FORCE:
            begun = 0.0
        for j in range(many):
            for i in range(n):
                Z[i, j] += (d0[i] - d1[i]) * shift[j]
            if which[j] == SLIP and follows[SLIPPED] != r[SLIPPED]:
                Z[X, j] -= 1.0
        add_steps(Z, part, int(legs[leg, PART]), which, pushes, p, at)
