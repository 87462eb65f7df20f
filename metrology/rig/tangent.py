"""Derivatives of a motion by its parameters, carried along its legs and through its events.

Between two events y′ = f(y, F, p) gives S′ = f_y·S + f_F·F_p + f_p for S = dy/dp (forward sensitivities). At an event,
where g(y, F, p) = 0, the time of the event moves by δt = −(g_y·S + g_F·F_p + g_p)/g′ and S⁺ = S⁻ + (f⁻ − f⁺)·δt + h_p,
h_p the derivative of a jump of y (saltation matrix: Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth
Mechanical Systems, Springer 2004, 7.2). A linear regime is followed by the exponential of its matrix and that
exponential's derivative, a nonlinear one by collocation along the steps of the motion. What is differentiated by the
parameters (f, g and the matrices) is smooth within a regime: there central differences have ten digits.

Compiled together with `kernel`, whose copy of the equation it shares; the motion's legs come from `kernel.march_many`.
"""

# Types are inferred by the compiler; long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

import numpy as np

from metrology.rig.kernel import (  # isort: skip - in the kernel's own order
    M, K, TAUT, LAG, DELAY, SLIP, CLOCK_X, CLOCK_V, CLOCK_T, START_X, START_V, LENGTH, SAG, STATIC_RATIO, GAIN, FADING,
    X, V, SIZE, FIRST,
    BELOW, STRETCHED, CONTACT,
    FRAME_U, FRAME_V, YAW_U, YAW_V, APPENDAGE_U, APPENDAGE_V, RELAXED, RELAXED_B, LOOP, THRUST,
    N, TOGETHER, SLIDE, HELD, SLIPPED, REGIME, WATCHED,
    FORCE, KEPT, BLOCK, NODES, BEFORE, SINCE, SPAN, PUSH, GROWTH, ENDING, PIECE, PART, STATE, RULES,
    assemble, begin, copy, excess, fastest, fine, first_size, growth, is_dense, is_linear, lagrange, make_dense, misfit,
    motion, reach, read_dense, regime_code, relaxed, stretch, take_step, thrust_at, uneven, watch, window,
)  # fmt: skip

STAMPS = -1
"""In place of a parameter: a shift of all stamps, which is what a clock does."""
CHANGE = 1e-4
"""Share of the forces that a step of a parameter changes: its square is what a central difference leaves out."""
PLAIN = 1e3
"""Largest step of a size from its null, over the least: a size of use, where a compliance is small beside 1/k."""
SMALL = 1e-6
"""Step of a state over its largest value."""
FAINT = 1e-22
"""Weight per length, N/m, of a line that stretches nothing and whose slack pull is in proportion to it."""
GRADED = 1e-13
"""Share of a slack leg left out at its ends, where a faint line's pull goes as 1/√(s − L): its root is the error."""


# ---- steps of the differences within a regime -----------------------------------------------------------------------
def extent(legs, p, at, n):
    """Largest value of each state at the ends of legs, and of the stretch that the largest velocity makes."""
    largest, leg = np.zeros(SIZE), 0
    while not np.isnan(legs[leg, SINCE]):
        for i in range(n):
            largest[i] = max(largest[i], abs(legs[leg, STATE + i]))
        leg += 1
    if p[K] > 0.0:
        largest[X] = max(largest[X], largest[V] * (p[M] / p[K]) ** 0.5)
        largest[V] = max(largest[V], largest[X] * (p[K] / p[M]) ** 0.5)
    for i in (at[FRAME_U], at[YAW_U], at[APPENDAGE_U], at[RELAXED], at[RELAXED_B], at[LOOP]):
        largest[i] = max(largest[i], largest[X])
    for i in (at[FRAME_V], at[YAW_V], at[APPENDAGE_V]):
        largest[i] = max(largest[i], largest[V])
    return largest


def is_inert(i):
    """Whether a parameter acts through the start, the thrust and the events alone."""
    return i in (TAUT, START_X, START_V, GAIN, DELAY, FADING, STATIC_RATIO, SLIP)


def plan_steps(typical, F, r, p, kind, at, which, small, low, plan, d0, d1):
    """Fill `plan`, for each parameter the two steps and the weights of value there, there and here."""
    n = kind[N]
    T0 = motion(typical, F, r, p, kind, at, d0)
    force = abs(T0) + p[M] * abs(d0[V])
    for j in range(which.shape[0]):
        i = which[j]
        if i < 0:
            continue
        held, h = p[i], small[j]
        if i == SAG and held == 0.0:  # its pull is put in by `partials`
            for q in range(5):
                plan[j, q] = 0.0
            continue
        p[i] = held + h
        T1 = motion(typical, F, r, p, kind, at, d1)
        p[i] = held
        change = abs(T1 - T0) / force if force > 0.0 else 0.0
        for s in range(1, n):
            size = abs(d0[s]) + abs(d0[V]) + typical[s]
            if size > 0.0:
                change = max(change, abs(d1[s] - d0[s]) / size)
        if change > 0.0:
            h *= min(max(CHANGE / change, 1e-8), 1e8)
        # At its null a force grows with its size in proportion, but the pull on a compliance does not.
        h = min(h, max(3e-4 * abs(held), small[j]) if abs(held) > 1e-100 else PLAIN * small[j])
        forward = held - h < low[j]
        plan[j, 0], plan[j, 1] = h, (2.0 * h if forward else -h)
        plan[j, 2], plan[j, 3] = (2.0 / h, -0.5 / h) if forward else (0.5 / h, -0.5 / h)
        plan[j, 4] = -1.5 / h if forward else 0.0


def partials(q, y, F, r, p, kind, at, which, plan, step, J, by_F, by_p, d0, d1, d2):
    """Derivatives of the equation of motion, and of T in their last row, by state, thrust and parameters; T."""
    n = kind[N]
    T0 = motion(y, F, r, p, kind, at, d0)
    for s in range(n):
        held, h = y[s], step[s]
        y[s] = held + h
        T1 = motion(y, F, r, p, kind, at, d1)
        y[s] = held - h
        T2 = motion(y, F, r, p, kind, at, d2)
        y[s] = held
        scale = 0.5 / h
        for i in range(n):
            J[q, i, s] = (d1[i] - d2[i]) * scale
        J[q, n, s] = (T1 - T2) * scale
    motion(y, F + 1.0, r, p, kind, at, d1)
    for i in range(n):
        by_F[q, i] = d1[i] - d0[i]
    for j in range(which.shape[0]):
        a = which[j]
        if a < 0 or is_inert(a):
            for i in range(n + 1):
                by_p[q, i, j] = 0.0
            continue
        held = p[a]
        if a == SAG and held == 0.0:
            T1, T2 = faint_pull(y, F, r, p, kind, at, d1)
            by_p[q, n, j] = T1
            for i in range(n):  # linear in T
                by_p[q, i, j] = T1 / T2 * (d1[i] - d0[i])
            continue
        p[a] = held + plan[j, 0]
        T1 = motion(y, F, r, p, kind, at, d1)
        p[a] = held + plan[j, 1]
        T2 = motion(y, F, r, p, kind, at, d2)
        p[a] = held
        for i in range(n):
            by_p[q, i, j] = plan[j, 2] * d1[i] + plan[j, 3] * d2[i] + plan[j, 4] * d0[i]
        by_p[q, n, j] = plan[j, 2] * T1 + plan[j, 3] * T2 + plan[j, 4] * T0


def faint_pull(y, F, r, p, kind, at, dy):
    """Pull of a slack line for each unit of weight, where it has none; its pull at 1 N/m, and in `dy` the motion there.

    How its damping begins, over a width that goes as q^⅔, has no derivative at q = 0 and is left out.
    """
    if r[CONTACT] != BELOW or p[LENGTH] <= 0.0:
        motion(y, F, r, p, kind, at, dy)
        return 0.0, 1.0
    held = y[X]
    y[X] -= max(excess(y, at)[0] + 1e-15 * p[LENGTH], 0.0)  # the last digit at the contact is no stretch
    r[CONTACT], p[SAG] = STRETCHED, FAINT
    T = stretch(excess(y, at)[0], relaxed(y, p, at), y[at[LOOP]], r, p)[1] / FAINT
    p[SAG] = 1.0
    pulled = motion(y, F, r, p, kind, at, dy)
    r[CONTACT], p[SAG], y[X] = BELOW, 0.0, held
    return T, pulled


def add_thrust(Z, t, piece, part, which, plan, edges, forces, slopes, added, pushes, p, n, slope):
    """Enter the derivatives of the thrust and of its growth, which a leg begins with."""
    F0, s0 = thrust_at(t, piece, part, edges, forces, slopes, added, p)
    for j in range(which.shape[0]):
        i = which[j]
        if i < STAMPS:
            Z[n, j], Z[n + 1, j] = pushes[part, STAMPS - 1 - i] if part >= 0 else 0.0, 0.0
            continue
        if i < 0:
            Z[n, j], Z[n + 1, j] = -slope, 0.0
            continue
        held = p[i]
        p[i] = held + plan[j, 0]
        F1, s1 = thrust_at(t, piece, part, edges, forces, slopes, added, p)
        p[i] = held + plan[j, 1]
        F2, s2 = thrust_at(t, piece, part, edges, forces, slopes, added, p)
        p[i] = held
        Z[n, j] = plan[j, 2] * F1 + plan[j, 3] * F2 + plan[j, 4] * F0
        Z[n + 1, j] = plan[j, 2] * s1 + plan[j, 3] * s2 + plan[j, 4] * s0


def add_steps(Z, before, part, which, pushes, p, at):
    """Enter the steps of small forces into the state of a lagging thruster, which they do not pass through."""
    if p[LAG] <= 0.0 or pushes.shape[0] == 0:
        return
    for j in range(which.shape[0]):
        if which[j] < STAMPS:
            q = STAMPS - 1 - which[j]
            Z[at[THRUST], j] += (pushes[part, q] if part >= 0 else 0.0) - (pushes[before, q] if before >= 0 else 0.0)


# ---- where a run begins, and its events -----------------------------------------------------------------------------
def begin_all(Z, F, r, rules, p, kind, at, start, which, plan, d0, d1, d2):
    """Derivatives of the start state."""
    n, held_back = kind[N], r[HELD] == 1
    v0 = 0.0 if held_back else start[1] + p[START_V]
    begin(d0, F, rules, p, kind, at, start[0] + p[START_X], v0)
    for j in range(which.shape[0]):
        a = which[j]
        if a < 0:
            continue
        held = p[a]
        for turn in range(2):
            p[a] = held + plan[j, turn]
            v0 = 0.0 if held_back else start[1] + p[START_V]
            begin(d1 if turn == 0 else d2, F, rules, p, kind, at, start[0] + p[START_X], v0)
        p[a] = held
        for i in range(n):
            Z[i, j] = plan[j, 2] * d1[i] + plan[j, 3] * d2[i] + plan[j, 4] * d0[i]


def shift_of(ending, y, F, slope, r, p, kind, at, which, plan, step, Z, before, shift, g0, g1, g2):
    """Fill `shift`: by how much each parameter moves the time of the event that ends a leg."""
    n = kind[N]
    for j in range(which.shape[0]):
        shift[j] = 1.0 if ending == FORCE and which[j] == DELAY else 0.0
    if ending >= WATCHED:
        return
    watch(y, F, r, p, kind, at, g0)
    watch(y, F + 1.0, r, p, kind, at, g1)
    by_F = g1[ending] - g0[ending]
    rate = by_F * slope
    for j in range(which.shape[0]):
        shift[j] = by_F * Z[n, j]
    for s in range(n):
        held = y[s]
        y[s] = held + step[s]
        watch(y, F, r, p, kind, at, g1)
        y[s] = held - step[s]
        watch(y, F, r, p, kind, at, g2)
        y[s] = held
        by_s = 0.5 * (g1[ending] - g2[ending]) / step[s]
        rate += by_s * before[s]
        for j in range(which.shape[0]):
            shift[j] += by_s * Z[s, j]
    for j in range(which.shape[0]):
        a = which[j]
        if a >= 0:
            held = p[a]
            p[a] = held + plan[j, 0]
            watch(y, F, r, p, kind, at, g1)
            p[a] = held + plan[j, 1]
            watch(y, F, r, p, kind, at, g2)
            p[a] = held
            shift[j] += plan[j, 2] * g1[ending] + plan[j, 3] * g2[ending] + plan[j, 4] * g0[ending]
        shift[j] = -shift[j] / rate if rate < 0.0 else 0.0


# ---- linear regimes -------------------------------------------------------------------------------------------------
def differentiate(r, p, kind, at, which, plan, A, W, rows, by_A, by_rows, active, A1, rows1, A2, rows2):
    """Matrices of a linear regime and their derivatives; which parameters these depend on."""
    size = kind[N] + 3
    assemble(r, p, kind, at, A, W, rows)
    for j in range(which.shape[0]):
        active[j] = False
        a = which[j]
        if a < 0:
            continue
        held = p[a]
        p[a] = held + plan[j, 0]
        assemble(r, p, kind, at, A1, W, rows1)
        p[a] = held + plan[j, 1]
        assemble(r, p, kind, at, A2, W, rows2)
        p[a] = held
        for l in range(size):
            for i in range(size):
                by_A[j, i, l] = plan[j, 2] * A1[i, l] + plan[j, 3] * A2[i, l] + plan[j, 4] * A[i, l]
                active[j] = active[j] or by_A[j, i, l] != 0.0
            for i in range(3):
                by_rows[j, i, l] = plan[j, 2] * rows1[i, l] + plan[j, 3] * rows2[i, l] + plan[j, 4] * rows[i, l]
                active[j] = active[j] or by_rows[j, i, l] != 0.0


def times(A, B, C, factor):
    """C += factor·A·B."""
    size = A.shape[0]
    for i in range(size):
        for l in range(size):
            entry = factor * A[i, l]
            if entry != 0.0:
                for j in range(size):
                    C[i, j] += entry * B[l, j]


def flow(A, by_A, active, reached, h, E, L, F, G):
    """Fill E = exp(A·h) − 1 and its derivatives L by each parameter: power series, then squarings of the difference."""
    size, many = A.shape[0], by_A.shape[0]
    halvings = 0
    while reached * h > 0.25 and halvings < 60:
        h *= 0.5
        halvings += 1
    E[:] = 0.0
    L[:] = 0.0
    for order in range(14, 0, -1):
        share = h / order
        for j in range(many):  # L before E, of which it needs the older one
            if active[j]:
                G[:] = 0.0
                times(by_A[j], E, G, share)
                times(A, L[j], G, share)
                for i in range(size):
                    for l in range(size):
                        L[j, i, l] = G[i, l] + share * by_A[j, i, l]
        F[:] = 0.0
        times(A, E, F, share)
        for i in range(size):
            for l in range(size):
                E[i, l] = F[i, l] + share * A[i, l]
    for _ in range(halvings):
        double(E, L, active, F, G)


def double(E, L, active, F, G):
    """Go on to twice the time: E + 1 → (E + 1)², L → 2·L + E·L + L·E."""
    size = E.shape[0]
    for j in range(L.shape[0]):
        if active[j]:
            G[:] = 0.0
            times(E, L[j], G, 1.0)
            times(L[j], E, G, 1.0)
            for i in range(size):
                for l in range(size):
                    L[j, i, l] = 2.0 * L[j, i, l] + G[i, l]
    F[:] = 0.0
    times(E, E, F, 1.0)
    for i in range(size):
        for l in range(size):
            E[i, l] = 2.0 * E[i, l] + F[i, l]


def apply(E, L, active, Y, Z, out, turned):
    """Y and Z after the time of E and L; `out`, `turned` are room."""
    size, many = E.shape[0], Z.shape[1]
    for i in range(size):
        out[i] = Y[i]
        for j in range(many):
            turned[i, j] = Z[i, j]
        for l in range(size):
            entry = E[i, l]
            if entry != 0.0:
                out[i] += entry * Y[l]
                for j in range(many):
                    turned[i, j] += entry * Z[l, j]
    for j in range(many):
        if active[j]:
            for i in range(size):
                total = turned[i, j]
                for l in range(size):
                    total += L[j, i, l] * Y[l]
                turned[i, j] = total
    for i in range(size):
        Y[i] = out[i]
        for j in range(many):
            Z[i, j] = turned[i, j]


def drift(A, by_A, active, reached, Y, Z, h, E, L, room):
    """Move Y and Z on by the time h: by the power series, or by the exponential where that is long, and not back."""
    if h == 0.0:
        return
    term, after, slopes, beyond, F, G = room
    if reached * h > 2.0:
        flow(A, by_A, active, reached, h, E, L, F, G)
        apply(E, L, active, Y, Z, after, beyond)
        return
    size, many = A.shape[0], Z.shape[1]
    for i in range(size):
        term[i] = Y[i]
        for j in range(many):
            slopes[i, j] = Z[i, j]
    for order in range(1, 12 + int(12.0 * reached * abs(h))):
        share = h / order
        for i in range(size - 2):  # F′ and 1 stay
            after[i] = 0.0
            for j in range(many):
                beyond[i, j] = 0.0
            for l in range(size):
                entry = A[i, l] * share
                if entry != 0.0:
                    after[i] += entry * term[l]
                    for j in range(many):
                        beyond[i, j] += entry * slopes[l, j]
        for j in range(many):
            if active[j]:
                for i in range(size - 3):
                    total = 0.0
                    for l in range(size):
                        total += by_A[j, i, l] * term[l]
                    beyond[i, j] += share * total
        for i in range(size):
            term[i] = after[i] if i < size - 2 else 0.0
            Y[i] += term[i]
            for j in range(many):
                slopes[i, j] = beyond[i, j] if i < size - 2 else 0.0
                Z[i, j] += slopes[i, j]


def table_rows(rows, by_rows, active, E, L, table, by_table, leap, by_leap, F, G):
    """Rows of the channels, and their derivatives, times exp(A·dt·b) for each b of a block; the leap over a block."""
    size, many = E.shape[0], by_rows.shape[0]
    for c in range(3):
        for i in range(size):
            table[c, i, 0] = rows[c, i]
        for b in range(1, BLOCK):
            for i in range(size):
                total = table[c, i, b - 1]
                for l in range(size):
                    total += table[c, l, b - 1] * E[l, i]
                table[c, i, b] = total
        for j in range(many):
            if active[j]:
                for i in range(size):
                    by_table[j, c, i, 0] = by_rows[j, c, i]
                for b in range(1, BLOCK):
                    for i in range(size):
                        total = by_table[j, c, i, b - 1]
                        for l in range(size):
                            total += by_table[j, c, l, b - 1] * E[l, i] + table[c, l, b - 1] * L[j, l, i]
                        by_table[j, c, i, b] = total
    copy(E, leap)
    for j in range(many):
        copy(L[j], by_leap[j])
    width = 1
    while width < BLOCK:
        double(leap, by_leap, active, F, G)
        width *= 2


def write_block(Y, Z, table, by_table, active, outs, place, low, high, first, count):
    """Write `count` evenly spaced samples of the derivatives of the channels `low` to `high` − 1, at most a block."""
    size, many = Y.shape[0], Z.shape[1]
    for j in range(many):
        for c in range(low, high):
            part = outs[c][place[j], first : first + count]
            part[:] = 0.0
            for i in range(size):
                entry, row = Z[i, j], table[c, i]
                if entry != 0.0:
                    for b in range(count):
                        part[b] += row[b] * entry
            if active[j]:
                for i in range(size):
                    entry, row = Y[i], by_table[j, c, i]
                    if entry != 0.0:
                        for b in range(count):
                            part[b] += row[b] * entry


def linear_samples(A, by_A, rows, by_rows, active, reached, Y, Z, t, ends, last, grid, span, spacing, shift, first,
                   outs, place, low, high, tables, by_tables, leap, by_leap, E, L, kept, room, even):  # fmt: skip
    """Write the derivatives at the samples of a leg that begins at `t`; give the next index."""
    i, now, alone = first, t, first
    many = Z.shape[1]
    y, z = even[0], even[1]
    put(Y, Z, y, z)
    while i < grid.shape[0]:
        stamp = grid[i] - shift
        if stamp > ends or (stamp == ends and not last):
            break
        drift(A, by_A, active, reached, y, z, stamp - now, E, L, room)
        now = stamp
        end, dt = span[i], spacing[i]
        alone = uneven(grid, span, shift, max(alone, i), ends)
        dense = is_dense(grid, i, alone, reached)
        if dense:
            dt = fine(grid, i, alone, reached)
        elif end == i:
            for c in range(low, high):
                for j in range(many):
                    total = 0.0
                    for l in range(y.shape[0]):
                        total += rows[c, l] * z[l, j] + by_rows[j, c, l] * y[l]
                    outs[c][place[j], i] = total
            i += 1
            continue
        elif grid[end] - shift >= ends:
            end = min(end, i + int((ends - stamp) / dt) + 1)
            while end > i and (grid[end] - shift > ends or (grid[end] - shift == ends and not last)):
                end -= 1
        if kept[0] != dt:
            kept[0] = dt
            flow(A, by_A, active, reached, dt, E, L, room[4], room[5])
            table_rows(rows, by_rows, active, E, L, tables, by_tables, leap, by_leap, room[4], room[5])
        if dense:
            drift(A, by_A, active, reached, y, z, -BEFORE * dt, E, L, room)
            read_even_all(
                tables, by_tables, leap, by_leap, active, grid, shift, i, alone, dt, outs, place, low, high, even, room
            )
            put(Y, Z, y, z)
            i, now = alone, t
            continue
        while True:
            count = min(BLOCK, end + 1 - i)
            write_block(y, z, tables, by_tables, active, outs, place, low, high, i, count)
            i += count
            if i > end:
                break
            apply(leap, by_leap, active, y, z, room[1], room[3])
            now += BLOCK * dt
    return i


def put(Y, Z, y, z):
    """Copy a state and its derivatives."""
    for l in range(Y.shape[0]):
        y[l] = Y[l]
        for j in range(Z.shape[1]):
            z[l, j] = Z[l, j]


def read_even_all(tables, by_tables, leap, by_leap, active, grid, shift, i, alone, dt, outs, place, low, high, even,
                  room):  # fmt: skip
    """Write the samples from `i` to before `alone` by polynomials through even nodes; begins `BEFORE`·dt before them.

    The linear flow goes on beyond both ends of its leg, so that each stamp stands in the middle of its nodes.
    """
    y, z, found, own, basis = even
    begun, held = grid[i] - shift - BEFORE * dt, 0
    while i < alone:
        kept = min(held, NODES - 1)
        for c in range(low, high):
            for j in range(z.shape[1]):
                for b in range(kept):
                    found[c][j, b] = found[c][j, held - kept + b]
        begun += (held - kept) * dt
        held = kept + BLOCK
        write_block(y, z, tables, by_tables, active, found, own, low, high, kept, BLOCK)
        apply(leap, by_leap, active, y, z, room[1], room[3])
        while i < alone:
            node = window(grid[i] - shift - begun, dt, held, basis)
            if node < 0:
                break
            for c in range(low, high):
                for j in range(z.shape[1]):
                    total = 0.0
                    for b in range(NODES):
                        total += basis[b, 0] * found[c][j, node + b]
                    outs[c][place[j], i] = total
            i += 1


# ---- nonlinear regimes ----------------------------------------------------------------------------------------------
def solve(G, B, size, many):
    """Solve G·x = B in place, B (size, many), by elimination with the largest pivot."""
    for q in range(size):
        best = q
        for i in range(q + 1, size):
            if abs(G[i, q]) > abs(G[best, q]):
                best = i
        if best != q:
            for l in range(q, size):
                G[q, l], G[best, l] = G[best, l], G[q, l]
            for l in range(many):
                B[q, l], B[best, l] = B[best, l], B[q, l]
        pivot = 1.0 / G[q, q]
        for i in range(q + 1, size):
            factor = G[i, q] * pivot
            if factor != 0.0:
                for l in range(q + 1, size):
                    G[i, l] -= factor * G[q, l]
                for l in range(many):
                    B[i, l] -= factor * B[q, l]
    for q in range(size - 1, -1, -1):
        for i in range(q + 1, size):
            factor = G[q, i]
            if factor != 0.0:
                for l in range(many):
                    B[q, l] -= factor * B[i, l]
        pivot = 1.0 / G[q, q]
        for l in range(many):
            B[q, l] *= pivot


def collocate(Z, J, by_F, by_p, h, n, nodes, integral, G, B):
    """Fill `B` with the derivatives of the state at the nodes of a step of length h but the first, Z at its start.

    Z_q = Z_0 + h·Σ_l a_ql·(J_l·Z_l + f_F,l·F_p(l) + f_p,l), a_ql the integral of the l-th Lagrange polynomial over the
    nodes up to node q (Hairer & Wanner, Solving Ordinary Differential Equations II, IV.5, Lobatto IIIA).
    """
    count, many = nodes.shape[0], Z.shape[1]
    size = (count - 1) * n
    for q in range(1, count):
        for i in range(n):
            row = (q - 1) * n + i
            for j in range(many):
                B[row, j] = Z[i, j]
            for l in range(count):
                weight = h * integral[q, l]
                if l > 0:
                    for s in range(n):
                        G[row, (l - 1) * n + s] = -weight * J[l, i, s]
                since = nodes[l] * h
                push = weight * by_F[l, i]
                for j in range(many):
                    B[row, j] += weight * by_p[l, i, j] + push * (Z[n, j] + since * Z[n + 1, j])
            weight = h * integral[q, 0]
            for s in range(n):
                entry = weight * J[0, i, s]
                for j in range(many):
                    B[row, j] += entry * Z[s, j]
            G[row, row] += 1.0
    solve(G, B, size, many)


def read_nodes(Z, B, J, by_p, n, count, which, slipped, values):
    """Fill `values` (node, channel, parameter) with the derivatives of what the channels show."""
    many = Z.shape[1]
    for q in range(count):
        for j in range(many):
            total = by_p[q, n, j]
            for s in range(n):
                total += J[q, n, s] * (Z[s, j] if q == 0 else B[(q - 1) * n + s, j])
            values[q, 0, j] = Z[X, j] if q == 0 else B[(q - 1) * n + X, j]
            values[q, 1, j] = Z[V, j] if q == 0 else B[(q - 1) * n + V, j]
            values[q, 2, j] = total
    for j in range(many):
        if which[j] == TAUT or (which[j] == SLIP and slipped == 1):
            for q in range(count):
                values[q, 0, j] += 1.0


def write_step(values, t, h, ends, closed, grids, shifts, firsts, outs, place, together, nodes, bary, basis):
    """Write the derivatives at the samples of a step, those before `ends` (at it, too, where `closed`)."""
    count, many, width = nodes.shape[0], values.shape[2], basis.shape[1]
    for channel in range(1 if together else 3):
        grid, shift, first = grids[channel], shifts[channel], firsts[channel]
        more = True
        while more:
            i, more = first, False
            while i < grid.shape[0]:
                stamp = grid[i] - shift
                if stamp > ends or (stamp == ends and not closed):
                    break
                if i - first == width:
                    more = True
                    break
                lagrange((stamp - t) / h, nodes, bary, basis, i - first)
                i += 1
            for c in range(channel, 3 if together else channel + 1):
                for j in range(many):
                    part = outs[c][place[j], first:i]
                    part[:] = 0.0
                    for q in range(count):
                        entry, row = values[q, c, j], basis[q]
                        for b in range(i - first):
                            part[b] += entry * row[b]
            first = i
        firsts[channel] = first
    if together:
        firsts[1], firsts[2] = firsts[0], firsts[0]


def is_faint(r, p, which):
    """Whether the derivative by the weight of a slack line without any is asked for here."""
    if r[CONTACT] != BELOW or p[SAG] > 0.0:
        return False
    found = False
    for j in range(which.shape[0]):
        found = found or which[j] == SAG
    return found


def curved_trace(Y, Z, t, length, last, r, p, kind, at, pair, largest, step, which, plan, rule, begun,
                 grids, shifts, firsts, outs, place, together):  # fmt: skip
    """Carry the derivatives along a leg of a nonlinear regime: samples written, Y and Z moved on; the next step.

    `begun`: step to begin with where it goes on in the regime of the leg before, else 0.
    """
    n, many = kind[N], which.shape[0]
    nodes, integral, bary = rule
    count = nodes.shape[0]
    stages, dense = np.zeros((16, SIZE)), np.zeros((7, SIZE))
    y, new, probe = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE)
    d0, d1, d2 = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE)
    J, by_F, by_p = np.zeros((count, n + 1, n)), np.zeros((count, n)), np.zeros((count, n + 1, many))
    G, B = np.zeros(((count - 1) * n, (count - 1) * n)), np.zeros(((count - 1) * n, many))
    values, basis = np.zeros((count, 3, many)), np.zeros((count, BLOCK))
    y[:n] = Y[:n]
    F, slope, done, end = Y[n], Y[n + 1], 0.0, count - 1
    omega = fastest(r, p, kind)
    motion(y, F, r, p, kind, at, stages[0])
    h = begun if begun > 0.0 else first_size(y, stages[0], length, omega, largest)
    if p[LAG] > 0.0 and y[at[THRUST]] != F:
        h = min(h, p[LAG])
    limit = min(2.0 / omega, max(length / 4.0, FIRST / omega)) if omega > 0.0 else length / 4.0
    graded = is_faint(r, p, which)
    partials(0, y, F, r, p, kind, at, which, plan, step, J, by_F, by_p, d0, d1, d2)
    while done < length:
        h = min(h, limit)
        if graded and length - done > GRADED * length:
            h = min(h, done + GRADED * length, 0.35 * (length - done))
        wanted = h
        if done + h * 1.0000001 >= length:
            h = length - done
        take_step(y, F, slope, h, r, p, kind, at, pair, stages, new, probe)
        error = misfit(y, new, largest, h, n, at, pair, stages)
        if not error < 1.0 and h > 1e-14 * max(1.0, abs(t)):
            h *= max(0.2, 0.9 * error**-0.125) if error == error and error < 1e300 else 0.1
            continue
        make_dense(y, new, F, slope, h, r, p, kind, at, pair, stages, dense, probe)
        for q in range(1, count):
            read_dense(y, F, slope, h, p, kind, at, dense, nodes[q], probe)
            partials(
                q, probe, F + slope * nodes[q] * h, r, p, kind, at, which, plan, step, J, by_F, by_p, d0, d1, d2
            )  # fmt: skip
        collocate(Z, J, by_F, by_p, h, n, nodes, integral, G, B)
        read_nodes(Z, B, J, by_p, n, count, which, r[SLIPPED], values)
        done_after = done + h
        at_end = done_after >= length
        write_step(
            values, t + done, h, t + length if at_end else t + done_after, at_end and last, grids, shifts, firsts,
            outs, place, together, nodes, bary, basis,
        )  # fmt: skip
        for j in range(many):
            for i in range(n):
                Z[i, j] = B[(count - 2) * n + i, j]
            Z[n, j] += h * Z[n + 1, j]
        for i in range(n):
            y[i] = new[i]
            stages[0, i] = stages[12, i]
        J[0], by_F[0], by_p[0] = J[end], by_F[end], by_p[end]
        F += slope * h
        done = done_after
        h = max(wanted, h * growth(error)) if at_end else h * growth(error)
    Y[:n] = y[:n]
    Y[n] = F
    return h


# ---- a run ----------------------------------------------------------------------------------------------------------
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
    typical[9] = 0.0
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
