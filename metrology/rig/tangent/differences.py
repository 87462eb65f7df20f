"""Central differences of the equation of motion within a regime, where it is smooth, and steps of the thrust."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"

from __future__ import annotations

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    M, K, TAUT, LENGTH, SLIP, STATIC_RATIO, SAG, GAIN, LAG, CELL_LAG, DELAY, FADING, START_X, START_V, X, V, SIZE,
    FRAME_U, FRAME_V, YAW_U, YAW_V, APPENDAGE_U, APPENDAGE_V, RELAXED, RELAXED_B, LOOP, THRUST, SHOWN, N, CONTACT,
    BELOW, STRETCHED, SINCE, STATE,
)  # fmt: skip
from metrology.rig.kernel.equation import excess, motion, relaxed, stretch, tension
from metrology.rig.kernel.march import thrust_at

STAMPS = -1
"""In place of a parameter: a shift of all stamps, which is what a clock does."""
CHANGE = 1e-4
"""Share of the forces that a step of a parameter changes: its square is what a central difference neglects."""
PLAIN = 1e3
"""Largest step of a size from its null, over the least: a size of use, where a compliance is small beside 1/k."""
FAINT = 1e-22
"""Weight per length, N/m, of a line that stretches nothing and whose slack pull is in proportion to it."""


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
    largest[at[SHOWN]] = max(largest[at[SHOWN]], p[K] * largest[X])
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
    """Derivatives of the equation of motion, and of what the cell shows in their last row."""
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
            by_p[q, n, j] = T1 if p[CELL_LAG] <= 0.0 else 0.0
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
    motion(y, F, r, p, kind, at, dy)
    pulled = tension(y, r, p, kind, at)
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
