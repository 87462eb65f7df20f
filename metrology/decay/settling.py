"""A zero that settles after the start of a record, as of an amplifier or a sensor that warms up: e^{−λ·t}."""

from __future__ import annotations

from dataclasses import dataclass
from math import log, pi

import numpy as np
from numpy.polynomial import Polynomial

from metrology.decay.hop import CLEAR, level, without_slow
from metrology.decay.modes import disentangle
from metrology.decay.oscillation import DEGREE, Fit, Floats, Mode, baseline, tangent
from metrology.timeseries import Channel

_FINER = 1.5  # ratio of neighbouring rates that are tried
_RESOLVED = 1e-10  # part of e^{−λ·t} beside all that is fitted below which it is rounding


@dataclass(frozen=True)
class Baseline:
    """Zero of a record by the time from its first sample: a polynomial, and what settles by e^{−rate·t}."""

    steady: Polynomial
    settles: float
    rate: float

    @classmethod
    def of(cls, t: Floats, value: Floats, rate: float) -> Baseline:
        """Return the one through values at times; without settling where the rate is 0."""
        if not rate:
            return cls(Polynomial.fit(t, value, DEGREE), 0.0, 0.0)
        columns = np.column_stack([np.polynomial.legendre.legvander(2 * t / t[-1] - 1, DEGREE), np.exp(-rate * t)])
        size = float(np.linalg.lstsq(columns, value, rcond=None)[0][-1])
        return cls(Polynomial.fit(t, value - size * columns[:, -1], DEGREE), size, rate)

    def __call__(self, t: Floats) -> Floats:
        """Zero at times."""
        return np.asarray(self.steady(t) + self.settles * np.exp(-self.rate * t))

    def bend(self, t: Floats) -> Floats:
        """Second derivative by time."""
        return np.asarray(self.steady.deriv(2)(t) + self.settles * self.rate**2 * np.exp(-self.rate * t))


def settled(free: Channel, first: Mode, noise: float) -> Fit:
    """Fit a record by its oscillations, over a zero that settles where that explains more with less.

    Parameters
    ----------
    free : Channel
        Record from the release on.
    first : Mode
        First guess of the longitudinal mode.
    noise : float
        Standard deviation of the readings.

    Returns
    -------
    Fit
        At the full rate of the record; `settling` is 0 where its zero does not settle.
    """
    plain = disentangle(free, first)
    # A motion that itself dies within a period cannot be distinguished from what settles.
    rate = _sought(free, plain, noise) if first.rate < first.frequency else 0.0
    if not rate:
        return plain
    found = disentangle(free, first, rate)
    # The modes that stood for it moved the decay, and the rate with it.
    if again := _sought(free, found, noise):
        found = disentangle(free, first, again)
    fewer = 4 * (len(plain.modes) - len(found.modes)) - 2
    gain = 0.5 * (plain.squares - found.squares) / max(noise**2, found.squares / len(free))
    return found if found.converged and gain + 0.5 * fewer * log(len(free)) > CLEAR else plain


def _sought(free: Channel, fitted: Fit, noise: float) -> float:
    """Rate / (1/s) of the settling that explains most of what is slow in a record; 0 where noise alone may do as much.

    It stands in the place of slow modes, together with the polynomial. Size and rate have the price of unit information
    (½·ln n each). What settles within a period of the decay is a part of its motion.
    """
    from scipy.optimize import minimize_scalar

    t, fast = free.time - free.time[0], without_slow(fitted)
    Q = np.linalg.qr(np.hstack([baseline(t), tangent(t, fast)[:, fast.slow :]]))[0]
    residual = free.value - Q @ (Q.T @ free.value)
    most = log(t[-1] * fast.main.omega / (2 * pi))
    if not most > 0:
        return 0.0

    def shape(rate: float) -> Floats:
        whole = np.exp(-rate * t)
        beside = whole - Q @ (Q.T @ whole)
        length = float(np.linalg.norm(beside))
        return np.asarray(beside / length if length > _RESOLVED * float(np.linalg.norm(whole)) else 0.0 * whole)

    def cost(grown: float) -> float:
        return -abs(float(shape(np.exp(grown) / t[-1]) @ residual))

    tried = np.arange(0.0, most, log(_FINER))
    at = float(tried[int(np.argmin([cost(one) for one in tried]))])
    best = minimize_scalar(cost, bounds=(max(at - log(_FINER), 0.0), min(at + log(_FINER), most)), method="bounded",
                           options={"xatol": 1e-6})  # fmt: skip
    rate = float(np.exp(best.x) / t[-1])
    along = shape(rate)
    size = float(along @ residual)
    variance = level(t, along, residual - size * along, (Q, fast), noise)
    return rate if 0.5 * size**2 / variance - log(len(t)) > CLEAR else 0.0
