"""What of a record is the longitudinal oscillation, and what is not: its start, its modes, and when to refuse."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log, pi

import numpy as np

from metrology.decay.oscillation import DEGREE, Fit, Floats, Mode, at_rate, baseline, fit, project
from metrology.timeseries import Channel, average, maxima, noise, quantum

OTHERS = 10
"""Most further oscillations (transverse, pendulum, mains) that are looked for in one record."""

_FALSE_ALARM = 1e-4  # of one search of a record of noise alone
_PER_PERIOD = 24  # samples kept per period for the fit: block means lose nothing of a decaying oscillation
_FEWEST_SAMPLES = 60
_PASSES = 6  # of looking at what is left
_MAINS_WIDTH = 0.5  # Hz about a multiple of the mains frequency


class Unusable(Exception):  # noqa: N818  # not an error: the record is turned into a sentence of the report
    """A record from which no decay can be taken, with the sentence that says why."""


@dataclass(frozen=True)
class Separated:
    """A record taken apart: `free`, what follows the release at time `release` (s), and the fit at its full rate."""

    free: Channel
    fit: Fit
    release: float
    noise: float

    @property
    def t(self) -> Floats:
        """Times of `free` in s, from its first sample."""
        t: Floats = self.free.time - self.free.time[0]
        return t

    def describe(self, mains: float) -> str:
        """Say what was found beside the longitudinal mode."""
        found = [
            f"{mode.frequency:.4g} Hz{' (mains)' if is_mains(mode, mains) else ''} of {1e6 * size:.2g} µm"
            for mode, size in self.fit.others
        ]
        return ", ".join(found) if found else "no other oscillation"


def is_mains(mode: Mode, mains: float) -> bool:
    """Tell whether a mode lies at a multiple of the mains frequency (Hz)."""
    multiple = round(mode.frequency / mains)
    return multiple >= 1 and abs(mode.frequency - multiple * mains) < _MAINS_WIDTH


def separate(record: Channel, *, mains: float, expected: float | None = None) -> Separated:
    """Find the free decay in a record, and fit the longitudinal mode together with all that overlies it.

    Parameters
    ----------
    record : Channel
        Displacement in m, sampled evenly, with or without samples from before the release.
    mains : float
        Frequency of the mains in Hz.
    expected : float, optional
        Where the longitudinal mode is expected, √(k/m) in rad/s; without it, it is the strongest that is not mains.

    Raises
    ------
    Unusable
        When the record has no decay that can be evaluated.
    """
    free = _free(record, expected)
    level = noise(free)
    _refuse_clipped(free)
    first = _longitudinal(free, level, mains=mains, expected=expected)
    fitted = _disentangle(free, first)
    _refuse_weak(fitted, mains=mains, rate=free.rate)
    return Separated(free, fitted, float(free.time[0]) + _release(fitted), level)


def _free(record: Channel, expected: float | None) -> Channel:
    """Return the record from the first time that it crosses its rest position after its largest excursion.

    Plateau before the release and the pull of the magnet while it dies away both lie before that. With an expected
    frequency, motion much slower and much faster is left out of account. Where nothing crosses, the record's own
    zero of time is taken for the release, or its first sample.
    """
    rest = float(np.median(record.value[2 * record.value.size // 3 :]))
    away = record.value - rest
    if expected is not None:
        period = int(min(2 * pi / expected * record.rate, record.value.size / 2))
        quick, slow = (np.convolve(away, np.ones(n) / n, mode="same") for n in (max(period // 4, 1), max(period, 1)))
        away = (quick - slow) * (abs(np.arange(away.size) - away.size / 2) < away.size / 2 - period)
    top = int(np.argmax(abs(away)))
    crossed = np.flatnonzero(away[top:] * np.sign(away[top]) < 0)
    start = record.time[top + crossed[0]] if crossed.size else np.inf
    if (record.time >= start).sum() < _FEWEST_SAMPLES:
        start = max(0.0, float(record.time[0]))
    if (record.time >= start).sum() < _FEWEST_SAMPLES:
        raise Unusable(
            f"The record is too short: fewer than {_FEWEST_SAMPLES} samples after the release. Record three periods"
            " at least."
        )
    return record.part(float(start))


def _refuse_clipped(free: Channel) -> None:
    """Refuse a record whose extrema are flat for longer than rounding makes them."""
    step = quantum(free)
    for sign in (1, -1):
        value = sign * free.value
        flat = value >= value.max() - 1e-9 * abs(value).max()
        edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.astype(int), [0]])))
        longest = int((edges[1::2] - edges[::2]).max())
        if longest >= 5 and _flatter(value, longest, step):
            raise Unusable(
                f"The record is clipped: {longest} samples in a row stand at {sign * value.max():.4g} m. The range"
                " of the vibrometer was too small; repeat with a larger range or a smaller release."
            )


def _flatter(value: Floats, longest: int, step: float) -> bool:
    """Tell whether a flat top is longer than a parabola through its flanks, rounded to `step`, would have it."""
    top = int(np.argmax(value))
    middle = top + longest // 2
    reach = min(2 * longest, middle, value.size - 1 - middle)
    if reach < longest:
        return False
    drop = value[top] - 0.5 * (value[middle - reach] + value[middle + reach])
    # A parabola falls by so much of `drop` at half the flat length.
    return bool(drop * (longest / (2 * reach)) ** 2 > 2 * step)


def _longitudinal(free: Channel, level: float, *, mains: float, expected: float | None) -> Mode:
    """Return a first guess of the longitudinal mode: where a decaying oscillation takes most energy from the record."""
    t = free.time - free.time[0]
    y = project(t, free.value, [_mains_line(t, free.value, mains)], baseline(t)).residual
    rates = 0.3 / t[-1] * 1.6 ** np.arange(40)
    rates = rates[rates < 0.1 * free.rate]
    size = 4 * 2 ** int(np.ceil(np.log2(t.size)))
    omega = 2 * pi * np.fft.rfftfreq(size, t[1])
    weights = np.exp(-np.outer(rates, t))
    energy = 2 * abs(np.fft.rfft(weights * y, size, axis=1)) ** 2 / (weights**2).sum(axis=1)[:, None]
    allowed = (omega > 3 * 2 * pi / t[-1]) & (omega < 2 * pi * free.rate / 8) & (rates[:, None] < 0.6 * omega)
    multiple = np.maximum(np.round(omega / (2 * pi * mains)), 1)
    allowed &= abs(omega / (2 * pi) - multiple * mains) > max(_MAINS_WIDTH, 2 / t[-1])
    if expected is not None:
        allowed &= abs(omega - expected) < 0.3 * expected
    if not allowed.any():
        raise Unusable("No frequency is left to look for a decay: the record is too short or sampled too slowly.")
    row, column = np.unravel_index(np.argmax(np.where(allowed, energy, 0.0)), energy.shape)
    if energy[row, column] < 50 * level**2 or y.std() < 1e-9 * abs(free.value).max():
        raise Unusable(
            "Nothing oscillates above the noise: no decaying oscillation takes more from the record than noise would."
            " Check the release, the focus of the vibrometer and its range."
        )
    return Mode(float(omega[column]), float(rates[row]))


def _mains_line(t: Floats, y: Floats, mains: float) -> Mode:
    """Return the steady line that takes most from the record within the width of the mains (Hann window)."""
    omega = 2 * pi * (mains + np.linspace(-_MAINS_WIDTH, _MAINS_WIDTH, 41))
    lines = np.exp(-1j * np.outer(omega, t)) @ (np.hanning(t.size) * (y - y.mean()))
    return Mode(float(omega[np.argmax(abs(lines))]), 0.0)


def _disentangle(free: Channel, first: Mode) -> Fit:
    """Fit the longitudinal mode, then add other oscillations while the residuals show any."""
    count = max(1, int(free.rate / (_PER_PERIOD * first.frequency)))
    coarse = average(free, count)
    t, lags = coarse.time - coarse.time[0], int(2 * coarse.rate / first.frequency)
    full = free.time - free.time[0]
    # The block means blur what is faster: its frequency is taken from the spectrum, and held.
    fast = 0.6 * pi * coarse.rate
    fitted = fit(t, coarse.value, [first], lags=lags)
    if abs(fitted.main.omega - first.omega) > 0.2 * first.omega:  # drawn away by something stronger: fit that with it
        fixed = project(t, coarse.value, [first], baseline(t))
        alone = replace(fitted, modes=(first,), coefficients=fixed.coefficients, residual=fixed.residual)
        strong = [mode for mode in _others(t, alone, []) if mode.omega <= fast]
        fitted = fit(t, coarse.value, [first, *strong], lags=lags)
    held: list[Mode] = []
    refused: list[float] = []
    for _ in range(_PASSES):
        found = _others(full, at_rate(fitted, full, free.value, held=held), refused)
        found = found[: OTHERS + 1 - len(fitted.modes) - len(held)]
        if not found:
            break
        held += [mode for mode in found if mode.omega > fast]
        refused += [mode.omega for mode in found if mode.omega > fast]
        slow = [mode for mode in found if mode.omega <= fast]
        counts = dict.fromkeys((len(slow), 1))  # all of them, else the strongest alone
        trials = (fit(t, coarse.value, [*fitted.modes, *slow[:n]], held=held, lags=lags) for n in counts)
        better = next((trial for trial in trials if _sound(trial, fitted, t[-1])), None)
        refused += [slow[0].omega] if better is None and slow else []
        fitted = fitted if better is None else better
    return at_rate(fitted, full, free.value, held=held)


def guard(main: Mode, duration: float) -> float:
    """Return how far (rad/s) another oscillation must lie from the longitudinal one to be told from it.

    Nearer ones would take up what dry or quadratic damping leaves of the longitudinal mode itself.
    """
    return max(abs(main.rate), 6 * pi / duration)


def _others(t: Floats, fitted: Fit, refused: list[float]) -> list[Mode]:
    """Return the oscillations that stand out of the spectrum of the residuals (Hann window), the strongest first."""
    size, width = 4 * 2 ** int(np.ceil(np.log2(t.size))), 2 * pi / t[-1]
    omega = 2 * pi * np.fft.rfftfreq(size, t[1] - t[0])
    power: Floats = np.square(abs(np.fft.rfft(np.hanning(t.size) * fitted.residual, size))).astype(np.float64)
    height = power / _level(power)
    height[abs(omega - fitted.main.omega) < guard(fitted.main, t[-1])] = 0.0
    height[omega < 0.75 * width] = 0.0
    for centre in refused:
        height[abs(omega - centre) < 1.5 * width] = 0.0
    index = maxima(height, floor=log(t.size / _FALSE_ALARM), gap=int(3 * width / omega[1]))
    index = index[np.argsort(-power[index])][:4]
    left, here, right = (np.log(power[np.minimum(index + shift, power.size - 1)]) for shift in (-1, 0, 1))
    centre = omega[index] + 0.5 * (left - right) / (left - 2 * here + right) * omega[1]
    return [Mode(float(w), 0.0) for w in centre]


def _level(power: Floats) -> Floats:
    """Return the mean power beside any line, by medians over sixteen blocks (ln 2 of the mean each).

    Not one level for all: coloured noise is no line.
    """
    blocks = np.array_split(power, 16)
    middle = np.cumsum([block.size for block in blocks]) - blocks[0].size / 2
    level = np.interp(np.arange(power.size), middle, [np.median(block) / log(2) for block in blocks])
    return np.maximum(level, 1e-300)


def _sound(trial: Fit, before: Fit, duration: float) -> bool:
    """Tell whether a fit with more modes still means what it says: better, and no mode swallowed another."""
    main = trial.main
    omega = np.array([mode.omega for mode in trial.modes[1:]])
    rate = np.array([mode.rate for mode in trial.modes[1:]])
    near = abs(omega - main.omega) < 0.7 * guard(main, duration)
    wild = (omega * duration < pi) | (rate * duration > 40) | (rate * duration < -1.5)
    moved = abs(main.omega - before.main.omega) > 0.2 * before.main.omega
    return trial.converged and trial.squares < before.squares and not (near.any() or wild.any() or moved)


def _refuse_weak(fitted: Fit, *, mains: float, rate: float) -> None:
    """Refuse a fit whose first mode does not decay, drowns in mains, or is sampled too slowly."""
    main, size = fitted.main, float(fitted.amplitudes[0])
    u = float(np.sqrt(fitted.covariance[1, 1]))
    hum = sum(other for mode, other in fitted.others if is_mains(mode, mains))
    steady = not fitted.converged or not main.rate > 2 * u
    if hum > 2 * size or (steady and is_mains(main, mains)):
        raise Unusable(
            f"Mains dominates: {1e6 * max(hum, size):.3g} µm at multiples of {mains:g} Hz, over twice any decay."
            " Part the vibrometer's supply and earth from the rest of the set-up, and repeat."
        )
    if steady:
        raise Unusable(
            f"No decay is seen: the rate of the strongest oscillation ({main.frequency:.4g} Hz) is {main.rate:.3g} 1/s"
            f" with a standard uncertainty of {u:.2g} 1/s. Something may drive it, or it is not the longitudinal"
            " mode; state where that is expected."
        )
    if rate < 8 * main.frequency:
        raise Unusable(
            f"Sampled too slowly: {rate:.4g} Hz for an oscillation at {main.frequency:.4g} Hz; eight samples a period"
            " are needed at least."
        )


def _release(fitted: Fit) -> float:
    """Return the time (s, not positive) of the last extremum of the longitudinal mode before the first sample."""
    a, b = fitted.coefficients[0]
    slope = complex(-fitted.main.rate, fitted.main.omega) * complex(a, -b)
    phase = (np.angle(slope) - pi / 2) % pi
    return float(-phase / fitted.main.omega)


def without_others(separated: Separated, record: Channel) -> Floats:
    """Return a record less the fitted baseline and other modes, extended to samples before the first one fitted."""
    fitted, origin = separated.fit, separated.free.time[0]
    t = record.time - origin
    value = record.value.copy()
    for index in range(1, len(fitted.modes)):
        value -= fitted.part(t, index)
    less: Floats = value - _drift(separated)(t)
    return less


def _drift(separated: Separated) -> np.polynomial.Polynomial:
    """Return the fitted baseline as a polynomial in the time from the first sample fitted."""
    t, fitted = separated.t, separated.fit
    rest = separated.free.value - fitted.residual - sum(fitted.part(t, i) for i in range(len(fitted.modes)))
    return np.polynomial.Polynomial.fit(t, rest, DEGREE)


def curvature(separated: Separated) -> float:
    """Return the root mean square of the second derivative of the fitted baseline, m/s²."""
    bend = _drift(separated).deriv(2)(separated.t)
    return float(np.sqrt(np.mean(bend**2)))
