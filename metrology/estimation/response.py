"""Runs on the rig as blocks of a least-squares problem."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from metrology.errors import MetrologyError
from metrology.estimation.measured import MeasuredRun
from metrology.estimation.priors import Layout
from metrology.estimation.problem import Array, Block, Marks, Problem, Segment
from metrology.rig import Motion, Rig, Run, Sensitivities, sensitivities, simulate

CONTACT = ("taut", "slack", "clamp slip", "toe")
"""Events at which the tension may jump: readings beside them get no weight."""
BESIDE = (1.5, 2e-3)
"""How far beside: sample intervals, and seconds; the larger counts."""

GRADUAL = 0.3
"""Sample intervals that the line takes to be pulled straight, from which on its tension does not jump."""

Mask = dict[str, Marks]


@dataclass(frozen=True)
class View:
    """How the readings are looked at: up to which time, with which weights.

    `until` / s: later readings are left out. `temper`: factor on every standard uncertainty. `beside` / s: least
    distance of a tension reading from a change of contact. `smooth`: leave the tension out where
    position or velocity is there, since it jumps at contacts that are not yet where they belong.
    """

    until: float = math.inf
    temper: float = 1.0
    beside: float = BESIDE[1]
    smooth: bool = False


def values_of(layout: Layout, at: int, theta: Array) -> dict[str, float]:
    """Values of the rig's parameters in run number `at`.

    Parameters
    ----------
    layout : Layout
        Of the unknowns.
    at : int
        Number of the run.
    theta : ndarray, shape (p,)
        Values of the unknowns, in their units.

    Returns
    -------
    dict of str to float
        By name of the parameter, in its unit.
    """
    return layout.values(at, theta[list(layout.uses[at])])


def motion(rig: Rig, run: Run, values: dict[str, float]) -> Motion | None:
    """Motion with these values, None where they are impossible or the motion cannot be followed.

    Parameters
    ----------
    rig : Rig
        As stated.
    run : Run
        Thrust, start and time stamps.
    values : dict of str to float
        Parameters that differ from the stated ones, in their units.

    Returns
    -------
    Motion or None
        With status 'ok'.
    """
    try:
        found = simulate(rig.with_values(values), run)
    except MetrologyError:
        return None
    return found if found.status == "ok" else None


def beside_contact(measured: MeasuredRun, moved: Motion, least: float = BESIDE[1], clock: float = 0.0) -> Marks:
    """Tension readings beside a change of contact, which jump with every parameter; `clock` / s is that of the cell.

    A reading that the clock stamps a fraction of a sample early shows the other side of the jump: no standard
    uncertainty of the reading covers that.

    Parameters
    ----------
    measured : MeasuredRun
        With readings of the tension.
    moved : Motion
        The simulated motion with its events.
    least : float
        Least distance from a contact, in s.
    clock : float
        Delay of the clock of the cell, in s.

    Returns
    -------
    ndarray of bool, shape (n,)
        True where a reading lies that near to a contact.
    """
    stamps = measured.stamps("T")
    true = stamps - clock
    beside = np.zeros(stamps.shape, dtype=bool)
    distance = max(BESIDE[0] * _interval(stamps), least)
    for event in moved.events:
        if event.kind in CONTACT:
            first, last = np.searchsorted(true, (event.t - distance, event.t + distance))
            beside[first:last] = True
    return beside


def _interval(stamps: Array) -> float:
    """Median time from one reading to the next / s; 0 for a single one."""
    return float(np.median(np.diff(stamps))) if stamps.size > 1 else 0.0


def _is_gradual(rig: Rig, measured: MeasuredRun, moved: Motion) -> bool:
    """Whether the tension comes so gradually that readings follow it: then it says what is in series with the line.

    A sagging line is pulled straight over (q²·s³/(24·k²))^⅓, where sag and stretch are alike, if its dashpot, of which
    the catenary knows nothing, is not what pulls it straight.
    """
    if not rig.sags or moved.v is None:
        return False
    length, speed = math.cbrt(rig.sag_weight**2 * rig.length**3 / (24 * rig.k**2)), float(np.abs(moved.v).max())
    return length > GRADUAL * _interval(measured.stamps("T")) * speed and rig.k * length > rig.c * speed


def masks(rig: Rig, runs: Sequence[MeasuredRun], layout: Layout, theta: Array, view: View) -> list[Mask] | None:
    """Readings to use, run by run and channel by channel, at these values; None where a motion has no answer.

    Parameters
    ----------
    rig : Rig
        As stated.
    runs : sequence of MeasuredRun
        In the order of the layout.
    layout : Layout
        Of the unknowns.
    theta : ndarray, shape (p,)
        Values of the unknowns, in their units.
    view : View
        Up to which time, and how near to a contact, readings count.

    Returns
    -------
    list of mapping of str to ndarray of bool, or None
        For each run by channel, shape (n,).
    """
    found = []
    for at, measured in enumerate(runs):
        use = {name: measured.used(name) & (measured.stamps(name) <= view.until) for name in measured.channels}
        if "T" in use and view.smooth and len(use) > 1:
            use["T"] = np.zeros_like(use["T"])
        elif "T" in use:
            values = values_of(layout, at, theta)
            moved = motion(rig, measured.run, values)
            if moved is None:
                return None
            here = rig.with_values(values)
            if view.beside > BESIDE[1] or not _is_gradual(here, measured, moved):
                use["T"] = use["T"] & ~beside_contact(measured, moved, view.beside, here.value("clock.T"))
        found.append(use)
    return found


def problem(rig: Rig, runs: Sequence[MeasuredRun], layout: Layout, use: Sequence[Mask], view: View) -> Problem:
    """Joint problem of all runs.

    Parameters
    ----------
    rig : Rig
        As stated.
    runs : sequence of MeasuredRun
        In the order of the layout.
    layout : Layout
        Of the unknowns.
    use : sequence of mapping of str to ndarray of bool
        Readings that count, from `masks`.
    view : View
        Up to which time, and how near to a contact, readings count.

    Returns
    -------
    Problem
        A block of whitened residuals for each run.
    """
    blocks = [_block(rig, runs[at], (layout, at), use[at], view) for at in range(len(runs))]
    return Problem(layout.unknowns, tuple(blocks))


def _block(rig: Rig, measured: MeasuredRun, place: tuple[Layout, int], use: Mask, view: View) -> Block:
    layout, at = place
    seen = cut(measured, view.until)
    channels = [name for name in measured.channels if getattr(seen, f"t_{name}") is not None]
    readings, weights, segments, start = [], [], [], 0
    for name in channels:
        count = len(getattr(seen, f"t_{name}"))
        used = use[name][:count]
        readings.append(np.where(used, measured.readings(name)[:count], 0.0))
        weights.append(used / (measured.noise[name] * view.temper))
        segments.append(Segment(name, start, start + count))
        start += count
    read, weight = np.concatenate(readings), np.concatenate(weights)
    positive = weight[weight > 0]

    def residuals(local: Array) -> Array | None:
        moved = motion(rig, seen, layout.values(at, local))
        if moved is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):  # A motion that ran away: no answer, as `evaluate` tells.
            found: Array = (read - np.concatenate([getattr(moved, name) for name in channels])) * weight
        return found

    def derivatives(local: Array) -> Array | None:
        found = slopes(rig, seen, layout.names, layout.values(at, local))
        if found is None:
            return None
        moved = layout.moved(at, local)
        # Columns one after the other in memory: sums over readings then run three times as fast.
        columns = np.empty((len(layout.targets[at]), len(weight))).T
        for segment in segments:
            rows = slice(segment.first, segment.last)
            part: Array = getattr(found, segment.name)
            for column, target in enumerate(layout.targets[at]):
                np.multiply(part[:, target], -moved[column] * weight[rows], out=columns[rows, column])
        return columns

    log_u = float(-np.log(positive).sum() + 0.5 * positive.size * math.log(2 * math.pi))
    return Block(
        measured.name, layout.uses[at], residuals, derivatives, tuple(segments), count=positive.size, log_u=log_u
    )


def slopes(rig: Rig, run: Run, names: Sequence[str], values: dict[str, float]) -> Sensitivities | None:
    """Derivatives of every channel by each parameter at these values; None where the motion has no answer.

    Parameters
    ----------
    rig : Rig
        As stated.
    run : Run
        Thrust, start and time stamps.
    names : sequence of str, length p
        Parameters by which the derivatives are.
    values : dict of str to float
        Parameters that differ from the stated ones, in their units.

    Returns
    -------
    Sensitivities or None
        Derivatives of x, v and T, each of shape (n, p).
    """
    try:
        found = sensitivities(rig.with_values(values), run, names)
    except MetrologyError:
        return None
    return found if found.valid else None


def cut(measured: MeasuredRun, until: float) -> Run:
    """Return the run up to a time: same start and thrust, later stamps left out."""
    run = measured.run
    if until >= run.end:
        return run
    kept: dict[str, Array | None] = {}
    for name in measured.channels:
        stamps = measured.stamps(name)
        inside = stamps[stamps <= until]
        kept[f"t_{name}"] = inside if inside.size else None
    if all(stamps is None for stamps in kept.values()):
        return run
    return replace(run, **kept)  # type: ignore[arg-type]
