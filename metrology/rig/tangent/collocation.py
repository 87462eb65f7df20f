"""Derivatives within a nonlinear regime, by collocation along the steps of the motion."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    TAUT, SLIP, SAG, LAG, X, V, SIZE, THRUST, N, CONTACT, SLIPPED, BELOW, BLOCK, FIRST,
)  # fmt: skip
from metrology.rig.kernel.equation import motion
from metrology.rig.kernel.exponential import fastest
from metrology.rig.kernel.samples import lagrange
from metrology.rig.kernel.steps import first_size, growth, make_dense, misfit, read_dense, take_step
from metrology.rig.tangent.differences import partials

GRADED = 1e-13
"""Share of a slack leg left out at its ends, where a faint line's pull goes as 1/√(s − L): its root is the error."""


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
