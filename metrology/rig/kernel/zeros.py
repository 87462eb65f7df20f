"""The first event of a linear regime: zeros of what is watched, between bounds of it and its rate."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

import math

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    X, V, WATCHED,
)  # fmt: skip
from metrology.rig.kernel.exponential import INVERSE, advance, copy, grow


def dip(a, da, b, db, h):
    """Where in (0, h) the cubic through two values and slopes is least; −1 where it is not inside."""
    if not (da < 0.0 < db):
        return -1.0
    slope = (b - a) / h
    alpha = 3.0 * (da + db - 2.0 * slope)
    beta = 2.0 * (3.0 * slope - 2.0 * da - db)
    if abs(alpha) < 1e-12 * abs(beta):
        return -da / beta * h if beta > 0.0 else -1.0
    inside = beta * beta - 4.0 * alpha * da
    if inside < 0.0:
        return -1.0
    place = (-beta + math.sqrt(inside)) / (2.0 * alpha)
    return place * h if 0.0 < place < 1.0 else -1.0


def is_quiet(Y, A, W, n, slope):
    """Whether the oscillation about equilibrium is too small for any event, up to the end of the thrust segment."""
    if n != 2 or slope != 0.0 or not (A[V, X] < 0.0 and A[V, V] <= 0.0 and A[X, V] == 1.0):
        return False
    stiffness = -A[V, X]
    centre = (A[V, n] * Y[n] + A[V, n + 2]) / stiffness
    size = math.sqrt((Y[X] - centre) ** 2 + Y[V] ** 2 / stiffness)
    for i in range(WATCHED):
        rest = W[i, X] * centre + W[i, n] * Y[n] + W[i, n + 2]
        swing = math.sqrt(W[i, X] ** 2 + W[i, V] ** 2 * stiffness) * size
        if rest <= swing and swing > 0.0:
            return False
        if swing == 0.0 and rest < 0.0:
            return False
    return True


def linear_root(A, W, G, i, size, reached, Y, low, high, guess, probe, work):
    """Time in (low, high) at which row i of W·Y falls through zero: Newton's steps kept inside a shrinking bracket.

    Where the power series of the state converges over the bracket, that of row i is made once and then evaluated.
    """
    n = size - 3
    order = 0
    series, term = work[9], work[10]
    if reached * high <= 2.0:
        order = 9 + int(12.0 * reached * high)
        for j in range(size):
            term[j] = Y[j]
        series[0] = inner(W, i, Y, size)
        for o in range(1, order + 1):
            for j in range(n):
                total = 0.0
                for l in range(n + 1):
                    total += A[j, l] * term[l]
                work[0, j] = (total + A[j, n + 2] * term[n + 2]) * INVERSE[o]
            term[n], term[n + 1], term[n + 2] = term[n + 1] * INVERSE[o], 0.0, 0.0
            total = W[i, n] * term[n]
            for j in range(n):
                term[j] = work[0, j]
                total += W[i, j] * term[j]
            series[o] = total
    t = guess
    for _ in range(100):
        value, slope = 0.0, 0.0
        if order > 0:
            for o in range(order, -1, -1):
                slope = slope * t + value
                value = value * t + series[o]
        else:
            advance(A, size, reached, Y, t, probe, work)
            value, slope = inner(W, i, probe, size), inner(G, i, probe, size)
        if value > 0.0:
            low = t
        else:
            high = t
        step = value / slope if slope < 0.0 else 0.0
        t_next = t - step
        if slope >= 0.0 or not (low <= t_next <= high):
            t_next = 0.5 * (low + high)
        if abs(t_next - t) <= 1e-9 * t_next and slope < 0.0:
            return t_next  # Newton's next step would be the square of this one
        if high - low <= 1e-15 * high:
            return t_next
        t = t_next
    return t


def linear_event(A, W, G, n, reached, omega, Y, length, budget, E, kept, work):
    """First event of a linear regime within `length`: its time and number (−1 for none), and the steps taken.

    `E` keeps exp(A·h) − 1 for the step h, `kept[0]`.
    """
    size = n + 3
    g, dg, gb, dgb = work[2], work[3], work[4], work[5]
    here, there, probe = work[6], work[7], work[8]
    for i in range(size):
        here[i] = Y[i]
    h = 1.0 / omega if omega > 0.0 else 0.25 * length
    live = np.empty(WATCHED, np.int64)
    count = 0
    for i in range(WATCHED):
        moving = False
        for j in range(size - 1):
            moving = moving or W[i, j] != 0.0
        if moving or W[i, size - 1] < 0.0:
            live[count] = i
            count += 1
    measure(W, G, live, count, size, here, g, dg)
    if count == 0 or is_quiet(here, A, W, n, here[n + 1]):
        return length, -1, 0
    done, steps = 0.0, 0
    while done < length and steps < budget:
        steps += 1
        if omega > 0.0 and length - done > h:
            if kept[0] != h:
                kept[0] = h
                copy(grow(A, size, reached, h), E)
            for i in range(size):
                total = here[i]
                for j in range(size):
                    total += E[i, j] * here[j]
                there[i] = total
            step = h
        else:
            step = min(h, length - done)
            advance(A, size, reached, here, step, there, work)
        measure(W, G, live, count, size, there, gb, dgb)
        first, which = 2.0 * step, -1
        for l in range(count):
            i = live[l]
            if g[i] <= 0.0 and (dg[i] < 0.0 or (dg[i] == 0.0 and gb[i] < 0.0)):
                return done, i, steps
            low, high = 0.0, -1.0
            if gb[i] < 0.0:
                high = step
                if g[i] <= 0.0:  # starts on the edge, inward: pass over the hill first
                    low = hill(A, W, size, reached, here, i, step, probe, work)
            else:
                place = dip(g[i], dg[i], gb[i], dgb[i], step)
                if place > 0.0 and g[i] > 0.0:
                    advance(A, size, reached, here, place, probe, work)
                    if inner(W, i, probe, size) < 0.0:
                        high = place
            if high > first > low:  # whether it comes before the one that is known
                advance(A, size, reached, here, first, probe, work)
                if inner(W, i, probe, size) > 0.0:
                    continue
                high = first
            if high > 0.0 and low < first:
                guess = 0.5 * (low + high)
                if low == 0.0 and high == step:
                    guess = step * g[i] / (g[i] - gb[i])
                root = linear_root(A, W, G, i, size, reached, here, low, high, guess, probe, work)
                if root < first:
                    first, which = root, i
        if which >= 0:
            return done + first, which, steps
        for i in range(size):
            here[i] = there[i]
        for l in range(count):
            g[live[l]], dg[live[l]] = gb[live[l]], dgb[live[l]]
        done += step
        if steps % 32 == 0 and is_quiet(here, A, W, n, here[n + 1]):
            break
    return length, -1, steps


def inner(W, i, Y, size):
    """Row i of W times Y."""
    total = 0.0
    for j in range(size):
        total += W[i, j] * Y[j]
    return total


def measure(W, G, live, count, size, Y, g, dg):
    """Values of what is watched, and their rates."""
    for l in range(count):
        g[live[l]] = inner(W, live[l], Y, size)
        dg[live[l]] = inner(G, live[l], Y, size)


def hill(A, W, size, reached, Y, i, step, probe, work):
    """Find a time at which row i is positive, between an inward start on its zero and a negative value at `step`."""
    t = step
    for _ in range(60):
        t *= 0.5
        advance(A, size, reached, Y, t, probe, work)
        if inner(W, i, probe, size) > 0.0:
            return t
    return 0.0
