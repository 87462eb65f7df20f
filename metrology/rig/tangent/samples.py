"""Derivatives of readings within a linear regime."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    BLOCK,
)  # fmt: skip
from metrology.rig.kernel.samples import BEFORE, NODES, fine, is_dense, uneven, window
from metrology.rig.tangent.exponential import apply, drift, flow, table_rows


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
