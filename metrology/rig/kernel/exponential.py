"""Exact steps of a linear regime by the exponential of its matrix, which is read off the equation of motion."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901, E741

from __future__ import annotations

import math

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    M, K, TAUT, SLIP, TOE, TOE_RATIO, FRAME, FRAME_RATE, ARM, INERTIA, YAW_RATE, APPENDAGE, APPENDAGE_RATE, ZENER,
    SECOND, HYSTERESIS, STOP, X, V, SIZE, ATTACHMENT, N, NO_LINE, CONTACT, SLIPPED, TOUCHED, STRETCHED, WATCHED,
    added_stiffness,
)  # fmt: skip
from metrology.rig.kernel.equation import motion
from metrology.rig.kernel.regimes import watch

INVERSE = 1.0 / np.maximum(np.arange(40), 1)  # division is slow where it is waited for


def assemble(r, p, kind, at, A, W, rows):
    """Read the matrices of a linear regime off `motion`, `watch` and the channels; Y = (y, F, F′, 1)."""
    n = kind[N]
    last = n + 2
    y, dy, g = np.zeros(SIZE), np.zeros(SIZE), np.zeros(WATCHED)
    d0, g0 = np.zeros(SIZE), np.zeros(WATCHED)
    for i in range(n + 3):
        for j in range(n + 3):
            A[i, j] = 0.0
        for j in range(3):
            rows[j, i] = 0.0
    t0 = 0.0
    for j in range(-1, n + 1):  # first at rest, then with one state or the thrust at 1
        if j >= 0:
            y[j] = 1.0 if j < n else y[j]
        thrust = 1.0 if j == n else 0.0
        T = motion(y, thrust, r, p, kind, at, dy)
        watch(y, thrust, r, p, kind, at, g)
        if j < 0:
            t0 = T
            for i in range(n):
                d0[i] = dy[i]
            for i in range(WATCHED):
                g0[i] = g[i]
            continue
        for i in range(n):
            A[i, j] = dy[i] - d0[i]
        for i in range(WATCHED):
            W[i, j] = g[i] - g0[i]
        rows[2, j] = T - t0
        if j < n:
            y[j] = 0.0
    for i in range(n):
        A[i, last] = d0[i]
    A[n, n + 1] = 1.0
    for i in range(WATCHED):
        W[i, n + 1] = 0.0
        W[i, last] = g0[i]
    rows[0, X], rows[1, V], rows[2, last] = 1.0, 1.0, t0
    rows[0, last] = p[TAUT] + p[SLIP] * r[SLIPPED]


def fastest(r, p, kind):
    """Bound on the angular frequency of the regime, rad/s."""
    k = p[K] * max(1.0, p[TOE_RATIO] if p[TOE] > 0.0 else 1.0) + p[ZENER] + p[SECOND] + p[HYSTERESIS]
    if kind[ATTACHMENT] == NO_LINE or r[CONTACT] != STRETCHED:
        k = 0.0
    rate = (k + max(added_stiffness(p), 0.0) + p[STOP] * r[TOUCHED]) / (p[M] - p[APPENDAGE])
    if p[APPENDAGE] > 0.0:
        rate += p[APPENDAGE_RATE] ** 2 / (1.0 - p[APPENDAGE] / p[M])
    if p[FRAME] > 0.0:
        rate += p[FRAME_RATE] ** 2 * (1.0 + p[FRAME] * k)
    if p[ARM] != 0.0:
        rate += p[YAW_RATE] ** 2 + p[ARM] ** 2 * k / p[INERTIA]
    return math.sqrt(rate)


def reach(A, n, omega):
    """Norm of A for states scaled to one another: how fast the power series in A·h begins to converge.

    Position and velocity alone are scaled by ω. With more states, each is scaled until what drives it is as large as
    what it drives (Osborne, J. ACM 7 (1960) 338): a second velocity, too, is as large as its frequency.
    """
    scale = np.full(n, 1.0)
    scale[V] = omega
    if omega == 0.0:  # a free motion's series ends by itself, however long the time
        scale[V] = 1e-6 if n == 2 else 1.0
    for _ in range(0 if n == 2 else 6):
        for i in range(n):
            driven, drives = 0.0, 0.0
            for j in range(n):
                if j != i:
                    driven += abs(A[i, j]) * scale[j] / scale[i]
                    drives += abs(A[j, i]) * scale[i] / scale[j]
            if driven > 0.0 and drives > 0.0:
                scale[i] *= math.sqrt(driven / drives)
            elif driven > 0.0 and A[i, i] != 0.0:  # what drives nothing may be as large as it likes
                scale[i] *= driven / abs(A[i, i])
    largest = 0.0
    for j in range(n):
        total = 0.0
        for i in range(n):
            total += abs(A[i, j]) * scale[j] / scale[i]
        largest = max(largest, total)
    return largest


def grow(A, size, reached, h):
    """exp(A·h) − 1, by squaring the difference itself: the difference keeps the digits that the sum would lose.

    The last three rows of A say that F grows by F′ and that F′ and 1 stay: they are not multiplied out.
    """
    n = size - 3
    halvings = 0
    while reached * h > 0.25 and halvings < 60:
        h *= 0.5
        halvings += 1
    E = np.zeros((size, size))
    F = np.zeros((size, size))
    for order in range(14, 0, -1):
        for i in range(n):
            for j in range(size):
                total = A[i, j]
                for l in range(n):
                    total += A[i, l] * E[l, j]
                F[i, j] = total * h / order
            F[i, n + 1] += A[i, n] * E[n, n + 1] * h / order
        F[n, n + 1] = h / order
        E, F = F, E
    for _ in range(halvings):
        square(E, F)
        E, F = F, E
    return E


def square(E, F):
    """F + 1 = (E + 1)², both of them of the form that `grow` has."""
    size = E.shape[0]
    n = size - 3
    for i in range(n):
        for j in range(size):
            total = 2.0 * E[i, j]
            for l in range(n):
                total += E[i, l] * E[l, j]
            F[i, j] = total
        F[i, n + 1] += E[i, n] * E[n, n + 1]
    F[n, n + 1] = 2.0 * E[n, n + 1]


def copy(E, into):
    """Copy a square matrix."""
    for i in range(E.shape[0]):
        for j in range(E.shape[0]):
            into[i, j] = E[i, j]


def advance(A, size, reached, Y, h, out, work):
    """Y after the time h: by the power series, in a few steps, or by the matrix exponential where those are many."""
    n = size - 3
    for i in range(size):
        out[i] = Y[i]
    if h == 0.0:
        return
    turns = reached * abs(h)
    if turns > 6.0:
        E = grow(A, size, reached, h)
        for i in range(n + 1):
            for j in range(size):
                out[i] += E[i, j] * Y[j]
        return
    steps = int(turns) + 1
    h = h / steps
    order = 9 + int(12.0 * turns / steps)
    for _ in range(steps):
        for i in range(n):  # the first term carries the force, its growth and the constant
            total = A[i, n] * out[n] + A[i, n + 2]
            for j in range(n):
                total += A[i, j] * out[j]
            work[0, i] = total * h
        rise = out[n + 1] * h
        for i in range(n):
            out[i] += work[0, i]
        now, then = 0, 1
        for o in range(2, order + 1):
            scale = h * INVERSE[o]
            idle = True
            for i in range(n):
                total = 0.0
                for j in range(n):
                    total += A[i, j] * work[now, j]
                if o == 2:
                    total += A[i, n] * rise
                work[then, i] = total * scale
                out[i] += work[then, i]
                idle = idle and total == 0.0
            if idle:  # the series of a free motion ends by itself
                break
            now, then = then, now
        out[n] += rise
