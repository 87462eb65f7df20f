"""Phases of a response run, from the events of its simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from metrology.rig import Motion, Rig, Run, simulate

SETTLED = 0.02
"""Share of the largest elongation within which the motion counts as steady."""


@dataclass(frozen=True)
class Phase:
    """A span of time from `start` to `stop` / s: 'slack', 'spike', 'rebound', 'decay', 'steady', 'coast' (no line)."""

    name: str
    start: float
    stop: float


def phases(rig: Rig, run: Run, motion: Motion) -> tuple[Phase, ...]:
    """Phases of one run.

    slack: up to the first contact. spike: the line taut for the first time, up to its next slackness (half a period
    where it stays taut). rebound: slack again, up to the second contact. decay: what follows.
    steady: from when the position stays within 2 % of its largest elongation around its last value.
    A line that also pushes has decay and steady only; no line, one phase 'coast'.

    Parameters
    ----------
    rig : Rig
        As simulated.
    run : Run
        Start and time stamps.
    motion : Motion
        The simulated run, with its events.

    Returns
    -------
    tuple of Phase
        Name, begin and end in s, in order of time.
    """
    first, last = _span(run)
    if rig.attachment == "none" or rig.k == 0:
        return (Phase("coast", first, last),)
    steady = _steady_from(rig, run)
    if rig.attachment == "both ways":
        return _parts([("decay", first), ("steady", steady)], last)
    begins = [("slack", first)]
    taut = [event.t for event in motion.events if event.kind == "taut"]
    loose = [event.t for event in motion.events if event.kind == "slack"]
    if not taut:
        return _parts(begins, last) if run.x0 < rig.taut else _parts([("decay", first), ("steady", steady)], last)
    begins.append(("spike", taut[0]))
    after = [t for t in loose if t > taut[0]]
    if after:
        begins.append(("rebound", after[0]))
        again = [t for t in taut if t > after[0]]
        begins += [("decay", again[0])] if again else []
    else:
        begins.append(("decay", taut[0] + math.pi * math.sqrt(rig.m / rig.k)))
    if begins[-1][0] == "decay":
        begins.append(("steady", max(steady, begins[-1][1])))
    return _parts(begins, last)


def _span(run: Run) -> tuple[float, float]:
    stamps = [t for t in (run.t_x, run.t_v, run.t_T) if t is not None]
    return min(float(t[0]) for t in stamps), run.end


def _steady_from(rig: Rig, run: Run) -> float:
    """Time from which the simulated position stays near its last value; the end where it never does."""
    first, last = _span(run)
    t = np.linspace(first, last, 4001)
    x = simulate(rig, Run(run.x0, run.v0, run.t0, run.held_until, run.force, t, t, t)).x
    if x is None or not np.isfinite(x).all():
        return last
    away = np.flatnonzero(np.abs(x - x[-1]) > SETTLED * max(float((x - rig.taut).max()), 1e-12))
    changed = run.force.t[run.force.t < last].max(initial=first) if run.force is not None else first
    begun = max(float(t[away[-1]]) if away.size else first, float(changed))
    # A motion that still swings crosses its last value now and then: steady takes a tenth of the run.
    return begun if last - begun > 0.1 * (last - first) else last


def _parts(begins: list[tuple[str, float]], last: float) -> tuple[Phase, ...]:
    stops = [start for _, start in begins[1:]] + [last]
    return tuple(Phase(name, start, stop) for (name, start), stop in zip(begins, stops, strict=True) if stop > start)
