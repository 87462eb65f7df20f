"""Samples of the base model in closed form with NumPy alone: many legs at once in place of a compiled loop."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from metrology.rig import closed
from metrology.rig.run import Array

LONG = 8 * closed.BLOCK
"""Samples of a taut leg above which a table of evenly spaced times pays."""
Line = tuple[float, float, float, float]


def propagate(decay: float, square: float, t: Array) -> Array:
    """`taut_and_free.propagate` at many times, shape (4, n)."""
    rest = square - decay * decay
    if rest > 0.0:
        omega, fall = np.sqrt(rest), np.exp(-decay * t)
        even, odd = fall * np.cos(omega * t), fall * np.sin(omega * t) / omega
    elif rest < 0.0:
        beta = np.sqrt(-rest)
        fall, gap = np.exp(-square / (decay + beta) * t), np.expm1(-2.0 * beta * t)
        even, odd = fall * (1.0 + 0.5 * gap), -fall * gap / (2.0 * beta)
    else:
        even = np.exp(-decay * t)
        odd = even * t
    return np.stack([even + decay * odd, odd, -square * odd, even - decay * odd])


def write(
    legs: Array, ended: bool, m: float, k: float, c: float, taut: float, grids: Any, spans: Any, spacings: Any,
    shifts: Any, together: bool, outs: Any, table: Array,
) -> None:  # fmt: skip
    """Write all samples of the legs of a run: `closed.write`, the short ones at once, the long ones one by one."""
    line = (m, k, c, taut)
    spacing_of_table = math.nan
    for channel in range(1 if together else 3):
        low, high = (0, 3) if together else (channel, channel + 1)
        grid, span, spacing = grids[channel], spans[channel], spacings[channel]
        ends = grid.searchsorted(legs[:, closed.UNTIL] + shifts[channel])
        if ended:
            ends[-1] = grid.searchsorted(legs[-1, closed.UNTIL] + shifts[channel], "right")
        counts = np.diff(ends, prepend=0)
        since = legs[:, closed.SINCE] + shifts[channel]
        at = 0
        for long in [*np.flatnonzero((counts > LONG) & (legs[:, closed.PULLS] == 1.0)).tolist(), len(legs)]:
            first, stop = (int(ends[one - 1]) if one else 0 for one in (at, long))
            if stop > first:
                samples = slice(first, stop)
                parts = [out[samples] for out in outs]
                _short(legs[at:long], counts[at:long], since[at:long], grid[samples], line, parts, range(low, high))
            at = long + 1
            if long == len(legs):
                break
            samples = slice(stop, int(ends[long]))
            parts = [out[samples] for out in outs]
            if span[stop] < ends[long] - 1:
                _short(legs[long:at], counts[long:at], since[long:at], grid[samples], line, parts, range(low, high))
                continue
            if spacing_of_table != spacing[stop]:
                spacing_of_table = spacing[stop]
                table[:] = propagate(0.5 * c / m, k / m, spacing_of_table * np.arange(closed.BLOCK))
            _long(legs[long], grid[samples] - since[long], line, table, parts, range(low, high))


def _short(
    legs: Array, counts: NDArray[np.int64], since: Array, grid: Array, line: Line, outs: Any, channels: range
) -> None:
    """Samples of many legs at once."""
    m, k, c, taut = line
    one = len(legs) == 1
    which = None if one else np.repeat(np.arange(len(legs)), counts)
    times = grid - _each(since, which)
    pulls = legs[:, closed.PULLS] == 1.0
    if not pulls.all():
        x, v, a, T = (
            _each(legs[:, column], which) for column in (closed.LEG_X, closed.LEG_V, closed.DRIVE, closed.LEG_T)
        )
        for channel in channels:
            if channel == 0:
                outs[0][:] = (0.5 * a * times + v) * times + (x + taut)
            elif channel == 1:
                outs[1][:] = a * times + v
            else:
                outs[2][:] = T
    if not pulls.any():
        return
    at: Any = slice(None) if pulls.all() else np.flatnonzero(_each(pulls, which))
    some = None if which is None else which[at]
    u0, v0, q0, dq0, centre, force = _about_equilibrium(legs, line)
    a, b, da, db = propagate(0.5 * c / m, k / m, times[at])
    for channel in channels:
        if channel == 0:
            outs[0][at] = a * _each(u0, some) + b * _each(v0, some) + _each(centre + taut, some)
        elif channel == 1:
            outs[1][at] = da * _each(u0, some) + db * _each(v0, some)
        else:
            outs[2][at] = a * _each(q0, some) + b * _each(dq0, some) + _each(force, some)


def _each(values: Array, which: NDArray[np.int64] | None) -> Any:
    """Value of each sample's leg."""
    return values[0] if which is None else values[which]


def _about_equilibrium(legs: Array, line: Line) -> tuple[Array, ...]:
    """Return u, u′, q, q′, F/k and F of legs with a taut line."""
    m, k, c, _ = line
    force, v = legs[:, closed.DRIVE], legs[:, closed.LEG_V]
    u = legs[:, closed.LEG_X] - force / k
    return u, v, k * u + c * v, k * v - c * (c * v + k * u) / m, force / k, force


def _long(leg: Array, times: Array, line: Line, table: Array, outs: Any, channels: range) -> None:
    """Evenly spaced samples of a taut line: states a block apart times the table of a block."""
    m, k, c, taut = line
    decay, square = 0.5 * c / m, k / m
    u, v, q, dq, centre, force = (float(one[0]) for one in _about_equilibrium(leg[np.newaxis], line))
    sources = ((u, v, taut + centre), (v, -2.0 * decay * v - square * u, 0.0), (q, dq, force))
    whole = len(times) // closed.BLOCK * closed.BLOCK
    blocks, inside = whole // closed.BLOCK, np.ones((3, closed.BLOCK))
    inside[:2] = table[:2]
    a, b, da, db = propagate(decay, square, np.concatenate([times[: whole : closed.BLOCK], times[whole:]]))
    for channel in channels:
        (u0, v0, middle), out = sources[channel], outs[channel]
        u_t = a * u0 + b * v0
        out[whole:] = u_t[blocks:] + middle
        states = np.empty((blocks, 3))
        states[:, 0], states[:, 1], states[:, 2] = u_t[:blocks], (da * u0 + db * v0)[:blocks], middle
        np.matmul(states, inside, out=out[:whole].reshape(blocks, -1))
