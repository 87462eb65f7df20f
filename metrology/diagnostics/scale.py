"""What a motion suggests: sizes of thrust, elongation and speed, by which the causes scale what they try."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from metrology.estimation import MeasuredRun
from metrology.estimation.response import motion
from metrology.rig import Motion, Rig


def scales(rig: Rig, runs: Sequence[MeasuredRun]) -> dict[str, float]:
    """Sizes of a motion and of its rig, SI.

    Thrust, elongation, speed, least and largest position; natural and highest visible angular frequency; longest time
    from one loss of contact to the next contact, at least a period; k, c, m, weight of the line, moment of inertia.
    """
    pushes = [np.abs(run.run.force.values).max() for run in runs if run.run.force is not None]
    omega = math.sqrt(max(rig.k, 1e-12) / rig.m)
    length, speed, gaps = [], [], [2 * math.pi / omega]
    places: list[float] = []
    for run in runs:
        moved = motion(rig, run.run, {})
        if moved is not None and moved.x is not None:
            away = float(np.max(moved.x - rig.taut))
            places += [float(np.min(moved.x)), float(np.max(moved.x))]
            length.append(away if rig.attachment == "tether" else float(np.ptp(moved.x)) / 2)
        if moved is not None and moved.v is not None:
            speed.append(float(np.abs(moved.v).max()))
        if moved is not None:
            gaps += _gaps(moved)
    e = max(max(length, default=1e-3), 1e-6)
    v = max(max(speed, default=e * omega), 1e-9)
    force = max(pushes, default=0.0) or rig.k * e
    rate = max(1 / float(np.median(np.diff(run.stamps(name)))) for run in runs for name in run.channels)
    return {
        "force": float(force), "e": e, "v": v, "omega": omega, "highest": 0.8 * math.pi * rate, "k": rig.k, "c": rig.c,
        "m": rig.m, "weight": rig.weight,
        "least": min(places, default=rig.taut), "most": max(places, default=rig.taut + e),
        "inertia": rig.value("yaw.inertia"), "gap": max(gaps),
    }  # fmt: skip


def _gaps(moved: Motion) -> list[float]:
    """Times from a loss of contact to the next contact."""
    found, lost = [], None
    for event in moved.events:
        if event.kind == "slack":
            lost = event.t
        elif event.kind == "taut" and lost is not None:
            found.append(event.t - lost)
    return found
