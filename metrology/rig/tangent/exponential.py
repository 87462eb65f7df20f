"""Derivatives of a linear regime: the exponential of its matrix, and that exponential's derivative."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    N, BLOCK,
)  # fmt: skip
from metrology.rig.kernel.exponential import assemble, copy


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
