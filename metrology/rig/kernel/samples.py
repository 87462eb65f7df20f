"""Readings within a linear regime, and the leg that is made of its steps, its events and its readings."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

import math

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    X, V, BLOCK,
)  # fmt: skip
from metrology.rig.kernel.exponential import advance, copy, grow, square
from metrology.rig.kernel.zeros import linear_event

# fmt: off
# Between uneven stamps: spacing of even nodes, times the fastest rate; nodes of a polynomial, those of them before a
# stamp, and barycentric weights. It leaves (0.5·1.5·…·5.5)²/12!·0.25¹² = 3e-12 of a sine.
FINE, NODES, BEFORE = 0.25, 12, 5
EVEN = np.arange(float(NODES))
BARY = np.array([(-1.0) ** q * math.comb(NODES - 1, q) for q in range(NODES)])
FEW, SPARSE = 16, 400  # stamps, and nodes for each of them, where polynomials and power series take as long
# fmt: on


def fill(
    A, n, reached, rows, Y, t, stop, last, grid, span, spacing, shift, first, outs, channels, tables, leap, kept, work
):  # fmt: skip
    """Write some channels' samples from `t` on, those before `stop` (at it, too, where `last`); give the next index.

    The channels share their stamps. Evenly spaced samples go a block at a time: `tables` hold row·exp(A·dt·b) for each
    b of a block, `leap` is exp(A·dt·BLOCK) − 1; both are made once for a regime and a spacing, which is `kept[0]`.
    """
    size = n + 3
    i = first
    y, rest, begun = np.empty(size), np.empty(BLOCK), Y.copy()
    found, basis = np.empty((3, NODES + BLOCK)), np.empty((NODES, 1))
    low, high = channels
    alone = first
    while i < grid.shape[0]:
        stamp = grid[i] - shift
        if stamp > stop or (stamp == stop and not last):
            break
        advance(A, size, reached, begun, stamp - t, y, work)
        # On from here: from the start of a leg each sample would take a matrix exponential.
        t = stamp
        for j in range(size):
            begun[j] = y[j]
        end, dt = span[i], spacing[i]
        alone = uneven(grid, span, shift, max(alone, i), stop)
        if is_dense(grid, i, alone, reached):
            dt = fine(grid, i, alone, reached)
            if kept[0] != dt:
                kept[0] = dt
                tabulate(A, size, reached, rows, dt, channels, tables, leap)
            advance(A, size, reached, begun, -BEFORE * dt, y, work)
            read_even(y, n, tables, leap, grid, shift, i, alone, dt, outs, channels, found, basis, rest)
            i = alone
            continue
        if end == i:
            for channel in range(low, high):
                total = 0.0
                for j in range(size):
                    total += rows[channel, j] * y[j]
                outs[channel][i] = total
            i += 1
            continue
        if grid[end] - shift >= stop:
            end = min(end, i + int((stop - stamp) / dt) + 1)
            while end > i and (grid[end] - shift > stop or (grid[end] - shift == stop and not last)):
                end -= 1
        if kept[0] != dt:
            kept[0] = dt
            tabulate(A, size, reached, rows, dt, channels, tables, leap)
        blocks = (end - i) // BLOCK + 1
        states = np.empty((blocks, n + 1))
        for j in range(n + 1):
            states[0, j] = y[j]
        for q in range(1, blocks):
            for j in range(n):
                total = states[q - 1, j] + leap[j, n + 1] * y[n + 1] + leap[j, n + 2]
                for l in range(n + 1):
                    total += leap[j, l] * states[q - 1, l]
                states[q, j] = total
            states[q, n] = states[q - 1, n] + leap[n, n + 1] * y[n + 1]
        for channel in range(low, high):
            table, out = tables[channel], outs[channel]
            by_x, by_v = table[X], table[V]
            for q in range(blocks):
                part = out[i + q * BLOCK : min(i + (q + 1) * BLOCK, end + 1)]
                if q == 0 or y[n + 1] != 0.0:
                    for b in range(BLOCK):
                        rest[b] = table[n, b] * states[q, n] + table[n + 1, b] * y[n + 1] + table[n + 2, b]
                if n == 2:
                    x, v = states[q, X], states[q, V]
                    for b in range(part.shape[0]):
                        part[b] = rest[b] + by_x[b] * x + by_v[b] * v
                else:
                    for b in range(part.shape[0]):
                        total = rest[b]
                        for j in range(n):
                            total += table[j, b] * states[q, j]
                        part[b] = total
        i = end + 1
    return i


def uneven(grid, span, shift, alone, stop):
    """Give the end of the stretch, known to last to `alone`, in which no spacing recurs, before `stop`."""
    while alone < grid.shape[0] and span[alone] == alone and grid[alone] - shift < stop:
        alone += 1
    return alone


def is_dense(grid, i, alone, reached):
    """Whether stamps from `i` to before `alone` are read sooner from even nodes than each by itself."""
    return alone - i >= FEW and (grid[alone - 1] - grid[i]) * reached < FINE * SPARSE * (alone - i)


def fine(grid, i, alone, reached):
    """Spacing of even nodes / s; no longer than the stretch, where a free motion has no rate."""
    long = grid[alone - 1] - grid[i]
    return long if long * reached <= FINE else FINE / reached


def lagrange(theta, nodes, bary, basis, at):
    """Fill column `at` of `basis` with the Lagrange polynomials of the nodes at `theta`."""
    total = 0.0
    for q in range(nodes.shape[0]):
        apart = theta - nodes[q]
        if apart == 0.0:
            for l in range(nodes.shape[0]):
                basis[l, at] = 0.0
            basis[q, at] = 1.0
            return
        basis[q, at] = bary[q] / apart
        total += basis[q, at]
    for q in range(nodes.shape[0]):
        basis[q, at] /= total


def window(since, dt, held, basis):
    """Give the first of the `NODES` even nodes around an instant, and their polynomials there; −1 if not yet held."""
    where = since / dt
    node = max(int(where) - BEFORE, 0)
    if node + NODES > held:
        return -1
    lagrange(where - node, EVEN, BARY, basis, 0)
    return node


def read_even(y, n, tables, leap, grid, shift, i, alone, dt, outs, channels, found, basis, rest):
    """Write the samples from `i` to before `alone` by polynomials through even nodes; `y` is `BEFORE`·dt before them.

    The linear flow goes on beyond both ends of its leg, so that each stamp stands in the middle of its nodes.
    """
    low, high = channels
    begun, held = grid[i] - shift - BEFORE * dt, 0
    while i < alone:
        kept = min(held, NODES - 1)
        for channel in range(low, high):
            part, table = found[channel], tables[channel]
            for b in range(kept):
                part[b] = part[held - kept + b]
            for b in range(BLOCK):
                part[kept + b] = table[n + 2, b]
            for j in range(n + 2):
                for b in range(BLOCK):
                    part[kept + b] += table[j, b] * y[j]
        begun += (held - kept) * dt
        held = kept + BLOCK
        for j in range(n):
            total = y[j] + leap[j, n + 1] * y[n + 1] + leap[j, n + 2]
            for l in range(n + 1):
                total += leap[j, l] * y[l]
            rest[j] = total
        for j in range(n):
            y[j] = rest[j]
        y[n] += leap[n, n + 1] * y[n + 1]
        while i < alone:
            node = window(grid[i] - shift - begun, dt, held, basis)
            if node < 0:
                break
            for channel in range(low, high):
                total = 0.0
                for b in range(NODES):
                    total += basis[b, 0] * found[channel, node + b]
                outs[channel][i] = total
            i += 1


def tabulate(A, size, reached, rows, dt, channels, tables, leap):
    """Fill `tables` and `leap` of `fill`."""
    E = grow(A, size, reached, dt)
    for channel in range(channels[0], channels[1]):
        table = tables[channel]
        for j in range(size):
            table[j, 0] = rows[channel, j]
        for b in range(1, BLOCK):
            for j in range(size):
                entry = table[j, b - 1]
                for l in range(size - 2):
                    entry += table[l, b - 1] * E[l, j]
                table[j, b] = entry
    width = 1
    while width < BLOCK:
        square(E, leap)
        copy(leap, E)
        width *= 2


def linear_leg(
    A, W, G, rows, n, reached, omega, Y, t, stop, last, grids, spans, spacings, shifts, firsts, outs, budget, together,
    tables, leaps, kept, work,
):  # fmt: skip
    """Follow a linear regime from `t` to its first event, or to `stop`: samples written, Y moved on."""
    length, which, steps = linear_event(A, W, G, n, reached, omega, Y, stop - t, budget, leaps[3], kept[3:], work)
    ends = stop if which < 0 else t + length
    for channel in range(3):
        if channel > 0 and together:
            firsts[channel] = firsts[0]
            continue
        channels = (0, 3) if together else (channel, channel + 1)
        firsts[channel] = fill(
            A, n, reached, rows, Y, t, ends, last and which < 0,
            grids[channel], spans[channel], spacings[channel], shifts[channel], firsts[channel], outs, channels,
            tables, leaps[channel], kept[channel:], work,
        )  # fmt: skip
    after = np.empty(n + 3)
    advance(A, n + 3, reached, Y, length, after, work)
    for i in range(n + 3):
        Y[i] = after[i]
    return length, which, steps
