"""Linear segments of the rig's motion with NumPy alone: many instants at once in place of a compiled loop."""

# The kernel is plain Python without annotations, for the compiler's sake.
# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrology.rig.kernel.layout import BLOCK
from metrology.rig.kernel.samples import BARY, BEFORE, EVEN, NODES, fine, is_dense
from metrology.rig.kernel.zeros import dip, is_quiet, linear_event
from metrology.rig.run import Array

SCAN = 64
"""Instants that are searched for an event at once."""
ORDER = 22


def linear_leg(
    A: Array, W: Array, G: Array, rows: Array, n: int, reached: float, omega: float, Y: Array, t: float, stop: float,
    last: bool, grids: Any, spans: Any, spacings: Any, shifts: Array, firsts: NDArray[np.int64], outs: Any,
    budget: int, together: bool, tables: Array, leaps: Array, kept: Array, work: Array,
) -> tuple[float, int, int]:  # fmt: skip
    """Follow a linear regime from `t` to its first event, or to `stop`: `kernel.samples.linear_leg`, vectorised."""
    length, which, steps = _event(A, W, G, n, reached, omega, Y, stop - t, leaps[3], kept[3:])
    ends, last = (stop, last) if which < 0 else (t + length, False)
    del together, work  # shared wherever stamps are the same
    known: dict[tuple[float, float, int], Array] = {}
    caches = (tables, leaps, kept)
    for channel in range(3):
        grid, shift, first = grids[channel], shifts[channel], firsts[channel]
        stopped = int(np.searchsorted(grid, ends + shift, "right" if last else "left"))
        recurs = np.flatnonzero(spans[channel][first:stopped] > np.arange(first, stopped)) + first
        while first < stopped:
            end = min(int(spans[channel][first]), stopped - 1)
            stamp = float(grid[first] - shift)
            alone = int(next(iter(recurs[np.searchsorted(recurs, first) :]), stopped))
            if is_dense(grid, first, alone, reached):
                begun = _after(A, reached, Y, stamp - t)
                outs[channel][first:alone] = _read_even(
                    A, reached, begun, rows[channel], grid[first:alone], channel, caches
                )
                end = alone - 1
            elif end == first:
                outs[channel][first] = rows[channel] @ _after(A, reached, Y, stamp - t)
            else:
                _tabulate(A, reached, rows[channel], spacings[channel][first], channel, caches)
                blocks = (end - first) // BLOCK + 1
                key = (stamp, float(spacings[channel][first]), blocks)
                if key not in known:
                    known[key] = _leapfrog(_after(A, reached, Y, stamp - t), leaps[channel], blocks)
                samples = known[key].T @ tables[channel]
                outs[channel][first : end + 1] = samples.reshape(-1)[: end + 1 - first]
            first = end + 1
        firsts[channel] = max(first, firsts[channel])
    Y[:] = _after(A, reached, Y, length)
    return length, which, min(steps, budget)


def _read_even(
    A: Array, reached: float, Y: Array, row: Array, grid: Array, channel: int, caches: tuple[Array, Array, Array]
) -> Array:
    """Samples by polynomials through even nodes (`kernel.samples.read_even`); `Y` is at the first of them."""
    tables, leaps, _ = caches
    dt = fine(grid, 0, len(grid), reached)
    _tabulate(A, reached, row, dt, channel, caches)
    where = (grid - grid[0]) / dt + BEFORE
    blocks = (int(where[-1]) + NODES) // BLOCK + 1
    nodes = (_leapfrog(_after(A, reached, Y, -BEFORE * dt), leaps[channel], blocks).T @ tables[channel]).ravel()
    first = where.astype(np.int64) - BEFORE
    apart = (where - first)[:, np.newaxis] - EVEN
    exact = apart == 0.0
    basis = np.where(exact.any(axis=1, keepdims=True), exact, BARY / np.where(exact, 1.0, apart))
    values = nodes[first[:, np.newaxis] + np.arange(NODES)]
    samples: Array = (basis * values).sum(axis=1) / basis.sum(axis=1)
    return samples


def _tabulate(
    A: Array, reached: float, row: Array, dt: float, channel: int, caches: tuple[Array, Array, Array]
) -> None:
    tables, leaps, kept = caches
    if kept[channel] == dt:
        return
    kept[channel] = dt
    E, done = _grow(A, reached, dt), 1
    table = np.empty((len(row), BLOCK))
    table[:, 0] = row
    while done < BLOCK:
        table[:, done : 2 * done] = table[:, :done] + E.T @ table[:, :done]
        E, done = 2.0 * E + E @ E, 2 * done
    tables[channel], leaps[channel] = table, E


def _leapfrog(Y: Array, leap: Array, blocks: int) -> Array:
    """States (size, blocks), each one leap after the one before."""
    states, done, E = np.empty((len(Y), blocks)), 1, leap
    states[:, 0] = Y
    while done < blocks:
        more = min(done, blocks - done)
        states[:, done : done + more] = states[:, :more] + E @ states[:, :more]
        if done + more < blocks:
            E = 2.0 * E + E @ E
        done += more
    return states


def _grow(A: Array, reached: float, h: float) -> Array:
    """exp(A·h) − 1 (see `kernel.exponential.grow`)."""
    halvings = max(0, int(np.ceil(np.log2(max(reached * h / 0.25, 1.0)))))
    B = A * (h / 2.0**halvings)
    E = np.zeros_like(A)
    for order in range(14, 0, -1):
        E = (B + B @ E) / order
    for _ in range(halvings):
        E = 2.0 * E + E @ E
    return E


def _series(A: Array, Y: Array) -> Array:
    """Coefficients (ORDER, size) of the power series of the state."""
    terms = np.empty((ORDER, len(Y)))
    terms[0] = Y
    for order in range(1, ORDER):
        terms[order] = A @ terms[order - 1] / order
    return terms


def _after(A: Array, reached: float, Y: Array, h: float) -> Array:
    if h == 0.0:
        return Y.copy()
    if reached * h <= 1.0:
        after: Array = h ** np.arange(ORDER) @ _series(A, Y)
        return after
    return Y + _grow(A, reached, h) @ Y


def _event(
    A: Array, W: Array, G: Array, n: int, reached: float, omega: float, Y: Array, length: float, E: Array, kept: Array
) -> tuple[float, int, int]:
    """First event of a linear regime within `length` (see `kernel.zeros.linear_event`)."""
    live = np.flatnonzero((W[:, :-1] != 0).any(axis=1) | (W[:, -1] < 0))
    if live.size == 0 or length <= 0.0 or is_quiet(Y, A, W, n, Y[n + 1]):
        return length, -1, 0
    h = min(1.0 / omega if omega > 0.0 else 0.25 * length, length)
    if kept[0] != h:
        kept[0] = h
        E[:] = _grow(A, reached, h)
    done, here, steps = 0.0, Y, 0
    while done < length:
        count = min(SCAN, int(np.ceil((length - done) / h)))
        states = _leapfrog(here, E, count + 1)
        g, dg = W[live] @ states, G[live] @ states
        edge = (g[:, :-1] <= 0) & (dg[:, :-1] <= 0)
        bend = (dg[:, :-1] < 0) & (dg[:, 1:] > 0)
        for at in np.flatnonzero((edge | bend | (g[:, 1:] < 0)).any(axis=0)).tolist():
            span = min(h, length - done - at * h)
            root, which = _first_root(A, W, G, n, reached, states[:, at], span, live)
            if which >= 0:
                return done + at * h + root, which, steps + at
        done, here, steps = done + count * h, states[:, -1], steps + count
        if is_quiet(here, A, W, n, here[n + 1]):
            break
    return length, -1, steps


def _first_root(
    A: Array, W: Array, G: Array, n: int, reached: float, Y: Array, span: float, live: NDArray[np.int64]
) -> tuple[float, int]:
    """First event within one step of the search: the power series of what is watched, in plain numbers."""
    if reached * span > 2.0:
        scratch = np.empty((11, 40))
        root, which, _ = linear_event(
            A, W, G, n, reached, 0.0, Y, span, 99, np.empty((n + 3, n + 3)), np.zeros(1), scratch
        )
        return root, which
    series = _series(A, Y) @ W[live].T
    first, which = 2.0 * span, -1
    for column, number in enumerate(live.tolist()):
        coefficients = series[::-1, column].tolist()
        (start, rate), (end, end_rate) = (series[0, column], series[1, column]), _horner(coefficients, span)
        if start <= 0.0 and (rate < 0.0 or (rate == 0.0 and end < 0.0)):
            return 0.0, number
        low, high = 0.0, -1.0
        if end < 0.0:
            high = span
            if start <= 0.0:
                low = next((t for t in span * 0.5 ** np.arange(1, 61) if _horner(coefficients, t)[0] > 0.0), 0.0)
        elif start > 0.0:
            place = dip(start, rate, end, end_rate, span)
            high = place if place > 0.0 and _horner(coefficients, place)[0] < 0.0 else -1.0
        high = min(high, first)  # the deepest place may lie beyond the event that is known, the fall before it
        if low < high and _horner(coefficients, high)[0] < 0.0:
            first, which = _root(coefficients, low, high), number
    return first, which


def _horner(coefficients: list[float], t: float) -> tuple[float, float]:
    value, slope = 0.0, 0.0
    for coefficient in coefficients:
        slope = slope * t + value
        value = value * t + coefficient
    return value, slope


def _root(coefficients: list[float], low: float, high: float) -> float:
    """Where the series falls through zero: Newton's steps kept inside a shrinking bracket."""
    t = 0.5 * (low + high)
    for _ in range(100):
        value, slope = _horner(coefficients, t)
        low, high = (t, high) if value > 0.0 else (low, t)
        t_next = t - value / slope if slope < 0.0 else low
        if slope >= 0.0 or not low <= t_next <= high:
            t_next = 0.5 * (low + high)
        if abs(t_next - t) <= 1e-15 * t_next:
            break
        t = t_next
    return t_next
