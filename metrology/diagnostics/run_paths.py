"""Where a run goes by the model: short steps of force, and what a law may depend on at places within each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from metrology.diagnostics.subject import Array
from metrology.estimation import MeasuredRun
from metrology.estimation.response import motion
from metrology.rig import UNREAD, Rig, Run

FINE = 40
"""Steps of force in one natural period."""
WITHIN = 8
"""Places of the motion within each, over which a force is averaged: a line comes taut in the midst of a step."""


@dataclass(frozen=True)
class Path:
    """Where one run goes by the model: short steps of force, and what it may depend on at places within each.

    `edges`: when each step begins. `read`: what a pull of the line depends on at each reading of tension; `cell`: what
    the cell makes of a newton. NaN where the line is slack.
    """

    edges: Array
    by: Mapping[str, Array]
    readings: Array
    read: Mapping[str, Array]
    cell: float


def path_of(rig: Rig, measured: MeasuredRun, values: dict[str, float]) -> Path | None:
    """Where a run goes with these values; None where its motion cannot be followed."""
    run, here = measured.run, rig.with_values(values)
    step = 2 * math.pi * math.sqrt(here.m / max(here.k, 1e-12)) / FINE
    begun = run.t0 if run.held_until is None else run.held_until
    count = int(np.clip((run.end - begun) / step, 50, 4000))
    edges = np.linspace(begun, run.end, count + 1)[:-1]
    within = (edges[1] - edges[0]) * (np.arange(WITHIN) + 0.5) / WITHIN
    places = (edges[:, None] + within).ravel()
    unread = {name: null for name, null in UNREAD.items() if name in values or name in rig.effects}
    whole = motion(rig, run, values)
    moved = _followed(rig, run, {**values, **unread}, places)
    if moved is None or whole is None:
        return None
    stamps = np.empty(0) if run.t_T is None else np.maximum(run.t_T - here.value("clock.T"), run.t0)
    read = _followed(rig, run, {**values, **unread}, stamps) if len(stamps) else {}
    if read is None:
        return None
    readings = np.concatenate([getattr(whole, name) for name in measured.channels])
    return Path(edges, {**moved, "t": places - run.t0}, readings, read, here.value("cell.gain") or 1.0)


def _followed(rig: Rig, run: Run, values: dict[str, float], t: Array) -> dict[str, Array] | None:
    """Position and velocity of the module, elongation and its rate at some times; these where the line is taut."""
    # Stamps before the start of a run stand at it, several of them where a clock is late.
    stamps, places = np.unique(t, return_inverse=True)
    moved = motion(rig, replace(run, t_x=stamps, t_v=stamps, t_T=stamps), values)
    if moved is None or moved.x is None or moved.v is None or moved.T is None:
        return None
    elongation = moved.x - rig.taut - values.get("free_length.shift", rig.value("free_length.shift"))
    taut = moved.T > 0 if rig.attachment == "tether" else np.ones(len(stamps), dtype=bool)
    e, r = (np.where(taut, one, np.nan) for one in (elongation, moved.v))
    return {name: one[places] for name, one in (("x", moved.x), ("v", moved.v), ("e", e), ("r", r))}


def stepped(path: Path, forces: Array) -> Array:
    """Mean over each step of forces at the places within, shape (places, q) → (steps, q)."""
    return np.asarray(forces.reshape(len(path.edges), WITHIN, -1).mean(axis=1))
