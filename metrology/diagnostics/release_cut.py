"""From a separated release to the record that is fitted, and a record in parts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from metrology.coordinate import SENSED
from metrology.decay.hop import Hop
from metrology.decay.modes import guard, is_mains
from metrology.decay.separated import Separated, drift
from metrology.diagnostics.release import HARMONICS, LONGEST, PER_PERIOD, Line, Record, node_gap
from metrology.diagnostics.subject import Array, Marks
from metrology.message import said
from metrology.timeseries.spectra import periodogram
from metrology.timeseries.white_noise import quantum, rounding_bias

BESIDE = (2.0, 10.0)
"""Steps of the spectrum from a line between which the noise beside it is looked at: Hann's window lets the line through
up to two, and sixteen values know their median to a third."""


def cut(name: str, parted: Separated, mains: float) -> Record:
    """Cut and average one release; lines that have nothing to do with the decay are taken out before."""
    main, fit, free = parted.fit.main, parted.fit, parted.free
    taken = [at for at in range(1, len(fit.modes)) if _foreign(fit.modes[at].omega, parted)]
    value: Array = free.value
    noise: Array | float = parted.noise
    period = 2 * math.pi / main.omega
    kept = (parted.t >= parted.crossed) & (parted.t <= parted.crossed + LONGEST * period)
    if parted.rounded is not None:
        likely, each = parted.rounded.likely
        value, noise = value + likely - parted.rounded.value, each[kept]  # less the steps that were taken out
    value = value - sum((fit.part(parted.t, at) for at in taken), np.zeros(len(free.value)))
    t, y, u, nodes, weights = _blocks(parted.t[kept], value[kept], noise, period / PER_PERIOD)
    steps = [(one, _blocks(parted.t[kept], (parted.free.time >= one.time)[kept].astype(float), noise,
                           period / PER_PERIOD)[1]) for one in parted.hops]  # fmt: skip
    sensed = SENSED[free.unit]
    zero = nodes.min() - node_gap(sensed, main.omega)
    a, b = fit.coefficients[0]
    pole = complex(-main.rate, main.omega)
    turned = complex(a, -b) * np.exp(pole * zero) / pole**sensed.order
    lines = tuple(
        Line(mode.frequency, float(fit.amplitudes[at]), is_mains(mode, mains), _beside(mode.frequency, parted),
             mode.frequency / max(mode.rate, 1.0 / float(parted.t[-1] - parted.crossed)),
             float(np.mean(np.exp(-2 * mode.rate * parted.t))))
        for at, mode in enumerate(fit.modes) if at in taken
    )  # fmt: skip
    return Record(
        name, sensed, t - zero, y, u, nodes - zero, weights, main.omega, main.rate, float(turned.real),
        float((turned * pole).real), float(np.mean(y[len(y) // 2 :])), lines, parted.noise,
        int(kept.sum()) / len(t), _by_rounding(parted), parted.rounded is not None, _seen(steps),
        _settles(parted, zero),
    )  # fmt: skip


def _settles(parted: Separated, zero: float) -> tuple[float, float]:
    """By how much a record settles from a time on, and its rate."""
    rate = parted.fit.settling
    return (drift(parted).settles * math.exp(-rate * zero), rate) if rate else (0.0, 0.0)


def _by_rounding(parted: Separated) -> float:
    """By what rounding alone the mean of readings at rest is off."""
    of = parted.rounded
    if of is None:
        return rounding_bias(parted.noise, quantum(parted.free))
    return rounding_bias(math.hypot(of.level, of.step / math.sqrt(12)), of.step)


def _seen(steps: Sequence[tuple[Hop, Array]], rows: slice = slice(None)) -> tuple[tuple[Hop, Array], ...]:
    """Steps within some rows of a record: one before them, or after them, is their zero."""
    return tuple((hop, later[rows]) for hop, later in steps if np.ptp(later[rows]) > 0)


def _beside(frequency: float, parted: Separated) -> float:
    """Noise beside a line: that of the readings, or more where the residuals have more there (`BESIDE`).

    A band of noise holds lines by the dozen: against white noise each of them has all the evidence there is.
    """
    f, power = periodogram(parted.t, parted.fit.residual)
    off = np.abs(f - frequency) / f[1]
    beside = power[(off > BESIDE[0]) & (off <= BESIDE[1])]
    # The median of squares of noise is ln 2 of their mean; another line among them does not move it.
    return max(parted.noise, math.sqrt(float(np.median(beside)) / math.log(2)))


def _blocks(t: Array, y: Array, noise: Array | float, width: float) -> tuple[Array, ...]:
    """Means over blocks of as many samples as span `width` / s, none across a gap, with nodes and weights of each.

    `noise`: standard deviation of the readings; where each has its own, the means are weighted by 1/u².
    """
    steps = np.diff(t)
    step = float(np.median(steps))
    count = max(1, int(width / step))
    # A new block after so many samples, and after a gap.
    number = np.concatenate([[0], np.cumsum(np.where(steps > 1.5 * step, count, 1))])
    number = np.cumsum(np.concatenate([[0], np.diff(number // count) > 0]))
    usual = float(np.median(noise))
    share = (usual / np.broadcast_to(noise, t.shape)) ** 2
    size = np.bincount(number, share)
    mean = np.bincount(number, share * t) / size
    apart = t - mean[number]
    second, third, fourth = (np.bincount(number, share * apart**power) / size for power in (2, 3, 4))
    spread = np.maximum(second, 1e-300)
    lean = third / spread
    # Three times for the fourth power as well; between readings of unlike weight two, which lie among them.
    wide = spread if np.ndim(noise) else np.maximum(fourth - lean * third, 0.0) / spread
    half = np.sqrt(0.25 * lean**2 + wide)
    low, high = 0.5 * lean - half, 0.5 * lean + half
    if np.ndim(noise):
        before, after = high / (high - low), -low / (high - low)
    else:
        before, after = (np.where(second > 0, second / np.where(second > 0, one * (one - other), 1.0), 0.0)
                         for one, other in ((low, high), (high, low)))  # fmt: skip
    nodes, weights = np.array([mean + low, mean, mean + high]), np.array([before, 1 - before - after, after])
    return mean, np.bincount(number, share * y) / size, usual / np.sqrt(size), nodes, weights


def parts(one: Record) -> list[Record]:
    """First and later part of a single release, so that each can be predicted from the other."""
    at = int(np.searchsorted(one.t, min(0.5 * one.t[-1], 0.7 / max(one.rate, 1e-12))))
    if min(at, len(one.t) - at) < 3 * PER_PERIOD:
        return [one]
    zero = float(one.nodes[0, at]) - node_gap(one.sensed, one.omega)
    pole, (size, settling) = complex(-one.rate, one.omega), one.settles
    turned = complex(one.x0, -(one.v0 + one.rate * one.x0) / one.omega) * np.exp(pole * zero)
    first, later = slice(None, at), slice(at, None)
    return [
        replace(
            one, name=said("{record}, first part", record=one.name), t=one.t[first], y=one.y[first], u=one.u[first],
            nodes=one.nodes[:, first], weights=one.weights[:, first], steps=_seen(one.steps, first),
        ),
        replace(
            one, name=said("{record}, later part", record=one.name), t=one.t[later] - zero, y=one.y[later],
            u=one.u[later],
            nodes=one.nodes[:, later] - zero, weights=one.weights[:, later], x0=float(turned.real),
            v0=float((turned * pole).real), steps=_seen(one.steps, later),
            settles=(size * math.exp(-settling * zero), settling),
        ),
    ]  # fmt: skip


def _foreign(omega: float, parted: Separated) -> bool:
    """Whether a line is none that the decay itself makes: near its frequency as that moves, or near a multiple."""
    main = parted.fit.main
    order = max(1, round(omega / main.omega))
    width = (0.2 if order == 1 else 0.04) * main.omega + guard(main, float(parted.t[-1]) - parted.crossed)
    return order > HARMONICS or abs(omega - order * main.omega) > width


def phases(t: Array) -> list[tuple[str, Marks]]:
    """Early and late decay, with the marks of their readings."""
    middle = 0.4 * float(t[-1])
    return [(said("early decay"), t < middle), (said("late decay"), t >= middle)]
