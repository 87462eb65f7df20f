"""Records of a testing machine, drawn by equations of their own: what is read of a bar that is pulled, and what is off.

Shares no code with the package.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Machine:
    """A bar of stiffness EA over a free length and a gauge length, in a set-up that gives way; SI."""

    EA: float = 2.0e6
    length: float = 0.10
    gauge: float = 0.05
    compliance: float = 2.0e-8
    most: float = 4000.0
    count: int = 1200
    rate: float = 20.0
    force_noise: float = 1.0
    strain_noise: float = 2.0e-6
    crosshead_noise: float = 5.0e-7
    memory: float = 0.6
    white: float = 0.3
    crosshead_division: float = 0.0
    strain_division: float = 0.0
    toe: float = 0.0
    toe_force: float = 200.0
    slack: float = 0.0
    softening: float = 0.0
    slip: float = 0.0
    slip_at: float = 0.5
    backlash: float = 0.0
    extensometer_slip: float = 0.0
    extensometer_toe: float = 0.0
    creep: float = 0.0
    creep_time: float = 10.0
    breaks: bool = False
    cycles: int = 0
    more: dict[str, float] = field(default_factory=dict)


def noise(rng: np.random.Generator, count: int, memory: float, white: float) -> np.ndarray:
    """Noise of unit variance: a part that is white, the rest an autoregression of first order, by its recursion."""
    found, value = np.empty(count), rng.normal()
    steps = rng.normal(size=count)
    for at in range(count):
        value = memory * value + np.sqrt(1 - memory**2) * steps[at]
        found[at] = value
    return np.sqrt(1 - white) * found + np.sqrt(white) * rng.normal(size=count)


def path(one: Machine) -> np.ndarray:
    """Force over time: a ramp, or cycles up and down with the last one to the top."""
    if not one.cycles:
        return one.most * (np.arange(one.count) + 1.0) / one.count
    legs = 2 * one.cycles + 1
    at = np.arange(one.count) / one.count * legs
    up = at - np.floor(at)
    return one.most * np.where(np.floor(at) % 2 == 0, up, 1 - up)


def pull(one: Machine, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Readings of time, force, crosshead and strain of one mounting."""
    force, t = path(one), np.arange(one.count) / one.rate
    part = force / one.most
    strain = force / one.EA * (1 + one.softening * part) + one.toe * (1 - np.exp(-force / one.toe_force))
    if one.creep:
        # Boltzmann's superposition of a logarithmic creep, step by step
        steps = np.diff(force, prepend=0.0)
        strain = strain + one.creep / one.EA * np.array(
            [(steps[: at + 1] * np.log1p((t[at] - t[: at + 1]) / one.creep_time)).sum() for at in range(one.count)]
        )
    late = np.arange(one.count) > one.slip_at * one.count
    crosshead = strain * one.length + one.compliance * force + one.slack * (1 - np.exp(-force / one.toe_force))
    crosshead = crosshead + one.slip * late
    if one.backlash:
        falling = np.diff(force, prepend=force[0]) < 0
        crosshead = crosshead + one.backlash * falling
    read = strain + one.extensometer_slip * late + one.extensometer_toe * (1 - np.exp(-force / one.toe_force))
    found = {
        "time": t,
        "force": force + one.force_noise * noise(rng, one.count, 0.0, 0.0),
        "crosshead": crosshead + one.crosshead_noise * noise(rng, one.count, one.memory, one.white),
        "strain": read + one.strain_noise * noise(rng, one.count, one.memory, one.white),
    }
    if one.breaks:
        found["force"][-3:] = 0.05 * one.most
        found["crosshead"][-3:] += 2e-4
    for name, division in (("crosshead", one.crosshead_division), ("strain", one.strain_division)):
        if division:
            found[name] = np.round(found[name] / division) * division
    return found
