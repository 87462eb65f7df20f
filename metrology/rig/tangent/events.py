"""Derivatives where a run begins, and of the times of events."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"

from __future__ import annotations

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    DELAY, START_X, START_V, N, HELD, WATCHED, FORCE,
)  # fmt: skip
from metrology.rig.kernel.regimes import begin, watch


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
