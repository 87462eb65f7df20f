"""A measured run: readings of its channels beside what the lab states about it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np

from metrology.coordinate import Coordinate
from metrology.errors import Fault, MetrologyError
from metrology.estimation.noise import estimate
from metrology.estimation.problem import Array, Marks
from metrology.rig import CHANNELS, Run
from metrology.rig.parameters import CHANNEL_UNITS


@dataclass(frozen=True)
class MeasuredRun:
    """Readings of one run.

    Parameters
    ----------
    name : str
        Of the run.
    run : rig.Run
        Stated start state and thrust, and the time stamps of every channel.
    x, v, T : array_like or None
        Readings / m, m/s, N (rad, rad/s, N·m for an angle) at the stamps of `run`; NaN where there is a gap. None
        exactly where `run` has no stamps.
    noise : mapping of str to float
        Standard uncertainty of one reading by channel; estimated from the readings for a channel that is left out.
    use : mapping of str to array of bool
        Readings to use by channel; all unless given.
    purpose : {'identification', 'verification'}
        Whether the run goes into the fit or judges it.
    coordinate : {'position', 'angle'}
        What x is.

    Raises
    ------
    MetrologyError
        With all faults: lengths that differ from the stamps, a channel that is all gaps or infinite, noise that is not
        positive or cannot be estimated.
    """

    name: str
    run: Run
    x: Array | None = None
    v: Array | None = None
    T: Array | None = None
    noise: Mapping[str, float] = field(default_factory=dict)
    use: Mapping[str, Marks] = field(default_factory=dict)
    purpose: Literal["identification", "verification"] = "identification"
    coordinate: Coordinate = "position"

    def __post_init__(self) -> None:
        faults: list[Fault] = []
        for channel in CHANNELS:
            faults += _adopt(self, channel)
        faults += _adopt_masks(self)
        unknown = set(self.noise) - set(CHANNELS)
        faults += [Fault(f"{self.name}.noise.{name}", f"'{name}'", "one of x, v, T") for name in sorted(unknown)]
        if not faults:
            faults += _adopt_noise(self)
        if faults:
            raise MetrologyError(*faults)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that were measured."""
        return tuple(name for name in CHANNELS if getattr(self, name) is not None)

    def unit(self, channel: str) -> str:
        """SI unit of a channel."""
        return CHANNEL_UNITS[self.coordinate][channel]

    def stamps(self, channel: str) -> Array:
        """Time stamps of a channel / s."""
        stamps: Array = getattr(self.run, f"t_{channel}")
        return stamps

    def readings(self, channel: str) -> Array:
        """Readings of a channel."""
        readings: Array = getattr(self, channel)
        return readings

    @property
    def weights(self) -> Array:
        """1/u of every reading, channel after channel."""
        return np.concatenate([np.full(len(self.stamps(name)), 1.0 / self.noise[name]) for name in self.channels])

    def used(self, channel: str) -> Marks:
        """Readings with weight: finite, and not left out."""
        used: Marks = np.isfinite(self.readings(channel)) & self.use.get(channel, np.True_)
        return used


def _adopt(measured: MeasuredRun, channel: str) -> list[Fault]:
    stamps, given = getattr(measured.run, f"t_{channel}"), getattr(measured, channel)
    where = f"{measured.name}.{channel}"
    if given is None and stamps is None:
        return []
    if given is None:
        return [Fault(where, "time stamps without readings", "readings at those stamps, or neither")]
    if stamps is None:
        return [Fault(where, "readings without time stamps", f"stamps in run.t_{channel}")]
    readings = np.array(given, dtype=float, ndmin=1)
    readings.setflags(write=False)
    object.__setattr__(measured, channel, readings)
    if readings.shape != stamps.shape:
        return [Fault(where, f"{readings.size} readings", f"{stamps.size}, one for each time stamp")]
    if np.isinf(readings).any():
        at = int(np.flatnonzero(np.isinf(readings))[0])
        return [Fault(f"{where}[{at}]", f"{readings[at]}", "a finite reading", "leave a gap (NaN) instead")]
    if np.isnan(readings).all():
        return [Fault(where, "a channel that is all gaps", "at least one reading", "leave the channel out")]
    return []


def _adopt_masks(measured: MeasuredRun) -> list[Fault]:
    masks, faults = {}, []
    for channel, given in measured.use.items():
        mask = np.array(given, dtype=bool)
        mask.setflags(write=False)
        masks[channel] = mask
        readings = getattr(measured, channel, None) if channel in CHANNELS else None
        if readings is None or mask.shape != readings.shape:
            faults.append(Fault(f"{measured.name}.use.{channel}", f"{mask.size} marks", "one for each reading"))
    object.__setattr__(measured, "use", MappingProxyType(masks))
    return faults


def _adopt_noise(measured: MeasuredRun) -> list[Fault]:
    """Fill in the noise of every channel, so that it is a plain value from here on."""
    noise, faults = {}, []
    for channel in measured.channels:
        where = f"{measured.name}.noise.{channel}"
        if channel in measured.noise:
            value = float(measured.noise[channel])
            if not (math.isfinite(value) and value > 0):
                faults.append(Fault(where, f"{value:g} {measured.unit(channel)}", "a positive standard uncertainty"))
            noise[channel] = value
            continue
        found = estimate(np.where(measured.used(channel), measured.readings(channel), np.nan))
        if found is None or found.u == 0:
            faults.append(Fault(where, "readings that show no noise", "the noise stated, such as 2e-4 m"))
            continue
        noise[channel] = found.u
    object.__setattr__(measured, "noise", MappingProxyType(noise))
    return faults
