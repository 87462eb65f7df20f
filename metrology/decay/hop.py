"""Steps of the reading in a decay, such as lost fringes or a stand that slipped: found, and taken out before a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log, nan, sqrt

import numpy as np
from numpy.polynomial.legendre import legvander

from metrology.decay.oscillation import DEGREE, Fit, baseline, tangent
from metrology.timeseries import Channel, Floats
from metrology.timeseries.spectra import periodogram
from metrology.timeseries.white_noise import quantum, rounding_bias

CLEAR = 5.0
"""Ln of the Bayes factor from which on a step is taken out: 150 to 1, 'very strong' (Kass & Raftery, J. Am. Stat.
Assoc. 90 (1995) 773)."""
SEEN = 0.05
"""Part of a step beside all that is fitted below which it may be anything: next to the ends of a record."""
FEWEST = 6
"""Readings on either side of a step for which it is looked for between them: a cubic and a step leave two each."""
SHARP = 5.0
"""Standard uncertainties by which the step beside all that is fitted may differ from that between its neighbours."""
BESIDE = 5
"""Readings on either side by whose means a jump is seen: a quarter of a period of those that a diagnosis averages."""
GOES_ON = 0.5
"""Part of the fitted decay that has to be there after a step: of what sticks there is none."""
FORMS = (3, 6, 3, 3)
"""Terms, in time, by which the mean of the decay, its amplitude and phase, and those of its multiples may differ from
the fit: what a law of the amplitude does has no step."""


@dataclass(frozen=True)
class Hop:
    """A step: time / s of the first reading after it, its size in the unit of the record, its ln Bayes factor; u."""

    time: float
    size: float
    log_bayes: float
    u: float = nan


def without(record: Channel, hops: Sequence[Hop]) -> Channel:
    """Return a record less its steps."""
    away = sum((one.size * (record.time >= one.time) for one in hops), np.zeros(len(record)))
    return replace(record, value=record.value - away)


def sought(free: Channel, fitted: Fit, noise: float) -> Hop | None:
    """Return the step that explains most of what is slow in a record; None where noise alone may do as much.

    Each place is a candidate (ln n), its size has the price of unit information (½·ln n). In the place of slow modes,
    and of the polynomial or together with it, stands the step. The level of the noise is that of the readings, or of
    what the step leaves below half of the decay's frequency, where a step has its power, and where what is left of it
    beside all that is fitted has its own.

    Parameters
    ----------
    free : Channel
        Record from the release on.
    fitted : Fit
        Of it, at its full rate.
    noise : float
        Standard deviation of the readings.
    """
    t = free.time - free.time[0]
    fast = without_slow(fitted)
    found = [_best(free, t, fast, degree, noise) for degree in (0, DEGREE)]
    best = max(found, key=lambda one: one.log_bayes)
    return best if best.log_bayes > CLEAR and _moves_on(free, fitted, best, noise) else None


def without_slow(fitted: Fit) -> Fit:
    """Return a fit without the modes below half of the decay's frequency."""
    return only(fitted, [at for at, mode in enumerate(fitted.modes) if not at or mode.omega >= 0.5 * fitted.main.omega])


def only(fitted: Fit, kept: list[int]) -> Fit:
    """Return a fit with some of its modes."""
    return replace(fitted, modes=tuple(fitted.modes[at] for at in kept), coefficients=fitted.coefficients[kept])


def level(t: Floats, shape: Floats, rest: Floats, beside: tuple[Floats, Fit], noise: float) -> float:
    """Return the variance of white noise that makes the size of a shape as uncertain as the residuals do.

    Parameters
    ----------
    t, shape, rest : ndarray, shape (n,)
        Times from the first sample in s, the shape beside all that is fitted, and what both leave of the record.
    beside : ndarray, shape (n, p), and Fit
        Orthonormal columns of all that is fitted beside the shape, and the fit.
    noise : float
        Standard deviation of the readings: it is no less.
    """
    columns, fitted = beside
    return max(noise**2, *_slow(t, rest, fitted), _where(shape, rest, columns), _when(shape, rest, columns))


def _moves_on(free: Channel, fitted: Fit, hop: Hop, noise: float) -> bool:
    """Whether the decay is seen to go on after a step: what dry friction holds rests beside its zero as well."""
    later = free.time >= hop.time
    part = fitted.part(free.time[later] - free.time[0])
    energy = float(part @ part)
    there = float(part @ (fitted.residual[later] - hop.size)) / energy + 1.0
    return bool(there - noise / energy**0.5 > GOES_ON)


def is_sharp(free: Channel, fitted: Fit, hop: Hop, noise: float) -> bool:
    """Whether the step is seen between the readings next to it as well, and not in a longer part of the record alone.

    A cubic and the step are fitted to what the fit leaves within an eighth of a period on either side. Next to the ends
    of a record nothing can be said.
    """
    width = max(0.125 / fitted.main.frequency, FEWEST * free.step)
    near = abs(free.time - hop.time) <= width
    scaled, later = (free.time[near] - hop.time) / width, free.time[near] >= hop.time
    if min(later.sum(), (~later).sum()) < FEWEST:
        return False
    rest = free.value[near] - fitted.part(free.time[near] - free.time[0])
    columns = np.column_stack([legvander(scaled, 3), later])
    found = np.linalg.lstsq(columns, rest, rcond=None)[0]
    left = rest - columns @ found
    variance = max(noise**2, float(left @ left) / (len(left) - columns.shape[1]))
    u = float(np.sqrt(variance * np.linalg.inv(columns.T @ columns)[-1, -1]))
    return bool(abs(found[-1] - hop.size) < SHARP * u)


def jumps(residual: Floats, places: Sequence[int], size: float) -> bool:
    """Whether readings jump by a size at one of some places, or scatter too much to tell.

    What is slow, such as a swing that turns less than twice in a record, may do as much good as a step, and has none.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Residuals of a fit, in the unit of the readings.
    places : sequence of int
        Indices before which the step may be.
    size : float
        Of the step, in the same unit.

    Returns
    -------
    bool
        True also where no place has as many readings on either side.
    """
    at = np.array([one for one in places if BESIDE <= one <= len(residual) - BESIDE], dtype=int)
    if not at.size:
        return True
    sums = np.concatenate([[0.0], np.cumsum(residual)])
    seen = (sums[at + BESIDE] - 2 * sums[at] + sums[at - BESIDE]) / BESIDE
    u = sqrt(2 / BESIDE * float(np.mean(residual**2)))
    return bool((np.abs(seen - size) < SHARP * u).any())


def _best(free: Channel, t: Floats, fast: Fit, degree: int, noise: float) -> Hop:
    """Best step beside the fast modes and a polynomial."""
    beside = tangent(t, fast)[:, fast.slow :]
    base = baseline(t, degree=degree, settling=fast.settling)
    Q = np.linalg.qr(np.hstack([base, beside, forms(t, fast)]))[0]
    residual = free.value - Q @ (Q.T @ free.value)
    along, later = after(Q), np.arange(len(t), 0.0, -1.0)
    left = later - np.sum(along**2, axis=1)
    pull = after(residual[:, None])[:, 0]
    open_ = left > SEEN * np.minimum(later, len(t) - later + 1)
    gain = np.where(open_, pull**2 / np.where(open_, left, 1.0), 0.0)
    at = int(np.argmax(gain))
    size = float(pull[at] / left[at]) if open_[at] else 0.0
    step = (np.arange(len(t)) >= at).astype(float) - Q @ along[at]
    rest = residual - size * step
    variance = level(t, step, rest, (Q, fast), noise) / max(float(left[at]), SEEN)
    variance += rounding_bias(noise, quantum(free)) ** 2
    return Hop(float(free.time[at]), size, 0.5 * size**2 / variance - 1.5 * log(len(t)))


def forms(t: Floats, fitted: Fit) -> Floats:
    """Decay and multiples of it whose amplitude and phase differ smoothly from those fitted, shape (n, ·)."""
    main = fitted.main
    z = np.exp(np.clip(-main.rate * t, -60.0, 6.0) + 1j * main.omega * t)
    found = []
    for order, terms in enumerate(FORMS):
        ways = (z**order if order else np.abs(z))[:, None] * legvander(2 * t / t[-1] - 1, terms - 1)
        found += [ways.real, ways.imag] if order else [ways]
    return np.hstack(found)


def step_at(free: Channel, fitted: Fit, time: float) -> tuple[float, float]:
    """Return the size of a step at a time beside little changes of all that is fitted, and its standard uncertainty.

    The noise is what the fit leaves of the readings, or of it below half of the decay's frequency if that is more.
    """
    t, step = free.time - free.time[0], (free.time >= time).astype(float)
    Q = np.linalg.qr(tangent(t, fitted))[0]
    step -= Q @ (Q.T @ step)
    left = float(step @ step)
    size = float(step @ fitted.residual) / left
    rest = fitted.residual - size * step
    return size, sqrt(max(float(np.mean(rest**2)), *_slow(t, rest, fitted)) / left)


def after(rows: Floats) -> Floats:
    """Sums from each row to the last."""
    return np.asarray(np.cumsum(rows[::-1], axis=0)[::-1])


def _where(step: Floats, rest: Floats, Q: Floats) -> float:
    """Variance of white noise that makes the size of a step as uncertain as the residuals do, whatever their colour.

    What is fitted beside it leaves of a step near an end of a record, and of any in a record of few periods, what is
    not slow: Σ S·P/Σ S·P₁, with S the power of that, P the power of the residuals, and P₁ what the fit, whose columns
    are Q and the step, leaves of the power of white noise of variance 1.
    """
    size = 1 << (2 * len(step) - 1).bit_length()  # a length with a large prime factor takes ten times as long
    of_step, power = (np.abs(np.fft.rfft(one, size)) ** 2 for one in (step, rest))
    white = len(step) - of_step / max(float(step @ step), 1e-300)
    for column in Q.T:  # one by one: a record may be long
        white -= np.abs(np.fft.rfft(column, size)) ** 2
    return float(of_step @ power / max(float(of_step @ white), 1e-300))


def _when(step: Floats, rest: Floats, Q: Floats) -> float:
    """Variance of white noise that makes the size of a step as uncertain as the residuals do, whenever they are large.

    What shakes a rig while it is let go is noise for a second, and a step there stands out of that of the rest only:
    Σ s²·r²/(1 − h)²/Σ s², with s the step beside all that is fitted, and 1 − h what the fit and the step leave of each
    reading (White, Econometrica 48 (1980) 817; HC3 of MacKinnon & White, J. Econom. 29 (1985) 305).
    """
    left = np.maximum(1.0 - np.sum(Q**2, axis=1) - step**2 / max(float(step @ step), 1e-300), SEEN)
    return float(step**2 @ (rest / left) ** 2 / max(float(step @ step), 1e-300))


def _slow(t: Floats, rest: Floats, fitted: Fit) -> tuple[float, float]:
    """Variances of white noise with the power of residuals below half of the decay's frequency.

    The mean, which structure has, and the mean with the weights 1/f² of a step, which slower motion has.
    """
    f, power = periodogram(t, rest)
    below = (f > 0) & (f < 0.5 * fitted.main.frequency)
    f, power = f[below], power[below]
    return (float(np.mean(power)), float(np.average(power, weights=f**-2.0))) if below.any() else (0.0, 0.0)
