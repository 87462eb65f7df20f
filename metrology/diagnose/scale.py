"""What a motion suggests: sizes of thrust, elongation and speed, and from them shapes, first amounts and limits."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence

import numpy as np

from metrology.identify import MeasuredRun
from metrology.identify.response import motion
from metrology.rig import Motion, Rig

QUICK = 400.0
"""Angular frequency / (rad/s) from which on no second mode is tried: it follows the line then as one without mass."""

ABOVE = 1.3
"""Frequency over that of the rig from which on a second mode is tried as a frame, below it as a yaw."""

RINGS = 0.03
"""Damping ratio at which a second mode is tried."""


def scales(rig: Rig, runs: Sequence[MeasuredRun]) -> dict[str, float]:
    """Sizes of a motion and of its rig, SI.

    Thrust, elongation, speed; natural and highest visible angular frequency; longest time from one loss of contact to
    the next contact, at least a period; k, c, m, weight of the line, moment of inertia.
    """
    pushes = [np.abs(run.run.force.values).max() for run in runs if run.run.force is not None]
    omega = math.sqrt(max(rig.k, 1e-12) / rig.m)
    length, speed, gaps = [], [], [2 * math.pi / omega]
    for run in runs:
        moved = motion(rig, run.run, {})
        if moved is not None and moved.x is not None:
            away = float(np.max(moved.x - rig.taut))
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


def limits(known: Mapping[str, float]) -> dict[str, tuple[float, float]]:
    """Ranges that make sense for this motion: beyond them an effect is another one, or none."""
    e, omega, k, highest = (known[name] for name in ("e", "omega", "k", "highest"))
    return {
        "hysteresis.yield": (0.01 * e, 3 * e), "hysteresis.stiffness": (0.0, 3 * k), "zener.stiffness": (0.0, 5 * k),
        "zener.time": (0.02 / omega, 100 / omega), "frame.compliance": (0.0, 3 / k),
        "frame.frequency": (1.1 * omega, max(min(QUICK, 30 * omega), highest, 1.2 * omega)),
        "frame.damping": (0.0, 0.5), "yaw.damping": (0.0, 0.5),
        "toe.extent": (0.01 * e, 1.5 * e), "yaw.frequency": (0.1 * omega, 10 * omega),
        "yaw.arm": (0.0, 3 * math.sqrt(known["inertia"] / known["m"])),
        "hum.frequency": (0.1, highest / (1.6 * math.pi)),  # half the highest rate, in Hz
        "drag.quadratic": (0.0, 10 * known["force"] / known["v"] ** 2),
        "drag.viscous": (0.0, 10 * known["force"] / known["v"]),
    }  # fmt: skip


def _spread(low: float, high: float, count: int) -> list[float]:
    """Numbers in equal ratios."""
    found: list[float] = np.geomspace(low, high, count).tolist()
    return found


def _modes(low: float, high: float, known: Mapping[str, float]) -> list[float]:
    """Angular frequencies of a second mode, so close that one of them leads to the right one.

    A quarter of a turn apart from one contact to the next, or as far as its resonance is wide.
    """
    found = [low]
    while found[-1] < min(high, QUICK):
        found.append(found[-1] + max(math.pi / (2 * known["gap"]), 2 * RINGS * found[-1]))
    return found[:-1]


def shapes(name: str, known: Mapping[str, float], among: Container[str]) -> list[dict[str, float]]:
    """Shapes in which one among several candidates is tried, spread over what this motion can tell apart."""
    omega, e = known["omega"], known["e"]
    slow = ABOVE if "frame" in among else 5.0
    table = {
        "frame": [
            {"frame.frequency": one, "frame.damping": RINGS} for one in _modes(ABOVE * omega, 30.0 * omega, known)
        ],
        "toe": [{"toe.extent": part * e} for part in (0.08, 0.15, 0.25, 0.4, 0.6)],
        "zener": [{"zener.time": factor / omega} for factor in _spread(0.1, 30.0, 8)],
        "hysteresis": [{"hysteresis.yield": part * e} for part in (0.03, 0.06, 0.12, 0.25, 0.5)],
        "yaw": [{"yaw.frequency": one, "yaw.damping": RINGS} for one in _modes(0.25 * omega, slow * omega, known)],
    }
    return table.get(name, [{}])


def guess(size: str, known: Mapping[str, float]) -> float:
    """First trial size of an effect, small against the motion."""
    force, e, v, omega, k = (known[name] for name in ("force", "e", "v", "omega", "k"))
    guesses = {
        "friction.force": 0.005 * force, "drag.viscous": 0.005 * force / v, "drag.quadratic": 0.005 * force / v**2,
        "tilt.angle": 0.003 * force / (9.8 * known["m"]), "setup.compliance": 0.01 / max(k, 1.0),
        "frame.compliance": 0.02 / max(k, 1.0), "cubic.stiffness": 0.02 * k / e**2, "toe.ratio": -0.05,
        "zener.stiffness": 0.02 * k, "damping.amplitude": 0.1 * max(known["c"], 0.01 * k / omega) / e,
        "hysteresis.stiffness": 0.01 * k, "sag.weight": known["weight"] or 1e-4, "slip.set": 0.005 * e,
        "yaw.arm": 0.1 * math.sqrt(known["inertia"] / known["m"]),
        "thrust.lag": 2e-3, "thrust.gain": 3e-3, "thrust.delay": 2e-3, "mass.factor": 3e-3, "free_length.shift": 3e-4,
        "cell.gain": 3e-3, "cell.zero": 1e-3 * force, "cell.drift": 1e-5 * force, "motion.scale": 3e-3,
        "clock.x": 5e-4, "clock.v": 5e-4, "clock.T": 5e-4,
    }  # fmt: skip
    return guesses[size]
