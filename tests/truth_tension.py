"""Records of a testing machine, drawn by equations of their own: what is read of a bar that is pulled, and what is off.

Shares no code with the package.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

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
    delayed: float = 0.0
    delayed_time: float = 6.0
    breaks: bool = False
    cycles: int = 0
    grows: bool = False
    hold: float = 0.0
    bedding: float = 0.0
    mullins: float = 0.0
    drift: float = 0.0
    tails: bool = False
    plastic: float = 0.0
    yield_at: float = 0.6
    section: float = 0.0
    warming: float = 0.0
    warming_time: float = 15.0
    expansion: float = 1.2e-5
    heat_softening: float = 3e-4
    extensometer_scale: float = 0.0
    exponent: float = 0.0
    ripple: float = 0.0
    ripple_period: float = 2.3e-4
    wobble: float = 0.0
    wobble_period: float = 6e-5
    sticking: float = 0.0


def noise(rng: np.random.Generator, count: int, memory: float, white: float, *, tails: bool = False) -> np.ndarray:
    """Noise of unit variance: a part that is white, the rest an autoregression of first order, by its recursion.

    `tails`: its steps are Student's with four degrees of freedom.
    """
    found, value = np.empty(count), rng.normal()
    steps = rng.standard_t(4, size=count) / np.sqrt(2) if tails else rng.normal(size=count)
    for at in range(count):
        value = memory * value + np.sqrt(1 - memory**2) * steps[at]
        found[at] = value
    return np.sqrt(1 - white) * found + np.sqrt(white) * rng.normal(size=count)


def path(one: Machine) -> np.ndarray:
    """Force over time: a ramp, or cycles up and down with the last one to the top; their peaks may grow.

    Each way up ends with a hold at its peak, for a part `hold` of its time.
    """
    if not one.cycles:
        return one.most * (np.arange(one.count) + 1.0) / one.count
    legs = 2 * one.cycles + 1
    at = np.arange(one.count) / one.count * legs
    leg = np.floor(at)
    up = at - leg
    up = np.where(leg % 2 == 0, np.minimum(up / (1 - one.hold), 1.0), up)
    peak = (leg // 2 + 1) / (one.cycles + 1) if one.grows else 1.0
    return one.most * peak * np.where(leg % 2 == 0, up, 1 - up)


def flow(one: Machine, force: np.ndarray) -> np.ndarray:
    """Plastic strain, increment by increment: where the force passes the yield force, which hardens with it."""
    found, limit, strain = np.zeros(len(force)), one.yield_at * one.most, 0.0
    for at, pulls in enumerate(force):
        if pulls > limit:
            strain += one.plastic * (pulls - limit) / one.EA
            limit = pulls
        found[at] = strain
    return found


def followed(values: np.ndarray, time: float) -> np.ndarray:
    """What follows values at a rate of its distance over a time, in readings; straight between readings, exactly."""
    share, found = np.exp(-1.0 / time), np.zeros(len(values))
    for at in range(1, len(values)):
        slope = values[at] - values[at - 1]
        behind = values[at - 1] - slope * time
        found[at] = behind + slope + (found[at - 1] - behind) * share
    return found


def stuck(values: np.ndarray, play: float) -> np.ndarray:
    """What follows values with a play: it stands still until they are off by more than half of it."""
    found, here = np.empty(len(values)), values[0]
    for at, value in enumerate(values):
        here = min(max(here, value - play / 2), value + play / 2)
        found[at] = here
    return found


def warmed(one: Machine) -> np.ndarray:
    """Temperature / K of a bar that was put into surroundings which are warmer by `warming`, step by step."""
    found, warm, step = np.zeros(one.count), 0.0, 1.0 / one.rate / 20
    for at in range(one.count):
        found[at] = warm
        for _ in range(20):
            warm += step / one.warming_time * (one.warming - warm)
    return found


def pull(one: Machine, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Readings of time, force, crosshead and strain of one mounting."""
    force, t = path(one), np.arange(one.count) / one.rate
    part = force / one.most
    late = np.arange(one.count) > one.slip_at * one.count
    warm = warmed(one)
    # A power of the rate, over that of 20 readings a second; what is left of the section; what warmth softens.
    stiffness = one.EA * (one.rate / 20.0) ** one.exponent * (1 - one.section * late) * (1 - one.heat_softening * warm)
    strain = force / stiffness * (1 + one.softening * part) + one.toe * (1 - np.exp(-force / one.toe_force))
    strain = strain + flow(one, force) + one.expansion * warm
    highest = np.maximum.accumulate(force)
    strain = strain + (one.bedding * highest + one.mullins * force * (highest - force) / one.most) / one.EA
    if one.creep:
        # Boltzmann's superposition of a logarithmic creep, step by step
        steps = np.diff(force, prepend=0.0)
        strain = strain + one.creep / one.EA * np.array(
            [(steps[: at + 1] * np.log1p((t[at] - t[: at + 1]) / one.creep_time)).sum() for at in range(one.count)]
        )
    if one.delayed:
        strain = strain + one.delayed / one.EA * followed(force, one.delayed_time * one.rate)
    crosshead = strain * one.length + one.compliance * force + one.slack * (1 - np.exp(-force / one.toe_force))
    crosshead = crosshead + one.slip * late
    if one.backlash:
        falling = np.diff(force, prepend=force[0]) < 0
        crosshead = crosshead + one.backlash * falling
    # A screw or a scale with an error that comes again every turn; an extensometer whose edges stick.
    crosshead = crosshead + one.wobble * np.sin(2 * np.pi * crosshead / one.wobble_period)
    strain = stuck(strain, one.sticking) + one.ripple * np.sin(2 * np.pi * strain / one.ripple_period)
    settled = 1 - np.exp(-force / one.toe_force)
    read = strain * (1 + one.extensometer_scale) + one.extensometer_slip * late + one.extensometer_toe * settled
    found = {
        "time": t,
        "force": force + one.drift * t + one.force_noise * noise(rng, one.count, 0.0, 0.0),
        "crosshead": crosshead + one.crosshead_noise * noise(rng, one.count, one.memory, one.white, tails=one.tails),
        "strain": read + one.strain_noise * noise(rng, one.count, one.memory, one.white, tails=one.tails),
    }
    if one.breaks:
        found["force"][-3:] = 0.05 * one.most
        found["crosshead"][-3:] += 2e-4
    for name, division in (("crosshead", one.crosshead_division), ("strain", one.strain_division)):
        if division:
            found[name] = np.round(found[name] / division) * division
    return found


def distance(one: Machine, other: Machine, low: float, high: float) -> float:
    """Standard deviations by which the readings of two machines differ beyond what zeros, k and C of a record take.

    Of readings between two parts of the largest force.

    The noise counts with its power at the lowest frequencies, where these effects live.
    """
    quiet = dict.fromkeys(
        ("force_noise", "strain_noise", "crosshead_noise", "strain_division", "crosshead_division"), 0.0
    )
    rng = np.random.default_rng(0)
    here, there = (pull(replace(machine, **quiet), rng) for machine in (one, other))
    slow = np.sqrt((1 - one.white) * (1 + one.memory) / (1 - one.memory) + one.white)
    u = slow * np.array([one.crosshead_noise, one.length * one.strain_noise])
    F = path(one)
    # What the cell reads beside the force is a stretch that is not there.
    lost = (there["force"] - here["force"]) / one.EA * one.length
    change = np.concatenate([(there["crosshead"] - here["crosshead"] - lost) / u[0],
                             (one.length * (there["strain"] - here["strain"]) - lost) / u[1]])  # fmt: skip
    ones, none = np.ones(one.count), np.zeros(one.count)
    seen = np.tile(np.abs(F / one.most - (low + high) / 2) < (high - low) / 2, 2)
    nuisance = np.array([np.r_[ones / u[0], none], np.r_[none, ones / u[1]], np.r_[F / u[0], F / u[1]],
                         np.r_[F / u[0], none]]).T[seen]  # fmt: skip
    change = change[seen]
    return float(np.linalg.norm(change - nuisance @ np.linalg.lstsq(nuisance, change, rcond=None)[0]))
