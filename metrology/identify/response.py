"""Runs on the rig as blocks of a least-squares problem."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from metrology.errors import MetrologyError
from metrology.identify.measured import MeasuredRun
from metrology.identify.priors import Layout
from metrology.identify.problem import Array, Block, Marks, Problem, Segment
from metrology.rig import CHANNELS, EFFECTS, PARAMETERS, Motion, Rig, Run, jacobian, simulate, simulate_many

CONTACT = ("taut", "slack", "clamp slip", "toe")
"""Events at which the tension may jump: readings beside them get no weight."""
BESIDE = (1.5, 2e-3)
"""How far beside: sample intervals, and seconds; the larger counts."""

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
    """Values of the rig's parameters in run number `at`."""
    return layout.values(at, theta[list(layout.uses[at])])


def motion(rig: Rig, run: Run, values: dict[str, float]) -> Motion | None:
    """Motion with these values, None where they are impossible or the motion cannot be followed."""
    try:
        found = simulate(rig.with_values(values), run)
    except MetrologyError:
        return None
    return found if found.status == "ok" else None


def beside_contact(measured: MeasuredRun, moved: Motion, least: float = BESIDE[1]) -> Marks:
    """Tension readings beside a change of contact, which jump with every parameter.

    A reading that the clock stamps a fraction of a sample early shows the other side of the jump: no standard
    uncertainty of the reading covers that.
    """
    stamps = measured.stamps("T")
    beside = np.zeros(stamps.shape, dtype=bool)
    step = float(np.median(np.diff(stamps))) if stamps.size > 1 else 0.0
    distance = max(BESIDE[0] * step, least)
    for event in moved.events:
        if event.kind in CONTACT:
            first, last = np.searchsorted(stamps, (event.t - distance, event.t + distance))
            beside[first:last] = True
    return beside


def masks(rig: Rig, runs: Sequence[MeasuredRun], layout: Layout, theta: Array, view: View) -> list[Mask] | None:
    """Readings to use, run by run and channel by channel, at these values; None where a motion has no answer."""
    found = []
    for at, measured in enumerate(runs):
        use = {name: measured.used(name) & (measured.stamps(name) <= view.until) for name in measured.channels}
        if "T" in use and view.smooth and len(use) > 1:
            use["T"] = np.zeros_like(use["T"])
        elif "T" in use:
            moved = motion(rig, measured.run, values_of(layout, at, theta))
            if moved is None:
                return None
            use["T"] = use["T"] & ~beside_contact(measured, moved, view.beside)
        found.append(use)
    return found


def problem(rig: Rig, runs: Sequence[MeasuredRun], layout: Layout, use: Sequence[Mask], view: View) -> Problem:
    """Joint problem of all runs."""
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
        found: Array = (read - np.concatenate([getattr(moved, name) for name in channels])) * weight
        return found

    def derivatives(local: Array) -> Array | None:
        found = differences(rig, seen, layout.names, layout.values(at, local))
        if found is None:
            return None
        rows = [np.concatenate([part[name] for name in channels]) for part in found]
        slopes = np.empty((len(weight), len(layout.targets[at])))
        for column, target in enumerate(layout.targets[at]):
            np.multiply(rows[target], -weight, out=slopes[:, column])
        return slopes

    log_u = float(-np.log(positive).sum() + 0.5 * positive.size * math.log(2 * math.pi))
    return Block(
        measured.name, layout.uses[at], residuals, derivatives, tuple(segments), count=positive.size, log_u=log_u
    )


def differences(rig: Rig, run: Run, names: Sequence[str], values: dict[str, float]) -> list[dict[str, Array]] | None:
    """Derivatives of every channel by each parameter; None where the motion has no answer.

    Where the motion is exact to rounding, central differences of second order over a step so short that their error is
    1e-5 of the derivative, at half the motions of the fourth-order ones that serve everywhere else.
    """
    try:
        here = rig.with_values(values)
        centre = np.array([here.value(name) for name in names])
        steps = np.array([_step(name, value) for name, value in zip(names, centre, strict=True)])
        if not _exact(here, names) or not _inside(names, centre, steps):
            found = jacobian(here, run, names)
            channels = {name: getattr(found, name) for name in CHANNELS if getattr(found, name) is not None}
            rows = [{name: part[:, at] for name, part in channels.items()} for at in range(len(names))]
            return rows if found.valid else None
        moved = simulate_many(here, run, names, np.concatenate([centre + np.diag(steps), centre - np.diag(steps)]))
    except MetrologyError:
        return None
    if not moved.valid.all():
        return None
    channels = {name: getattr(moved, name) for name in CHANNELS if getattr(moved, name) is not None}
    return [
        {name: (part[at] - part[at + len(names)]) * (0.5 / steps[at]) for name, part in channels.items()}
        for at in range(len(names))
    ]


def _step(name: str, value: float) -> float:
    return 1e-5 * abs(value) if name in ("m", "k", "c") and value else 2e-3 * PARAMETERS[name].scale


def _exact(rig: Rig, names: Sequence[str]) -> bool:
    """Whether the motion is linear between events: no nonlinear effect acts or varies, and the line has no weight."""
    acting = {name.split(".")[0] for name in (*rig.effects, *names)}
    return rig.line_weight == "none" and all(effect.linear for effect in EFFECTS if effect.name in acting)


def _inside(names: Sequence[str], centre: Array, steps: Array) -> bool:
    low = np.array([PARAMETERS[name].low for name in names])
    high = np.array([PARAMETERS[name].high for name in names])
    return bool(((centre - steps >= low) & (centre + steps <= high)).all())


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
