"""A record taken apart: its free motion, fit and drifting zero, and what of it was left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from metrology.decay.hop import Hop
from metrology.decay.jump import Jump
from metrology.decay.modes import is_mains
from metrology.decay.oscillation import Fit, Floats
from metrology.decay.rounding import Rounded
from metrology.decay.settling import Baseline
from metrology.decay.start import Unusable
from metrology.message import counted, said
from metrology.timeseries import Channel

if TYPE_CHECKING:
    from metrology.decay.test import DecayTest


@dataclass(frozen=True)
class Separated:
    """A record taken apart: `free`, what follows the release at time `release` (s), and the fit at its full rate.

    `outliers`: times (s) of readings after the release that were masked; `crossed`: time (s) from the first sample to
    the first crossing of the rest position; `hops`: steps of the reading that were taken out; `rest`: time from which
    on nothing moves, where that is before the middle. `rounded`: what the readings say, where a coarse instrument
    rounded them; `free` is then less the error that rounding is expected to make. `jumps`: moments at which the
    oscillation jumps; what tells less of the decay, before each or after it, was left out.
    """

    free: Channel
    fit: Fit
    release: float
    noise: float
    outliers: tuple[float, ...] = ()
    crossed: float = 0.0
    hops: tuple[Hop, ...] = ()
    rest: float | None = None
    rounded: Rounded | None = None
    jumps: tuple[Jump, ...] = ()

    @property
    def t(self) -> Floats:
        """Times of `free` in s, from its first sample."""
        t: Floats = self.free.time - self.free.time[0]
        return t

    def describe(self, mains: float) -> str:
        """Say what was found together with the longitudinal mode."""
        unit = f"µ{self.free.unit}"
        modes = tuple(
            said(
                "{frequency:.4g} Hz (mains) of {size:.2g} {unit}"
                if is_mains(mode, mains)
                else "{frequency:.4g} Hz of {size:.2g} {unit}",
                frequency=float(mode.frequency),
                size=float(1e6 * size),
                unit=unit,
            )
            for mode, size in self.fit.others
        )
        found = [said("{texts:comma}", texts=modes) if modes else said("no other oscillation")]
        if self.outliers:
            found.append(counted("{count} outlier masked", "{count} outliers masked", len(self.outliers)))
        for one in self.hops:
            text = "a step of {size:.3g} {unit} at {time:.4g} s taken out"
            found.append(said(text, size=float(1e6 * one.size), unit=unit, time=float(one.time)))
        if self.fit.settling:
            text = "a zero that settles by {size:.3g} {unit} with a time constant of {time:.3g} s"
            size = 1e6 * drift(self).settles
            found.append(said(text, size=float(size), unit=unit, time=float(1 / self.fit.settling)))
        for jump in self.jumps:
            text = (
                "what comes before {time:.4g} s left out, where the oscillation jumps"
                if jump.keeps_later
                else "what comes after {time:.4g} s left out, where the oscillation jumps"
            )
            found.append(said(text, time=float(jump.time)))
        if self.rest is not None:
            found.append(said("at rest from {time:.4g} s on", time=float(self.rest)))
        return found[0] if len(found) == 1 else said("{texts}", texts=tuple(found))


def on_even_steps(separated: Separated) -> Separated:
    """Return the same on even steps, as a filter needs, what is missing filled with the fit, which has not seen it.

    Raises
    ------
    Unusable
        Where the stamps stand on no grid, or more than a tenth of the record is missing.
    """
    free, fitted = separated.free, separated.fit
    if free.is_even:
        return separated
    places = np.round((free.time - free.time[0]) / free.step).astype(int)
    step = float((free.time[-1] - free.time[0]) / places[-1])
    t = step * np.arange(places[-1] + 1)
    off = np.abs(free.time - free.time[0] - t[places]).max()
    if off > 0.05 * step or np.unique(places).size < places.size or t.size > places.size / 0.9:
        text = "The record has no even steps, or misses more than a tenth of them: it cannot be filtered."
        raise Unusable(said(text))
    value = drift(separated)(t) + sum(fitted.part(t, i) for i in range(len(fitted.modes)))
    residual = np.zeros(t.size)
    value[places], residual[places] = free.value, fitted.residual
    return replace(
        separated,
        free=replace(free, time=free.time[0] + t, value=value),
        fit=replace(fitted, residual=residual),
    )


def without_others(separated: Separated, record: Channel) -> Floats:
    """Return a record less the fitted baseline and other modes, extended to samples before the first one fitted."""
    fitted, origin = separated.fit, separated.free.time[0]
    t = record.time - origin
    value = record.value.copy()
    for index in range(1, len(fitted.modes)):
        value -= fitted.part(t, index)
    less: Floats = value - drift(separated)(t)
    return less


def drift(separated: Separated) -> Baseline:
    """Fitted zero of a record: what is slower than its oscillations.

    Parameters
    ----------
    separated : Separated
        As fitted.

    Returns
    -------
    Baseline
        Called with times / s from the first sample fitted, in the unit of the readings.
    """
    return baseline(separated.free, separated.fit)


def baseline(free: Channel, fitted: Fit) -> Baseline:
    """Fitted zero of a motion: what is slower than its oscillations, called with times / s from its first sample."""
    t = free.time - free.time[0]
    rest = free.value - fitted.residual - sum(fitted.part(t, i) for i in range(len(fitted.modes)))
    return Baseline.of(t, rest, fitted.settling)


def curvature(separated: Separated) -> float:
    """Return the root mean square of the second derivative of the fitted baseline, m/s²."""
    bend = drift(separated).bend(separated.t)
    return float(np.sqrt(np.mean(bend**2)))


def left_out(test: DecayTest) -> Iterator[str]:
    """Sentences on the parts of the records of a test that are not evaluated.

    Parameters
    ----------
    test : DecayTest
        With its records taken apart.

    Yields
    ------
    str
        A sentence for each jump.
    """
    for record, separated in zip(test.records, test.separated, strict=True):
        for jump in separated.jumps if isinstance(separated, Separated) else ():
            text = (
                "{name}: what comes before {time:.4g} s is not evaluated. The phase jumps there, as by a knock or by "
                "samples that are missing."
                if jump.keeps_later
                else "{name}: what comes after {time:.4g} s is not evaluated. The phase jumps there, as by a knock or "
                "by samples that are missing."
            )
            yield said(text, name=record.name, time=float(jump.time))
