"""Steps of a nonlinear regime by Dormand and Prince's 8(5,3) pairs, their dense output, and the leg that they make."""

# Types are inferred by the compiler; names and long branches are those of the mathematics.
# mypy: disable-error-code="no-untyped-def, no-untyped-call, no-any-return"
# ruff: noqa: C901

from __future__ import annotations

import math

import numpy as np

from metrology.rig.kernel.layout import (  # isort: skip - in the order of the positions
    TAUT, SLIP, LAG, X, V, SIZE, FRAME_U, FRAME_V, YAW_U, YAW_V, APPENDAGE_U, APPENDAGE_V, RELAXED, RELAXED_B, LOOP,
    THRUST, TIME, N, SLIPPED, WATCHED, FIRST,
)  # fmt: skip
from metrology.rig.kernel.equation import motion, shown, tension
from metrology.rig.kernel.exponential import fastest
from metrology.rig.kernel.regimes import watch
from metrology.rig.kernel.zeros import dip

RTOL = 3e-10
# Error of a step, over what is allowed, below which the next is twice as long: rounding makes errors of 1e-6, which
# else choose the sizes of all later steps anew for every last digit of a parameter.
LEAST_ERROR = 1.7e-3
# Steps between two events: for each radian of the fastest rate, and as many more. They take two or three for a radian;
# a motion that runs away under a drag takes ever shorter ones, for seconds, before any bound of its size is reached.
PER_RADIAN, LEG_STEPS, EXHAUSTED = 100.0, 20_000, -2


def lagged(y, F, slope, after, p, at, out):
    """Put the lagging thrust, known in closed form, into the state `out` some time after `y`.

    A short lag would be stiff otherwise: the steps would follow it for ever, long after it has died away.
    """
    if p[LAG] > 0.0:
        behind = F - slope * p[LAG]
        out[at[THRUST]] = behind + slope * after + (y[at[THRUST]] - behind) * math.exp(-after / p[LAG])


def take_step(y, F, slope, h, r, p, kind, at, pair, stages, new, probe):
    """One step of the 8th-order pair: fills `stages` and `new`; `stages[0]` has to be there."""
    a, b, c = pair[0], pair[1], pair[2]
    n = kind[N]
    for s in range(1, 12):
        for i in range(n):
            total = 0.0
            for j in range(s):
                total += a[s, j] * stages[j, i]
            probe[i] = y[i] + h * total
        lagged(y, F, slope, c[s] * h, p, at, probe)
        motion(probe, F + slope * c[s] * h, r, p, kind, at, stages[s])
    for i in range(n):
        total = 0.0
        for j in range(12):
            total += b[j] * stages[j, i]
        new[i] = y[i] + h * total
    lagged(y, F, slope, h, p, at, new)
    motion(new, F + slope * h, r, p, kind, at, stages[12])


def misfit(y, new, largest, h, n, at, pair, stages):
    """Estimated error of the step over what is allowed.

    Displacements of frame, yaw and line act through e alone, an appendage through its acceleration, so that what is
    small beside x need not be followed.
    """
    e3, e5 = pair[3], pair[4]
    sum3, sum5 = 0.0, 0.0
    for i in range(n):
        if i == at[THRUST] or i == at[TIME]:  # exact
            continue
        scale = largest[i]
        line = i == at[RELAXED] or i == at[RELAXED_B] or i == at[LOOP]
        if line or i == at[FRAME_U] or i == at[YAW_U] or i == at[APPENDAGE_U]:
            scale = max(scale, largest[X])
        elif i == at[FRAME_V] or i == at[YAW_V] or i == at[APPENDAGE_V]:
            scale = max(scale, largest[V])
        err3, err5 = 0.0, 0.0
        for j in range(13):
            err3 += e3[j] * stages[j, i]
            err5 += e5[j] * stages[j, i]
        allowed = RTOL * (max(abs(y[i]), abs(new[i])) + 1e-3 * scale) + 1e-17
        sum3 += (err3 / allowed) ** 2
        sum5 += (err5 / allowed) ** 2
    if sum5 == 0.0 and sum3 == 0.0:
        return 0.0
    return abs(h) * sum5 / math.sqrt((sum5 + 0.01 * sum3) * n)


def growth(error):
    """Factor from a step that was taken to the next, at most 2."""
    return 0.9 * max(error, LEAST_ERROR) ** -0.125


def make_dense(y, new, F, slope, h, r, p, kind, at, pair, stages, dense, probe):
    """Coefficients of the 7th-order interpolant of a step."""
    d, a_extra, c_extra = pair[5], pair[6], pair[7]
    n = kind[N]
    for s in range(3):
        for i in range(n):
            total = 0.0
            for j in range(13 + s):
                total += a_extra[s, j] * stages[j, i]
            probe[i] = y[i] + h * total
        lagged(y, F, slope, c_extra[s] * h, p, at, probe)
        motion(probe, F + slope * c_extra[s] * h, r, p, kind, at, stages[13 + s])
    for i in range(n):
        change = new[i] - y[i]
        dense[0, i] = change
        dense[1, i] = h * stages[0, i] - change
        dense[2, i] = 2.0 * change - h * (stages[12, i] + stages[0, i])
        for q in range(4):
            total = 0.0
            for j in range(16):
                total += d[q, j] * stages[j, i]
            dense[3 + q, i] = h * total


def read_dense(y, F, slope, h, p, kind, at, dense, theta, out):
    """State at the share `theta` of the step."""
    rest = 1.0 - theta
    for i in range(kind[N]):
        total = dense[3, i] + theta * (dense[4, i] + rest * (dense[5, i] + theta * dense[6, i]))
        out[i] = y[i] + theta * (dense[0, i] + rest * (dense[1, i] + theta * (dense[2, i] + rest * total)))
    lagged(y, F, slope, theta * h, p, at, out)


def rates(y, F, slope, dy, g, r, p, kind, at, probe, other, dg):
    """Rates of what is watched along the motion."""
    step = 1e-6
    for i in range(kind[N]):
        probe[i] = y[i] + step * dy[i]
    watch(probe, F + slope * step, r, p, kind, at, other)
    for i in range(WATCHED):
        dg[i] = (other[i] - g[i]) / step


def dense_root(y, F, slope, h, i, low, high, r, p, kind, at, dense, probe, other):
    """Share of the step in (low, high) at which entry i of `watch` falls through zero, by the secant in a bracket."""
    read_dense(y, F, slope, h, p, kind, at, dense, low, probe)
    watch(probe, F + slope * low * h, r, p, kind, at, other)
    a = max(other[i], 0.0)
    read_dense(y, F, slope, h, p, kind, at, dense, high, probe)
    watch(probe, F + slope * high * h, r, p, kind, at, other)
    b = other[i]
    side = 0
    for _ in range(200):
        theta = high - b * (high - low) / (b - a) if b != a else 0.5 * (low + high)
        if not (low < theta < high):
            theta = 0.5 * (low + high)
        read_dense(y, F, slope, h, p, kind, at, dense, theta, probe)
        watch(probe, F + slope * theta * h, r, p, kind, at, other)
        if other[i] > 0.0:
            low, a = theta, other[i]
            if side == 1:
                b *= 0.5
            side = 1
        else:
            high, b = theta, other[i]
            if side == -1:
                a *= 0.5
            side = -1
        if high - low <= 1e-15 or other[i] == 0.0:
            break
    return high


def step_event(y, F, slope, h, g, dg, gb, dgb, r, p, kind, at, dense, probe, other):
    """First event within a step: its share of the step and its number, −1 for none."""
    first, which = 2.0, -1
    for i in range(WATCHED):
        if g[i] <= 0.0 and (dg[i] < 0.0 or (dg[i] == 0.0 and gb[i] < 0.0)):
            return 0.0, i
        low, high = 0.0, -1.0
        if gb[i] < 0.0:
            high = 1.0
            if g[i] <= 0.0:
                theta = 1.0
                for _ in range(60):
                    theta *= 0.5
                    read_dense(y, F, slope, h, p, kind, at, dense, theta, probe)
                    watch(probe, F + slope * theta * h, r, p, kind, at, other)
                    if other[i] > 0.0:
                        low = theta
                        break
        else:
            place = dip(g[i], dg[i], gb[i], dgb[i], h) / h
            if place > 0.0 and g[i] > 0.0:
                read_dense(y, F, slope, h, p, kind, at, dense, place, probe)
                watch(probe, F + slope * place * h, r, p, kind, at, other)
                if other[i] < 0.0:
                    high = place
        if high > 0.0 and low < first:
            root = dense_root(y, F, slope, h, i, low, high, r, p, kind, at, dense, probe, other)
            if root < first:
                first, which = root, i
    return first, which


def first_size(y, dy, length, omega, largest):
    """Size of a first step."""
    h = length
    if omega > 0.0:
        h = min(h, FIRST / omega)
    if abs(dy[V]) > 0.0:
        speed = max(abs(y[V]), 1e-3 * largest[V])
        h = min(h, max(0.1 * speed / abs(dy[V]), 1e-3 * length))
    return h


def put_step(
    y, F, slope, h, t, ends, closed, r, p, kind, at, dense, grids, shifts, firsts, outs, together, probe
):  # fmt: skip
    """Write the samples of a step that begins at `t`, those before `ends` (at it, too, where `closed`)."""
    for channel in range(1 if together else 3):
        i, grid, shift = firsts[channel], grids[channel], shifts[channel]
        while i < grid.shape[0]:
            stamp = grid[i] - shift
            if stamp > ends or (stamp == ends and not closed):
                break
            read_dense(y, F, slope, h, p, kind, at, dense, (stamp - t) / h, probe)
            if channel == 0:
                outs[0][i] = probe[X] + p[TAUT] + p[SLIP] * r[SLIPPED]
            if channel == 1 or together:
                outs[1][i] = probe[V]
            if channel == 2 or together:
                outs[2][i] = shown(probe, tension(probe, r, p, kind, at), p, at)
            i += 1
        firsts[channel] = i
    if together:
        firsts[1], firsts[2] = firsts[0], firsts[0]


def curved_leg(
    F, slope, y, r, p, kind, at, pair, largest, t, stop, last, grids, shifts, firsts, outs, budget, together
):  # fmt: skip
    """Follow a nonlinear regime from `t` to its first event, or to `stop`: samples written, y moved on."""
    n = kind[N]
    stages, dense = np.zeros((16, SIZE)), np.zeros((7, SIZE))
    new, probe, probe2, other = np.zeros(SIZE), np.zeros(SIZE), np.zeros(SIZE), np.zeros(WATCHED)
    g, dg, gb, dgb = np.zeros(WATCHED), np.zeros(WATCHED), np.zeros(WATCHED), np.zeros(WATCHED)
    omega = fastest(r, p, kind)
    length, done, steps = stop - t, 0.0, 0
    motion(y, F, r, p, kind, at, stages[0])
    watch(y, F, r, p, kind, at, g)
    rates(y, F, slope, stages[0], g, r, p, kind, at, probe, other, dg)
    h = first_size(y, stages[0], length, omega, largest)
    if p[LAG] > 0.0 and y[at[THRUST]] != F:
        h = min(h, p[LAG])
    limit = 2.0 / omega if omega > 0.0 else length
    limit = min(limit, length / 4.0)
    budget = min(budget, int(LEG_STEPS + PER_RADIAN * omega * length))
    while done < length and steps < budget:
        steps += 1
        h = min(h, limit)
        if done + h * 1.0000001 >= length:
            h = length - done
        take_step(y, F, slope, h, r, p, kind, at, pair, stages, new, probe)
        error = misfit(y, new, largest, h, n, at, pair, stages)
        if not error < 1.0 and h <= 1e-14 * max(1.0, abs(t)):
            y[X] = np.nan
            return done, -1, steps
        if not error < 1.0:
            h *= max(0.2, 0.9 * error**-0.125) if error == error and error < 1e300 else 0.1
            continue
        make_dense(y, new, F, slope, h, r, p, kind, at, pair, stages, dense, probe)
        watch(new, F + slope * h, r, p, kind, at, gb)
        rates(new, F + slope * h, slope, stages[12], gb, r, p, kind, at, probe, other, dgb)
        theta, which = step_event(y, F, slope, h, g, dg, gb, dgb, r, p, kind, at, dense, probe, other)
        ends = t + done + (h if which < 0 else theta * h)
        at_stop = which < 0 and done + h >= length
        if at_stop:
            ends = stop
        put_step(
            y, F, slope, h, t + done, ends, at_stop and last, r, p, kind, at, dense,
            grids, shifts, firsts, outs, together, probe2,
        )  # fmt: skip
        if which >= 0:
            read_dense(y, F, slope, h, p, kind, at, dense, theta, probe2)
            for i in range(n):
                y[i] = probe2[i]
            return done + theta * h, which, steps
        for i in range(n):
            y[i] = new[i]
            stages[0, i] = stages[12, i]
            largest[i] = max(largest[i], abs(y[i]))
        for i in range(WATCHED):
            g[i], dg[i] = gb[i], dgb[i]
        F += slope * h
        done += h
        h *= growth(error)
    if done < length:
        return done, EXHAUSTED, steps
    return length, -1, steps
