"""The motion under an effect of the laboratory's own: its force as a table along the motion, iterated to a fixed point.

Picard's iteration (waveform relaxation): simulate, evaluate the force along the motion, apply it as the run's added
force, until the motion stays. The map is a Volterra operator, which contracts on a short enough window; windows are
halved where it contracts slowly.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.message import said
from metrology.rig.model import Rig
from metrology.rig.motion import Motion
from metrology.rig.own import Own, placed
from metrology.rig.parameters import UNREAD
from metrology.rig.run import Array, Force, Run, frozen

TOLERANCE = 1e-8
"""Change of x, v and T, relative to their largest values, at which the iteration ends."""
PASSES = 20
FEWEST = 4
"""Steps of the table between two events, at least."""
STEP = 0.05
"""Step of the table times the angular frequency of the line."""
LONGEST, MOST = 0.01, 400_000
SIDE = 1e-8
"""Distance / s from an event at which the force on either side of it is read."""
Solve = Callable[[Rig, Run], Motion]


@dataclass(frozen=True, eq=False)
class _Table:
    """Force (n,) at the nodes `t`, the motion (3, n) there, and the steps between one event and the next."""

    t: Array
    force: Array
    seen: Array
    counts: tuple[int, ...] = ()


class _Unsettled(Exception):  # noqa: N818 - never leaves this file
    pass


def follow(rig: Rig, run: Run, solve: Solve) -> Motion:
    """Motion of a rig with effects of its own.

    Parameters
    ----------
    rig, run : Rig, Run
        As for `simulate`.
    solve : callable
        Simulates a rig without effects of its own.

    Returns
    -------
    Motion
        Invalid, with a sentence and NaN from then on, where the iteration does not settle.

    Raises
    ------
    MetrologyError
        Where a function of the laboratory's own fails, or gives another number of values than it was given.
    """
    plain = rig.without_own()
    end = max(run.end - min(0.0, *(rig.value(f"clock.{name}") for name in "xvT")), run.t0 + SIDE)
    known, step = _Table(np.array([run.t0]), np.zeros(1), np.zeros((3, 1))), _step(rig, end - run.t0)
    window = end - run.t0
    while known.t[-1] < end:
        until = min(end, float(known.t[-1]) + window)
        try:
            known = _settle(rig, run, known, until, step, solve)
            window *= 2.0
        except _Unsettled as reason:
            window = 0.5 * (until - float(known.t[-1]))
            if window < FEWEST * step:
                motion = solve(plain, replace(run, added=_added(run, known, end)))
                return _cut(motion, run, float(known.t[-1]), reason.args[0])
    return solve(plain, replace(run, added=_added(run, known, end)))


def _step(rig: Rig, length: float) -> float:
    k = rig.k + sum(rig.value(f"{name}.stiffness") for name in ("zener", "second_branch", "hysteresis"))
    omega = math.sqrt(k / (rig.m * rig.value("mass.factor")))
    return max(min(LONGEST, STEP / omega if omega > 0 else LONGEST), length / MOST)


def _settle(rig: Rig, run: Run, known: _Table, until: float, step: float, solve: Solve) -> _Table:
    """Extend the table to `until`, by iteration; unsettled where its motion moves on."""
    start = float(known.t[-1])
    t, counts = _nodes(np.array([start, until]), step, ())
    table = _Table(t, np.full(t.size, known.force[-1]), np.full((3, t.size), math.inf), counts)
    changes: list[float] = []
    for _ in range(PASSES):
        table, change = _pass(rig, run, (known, table), (start, until, step), solve)
        changes.append(change)
        if change <= TOLERANCE:
            return _joined(known, table)
        if len(changes) > 6 and not changes[-1] < 0.5 * changes[-4]:
            break
    text = (
        "the force of {names} does not converge; it may jump where the motion has no event, or be far too stiff: make "
        "it smooth, or smaller"
    )
    raise _Unsettled(said(text, names=_names(rig)))


def _pass(
    rig: Rig, run: Run, tables: tuple[_Table, _Table], span: tuple[float, float, float], solve: Solve
) -> tuple[_Table, float]:
    """Simulate under the force of the tables, read it off that motion again; how far the motion moved."""
    (known, table), (start, until, step) = tables, span
    bare = rig.without_own().with_values(UNREAD)
    added = _added(run, _joined(known, table), until)
    motion = solve(bare, _watched(run, table.t, added))
    _require_followed(motion, rig)
    inside = [event.t for event in motion.events if start + SIDE < event.t < until - SIDE]
    t, counts = _nodes(np.array([start, *inside, until]), step, table.counts)
    if t.shape != table.t.shape or np.abs(t - table.t).max() > 0.1 * SIDE:
        motion = solve(bare, _watched(run, t, added))
        _require_followed(motion, rig)
    seen = np.array([motion.x, motion.v, motion.T], dtype=float)
    force = _level(_force(rig, t, seen, motion), counts)
    change = math.inf
    if counts == table.counts:
        largest = np.maximum(np.abs(seen).max(axis=1), np.abs(known.seen).max(axis=1))
        change = float((np.abs(seen - table.seen).max(axis=1) / np.where(largest > 0, largest, 1.0)).max())
    return _Table(t, force, seen, counts), change


def _nodes(ends: Array, step: float, before: tuple[int, ...]) -> tuple[Array, tuple[int, ...]]:
    """Evenly spaced times between each event and the next, and how many steps; as many as before where that fits."""
    stretches = [(a, b) for a, b in pairwise(ends.tolist()) if b - a > 10 * SIDE] or [(ends[0], ends[-1])]
    counts = [max(FEWEST, math.ceil((b - a) / step)) for a, b in stretches]
    if len(before) == len(counts) and all(abs(old - new) <= 1 for old, new in zip(before, counts, strict=True)):
        counts = list(before)
    parts = [
        np.linspace(a + SIDE, b if b == ends[-1] else b - SIDE, count + 1)
        for (a, b), count in zip(stretches, counts, strict=True)
    ]
    return np.concatenate(parts), tuple(counts)


def _level(force: Array, counts: tuple[int, ...]) -> Array:
    """Nodes whose straight lines have the impulse of the smooth force: f − f″·h²/12, to fourth order in the step."""
    levelled, first = force.copy(), 0
    for count in counts:
        part = force[first : first + count + 1]
        bend = np.empty(part.size)
        bend[1:-1] = np.diff(part, 2)
        bend[0], bend[-1] = 2.0 * bend[1] - bend[2], 2.0 * bend[-2] - bend[-3]
        levelled[first : first + count + 1] -= bend / 12.0
        first += count + 1
    return levelled


def _force(rig: Rig, t: Array, seen: Array, motion: Motion) -> Array:
    """Sum of the rig's own forces along the motion."""
    x, v, T = seen
    slipped = [event.t for event in motion.events if event.kind == "clamp slip"]
    e = x - rig.taut - rig.value("free_length.shift")
    if slipped:
        e = e - rig.value("slip.set") * (t > slipped[0])
    given, total = dict(rig.effects), np.zeros(t.size)
    for own in rig.own:
        if own.acts(given):
            total += _called(own, (t, x, v, e, T), own.values(given))
    if not np.isfinite(total).all():
        at = int(np.flatnonzero(~np.isfinite(total))[0])
        text = "the force of {names} is no finite number at x = {x:.6g} m, v = {v:.6g} m/s"
        raise _Unsettled(said(text, names=_names(rig), x=float(x[at]), v=float(v[at])))
    return total


def _called(own: Own, state: tuple[Array, ...], values: dict[str, float]) -> Array:
    name = f"own.{own.effect.name}.force"
    try:
        with np.errstate(all="ignore"):
            force = np.asarray(own.force(*(frozen(one.copy()) for one in state), **values), dtype=float)
    except Exception as error:
        where = placed(own.force, name, error)
        raise MetrologyError(Fault(where, f"{type(error).__name__}: {error}", "a force in N for each time")) from error
    if force.shape not in ((), state[0].shape):
        expected = f"{state[0].shape}, a force in N for each time"
        raise MetrologyError(Fault(placed(own.force, name), f"shape {force.shape}", expected))
    return force


def _joined(known: _Table, table: _Table) -> _Table:
    return _Table(
        np.concatenate([known.t, table.t]),
        np.concatenate([known.force, table.force]),
        np.concatenate([known.seen, table.seen], axis=1),
    )


def _watched(run: Run, t: Array, added: Force) -> Run:
    stamps = frozen(t.copy())
    return replace(run, t_x=stamps, t_v=stamps, t_T=stamps, added=added)


def _added(run: Run, table: _Table, end: float) -> Force:
    """Return the table up to `end`, with the run's own added force."""
    t, force = table.t, table.force
    if t[-1] < end:
        t, force = np.append(t, end), np.append(force, force[-1])
    if run.added is not None:
        both = np.union1d(t, run.added.t[(run.added.t > t[0]) & (run.added.t < t[-1])])
        t, force = both, np.interp(both, t, force) + np.interp(both, run.added.t, run.added.values)
    return Force(t, force, "linear")


def _names(rig: Rig) -> str:
    given = dict(rig.effects)
    return ", ".join(f"'{own.effect.name}'" for own in rig.own if own.acts(given))


def _require_followed(motion: Motion, rig: Rig) -> None:
    if motion.status != "ok":
        text = "the motion under the force of {names} cannot be followed: {message}"
        raise _Unsettled(said(text, names=_names(rig), message=motion.message))


def _cut(motion: Motion, run: Run, since: float, why: str) -> Motion:
    """Return the motion as invalid, with no numbers from `since` on."""
    x, v, T = (
        None if t is None or channel is None else np.where(t >= since, np.nan, channel)
        for t, channel in ((run.t_x, motion.x), (run.t_v, motion.v), (run.t_T, motion.T))
    )
    # What cannot be followed says so in a sentence of its own.
    message = said(
        "at {since:.6g} s {reason}" if why.endswith(".") else "at {since:.6g} s {reason}.", since=since, reason=why
    )
    return replace(motion, x=x, v=v, T=T, status="invalid", message=message)
