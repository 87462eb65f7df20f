"""Oscillations of a record: the longitudinal one, and what else stands out of what its fit leaves."""

from __future__ import annotations

from dataclasses import replace
from math import inf, log, pi

import numpy as np

from metrology.decay.oscillation import DEGREE, Fit, Floats, Mode, at_rate, baseline, fit, project
from metrology.decay.start import Unusable
from metrology.message import said
from metrology.timeseries import Channel, average
from metrology.timeseries.extrema import maxima
from metrology.timeseries.spectra import on_grid, periodogram

OTHERS = 10
"""Most further oscillations (transverse, pendulum, mains) that are looked for in one record."""
MAINS_WIDTH = 0.5
"""Hz about a multiple of the mains frequency within which a line is theirs."""

_FALSE_ALARM = 1e-4  # of one search of a record of noise alone
_PER_PERIOD = 24  # samples kept per period for the fit: block means lose nothing of a decaying oscillation
_PASSES = 6  # of looking at what is left
_FINER = 4  # times that the frequencies of a spectrum lie closer than those of the record itself
_PARTS = (1.0, 0.25, 0.0625)  # of a record, from its beginning, in which an oscillation is looked for
_FEWEST = 512  # readings of a part whose spectrum is looked at: sixteen frequencies in each block that tells its level
_SLOW = DEGREE / 2  # cycles in a record: what turns less often is what the polynomial of the baseline follows


def is_mains(mode: Mode, mains: float) -> bool:
    """Tell whether a mode lies at a multiple of the mains frequency (Hz).

    Parameters
    ----------
    mode : Mode
        With its frequency in Hz.
    mains : float
        Frequency of the mains, in Hz.

    Returns
    -------
    bool
        Whether it is within the width that a mains line has.
    """
    multiple = round(mode.frequency / mains)
    return multiple >= 1 and abs(mode.frequency - multiple * mains) < MAINS_WIDTH


def longitudinal(free: Channel, level: float, *, mains: float, expected: float | None) -> Mode:
    """Return a first guess of the longitudinal mode: where a decaying oscillation takes most energy from the record."""
    t = free.time - free.time[0]
    y = project(t, free.value, [_mains_line(t, free.value, mains)], baseline(t)).residual
    rates = 0.3 / t[-1] * 1.6 ** np.arange(40)
    rates = rates[rates < 0.1 / free.step]
    weights = np.exp(-np.outer(rates, t))
    weighted = np.array([on_grid(t, row * y, free.step) for row in weights])
    size = 4 * 2 ** int(np.ceil(np.log2(weighted.shape[1])))
    omega = 2 * pi * np.fft.rfftfreq(size, free.step)
    energy = 2 * abs(np.fft.rfft(weighted, size, axis=1)) ** 2 / (weights**2).sum(axis=1)[:, None]
    allowed = (omega > 3 * 2 * pi / t[-1]) & (omega < 2 * pi / free.step / 8) & (rates[:, None] < 0.6 * omega)
    multiple = np.maximum(np.round(omega / (2 * pi * mains)), 1)
    allowed &= abs(omega / (2 * pi) - multiple * mains) > max(MAINS_WIDTH, 2 / t[-1])
    if expected is not None:
        allowed &= abs(omega - expected) < 0.3 * expected
    if not allowed.any():
        text = "No frequency is left to look for a decay: the record is too short or sampled too slowly."
        raise Unusable(said(text))
    row, column = np.unravel_index(np.argmax(np.where(allowed, energy, 0.0)), energy.shape)
    if energy[row, column] < 50 * level**2 or y.std() < 1e-9 * abs(free.value).max():
        raise Unusable(
            said(
                "Nothing oscillates above the noise: no decaying oscillation takes more from the record than noise "
                "would. Check the release, the focus of the sensor and its range."
            )
        )
    return Mode(float(omega[column]), float(rates[row]))


def _mains_line(t: Floats, y: Floats, mains: float) -> Mode:
    """Return the steady line that takes most from the record within the width of the mains (Hann window)."""
    omega = 2 * pi * (mains + np.linspace(-MAINS_WIDTH, MAINS_WIDTH, 41))
    lines = np.exp(-1j * np.outer(omega, t)) @ (np.hanning(t.size) * (y - y.mean()))
    return Mode(float(omega[np.argmax(abs(lines))]), 0.0)


def disentangle(free: Channel, first: Mode, settling: float = 0.0) -> Fit:
    """Fit the longitudinal mode, then add other oscillations while the residuals show any.

    Parameters
    ----------
    free : Channel
        Record from the release on.
    first : Mode
        First guess of the longitudinal mode.
    settling : float
        Rate / (1/s) at which the zero settles; 0 where it does not.
    """
    coarse = average(free, per_mean(free, first))
    t, lags = coarse.time - coarse.time[0], int(2 / coarse.step / first.frequency)
    full = free.time - free.time[0]
    # The block means blur what is faster: its frequency is taken from the spectrum, and held.
    fast = 0.6 * pi / coarse.step
    fitted = fit(t, coarse.value, [first], lags=lags, settling=settling)
    if abs(fitted.main.omega - first.omega) > 0.2 * first.omega:  # drawn away by something stronger: fit that with it
        fixed = project(t, coarse.value, [first], baseline(t, settling=settling))
        alone = replace(fitted, modes=(first,), coefficients=fixed.coefficients, residual=fixed.residual)
        strong = [mode for mode in _others(t, alone, []) if mode.omega <= fast]
        together = fit(t, coarse.value, [first, *strong], lags=lags, settling=settling)
        fitted = together if together.converged else fitted
    held: list[Mode] = []
    refused: list[float] = []
    for _ in range(_PASSES):
        found = _others(full, at_rate(fitted, full, free.value, held=held), refused)
        found = found[: OTHERS + 1 - len(fitted.modes) - len(held)]
        if not found:
            break
        held += [mode for mode in found if mode.omega > fast and not mode.rate]
        refused += [mode.omega for mode in found if mode.omega > fast]
        slow = [mode for mode in found if mode.omega <= fast]
        counts = dict.fromkeys((len(slow), 1))  # all of them, else the strongest alone
        trials = (fit(t, coarse.value, [*fitted.modes, *slow[:n]], held=held, lags=lags, settling=settling)
                  for n in counts)  # fmt: skip
        # What lasts longer shows in the whole record, or is not clear of noise there.
        least = 1 / (_PARTS[-1] * t[-1]) if found[0].rate else -inf
        better = next((trial for trial in trials if is_sound(trial, fitted, t[-1])
                       and all(mode.rate > least for mode in trial.modes[len(fitted.modes) :])), None)  # fmt: skip
        refused += [slow[0].omega] if better is None and slow else []
        fitted = fitted if better is None else better
    return at_rate(fitted, full, free.value, held=held)


def per_mean(free: Channel, main: Mode) -> int:
    """Return how many readings go into a mean; uneven ones are fitted one by one, since no two blocks are alike."""
    return max(1, int(1 / free.step / (_PER_PERIOD * max(main.frequency, main.rate)))) if free.is_even else 1


def guard(main: Mode, duration: float) -> float:
    """Return how far (rad/s) another oscillation must lie from the longitudinal one to be told from it.

    Nearer ones would take up what dry or quadratic damping leaves of the longitudinal mode itself.

    Parameters
    ----------
    main : Mode
        The longitudinal oscillation, with its decay rate in 1/s.
    duration : float
        Of the record, in s.

    Returns
    -------
    float
        In rad/s: the decay rate, or three periods over the record if that is more.
    """
    return max(abs(main.rate), 6 * pi / duration)


def _others(t: Floats, fitted: Fit, refused: list[float]) -> list[Mode]:
    """Return the oscillations that stand out of the spectrum of the residuals, the strongest first.

    Of the whole record, and where it shows none, of its beginning: what dies there is lost in the whole.
    """
    for part in _PARTS:
        first = t <= part * t[-1]
        if part < 1 and first.sum() < _FEWEST:
            break
        found = _standing_out(t[first], replace(fitted, residual=fitted.residual[first]), refused)
        if found:
            return [replace(mode, rate=0.0 if part == 1 else 2 / (part * t[-1])) for mode in found]
    return []


def _standing_out(t: Floats, fitted: Fit, refused: list[float]) -> list[Mode]:
    """Return the oscillations that stand out of the spectrum of the residuals (Hann window), the strongest first."""
    omega, power, level = spectrum(t, fitted.residual)
    width, height = 2 * pi / t[-1], power / level
    height[abs(omega - fitted.main.omega) < guard(fitted.main, t[-1])] = 0.0
    height[omega < 0.75 * width] = 0.0
    for centre in refused:
        height[abs(omega - centre) < 1.5 * width] = 0.0
    index = maxima(height, floor=log(t.size / _FALSE_ALARM), gap=int(3 * width / omega[1]))
    index = index[np.argsort(-power[index])][:4]
    left, here, right = (np.log(power[np.minimum(index + shift, power.size - 1)]) for shift in (-1, 0, 1))
    centre = omega[index] + 0.5 * (left - right) / (left - 2 * here + right) * omega[1]
    return [Mode(float(w), 0.0) for w in centre]


def spectrum(t: Floats, residual: Floats) -> tuple[Floats, Floats, Floats]:
    """Return angular frequencies, the power of the residuals of a fit there, and the mean power beside any line."""
    frequency, power = periodogram(t, residual, finer=_FINER)
    return 2 * pi * frequency, power, _level(power)


def _level(power: Floats) -> Floats:
    """Return the mean power beside any line, by medians over sixteen blocks (ln 2 of the mean each).

    Not one level for all: coloured noise is no line.
    """
    blocks = np.array_split(power, 16)
    middle = np.cumsum([block.size for block in blocks]) - blocks[0].size / 2
    level = np.interp(np.arange(power.size), middle, [np.median(block) / log(2) for block in blocks])
    return np.maximum(level, 1e-300)


def is_sound(trial: Fit, before: Fit, duration: float) -> bool:
    """Tell whether a fit with more modes still means what it says: better, and no mode swallowed another.

    Parameters
    ----------
    trial, before : Fit
        With more modes, and without them.
    duration : float
        Of the record, in s.

    Returns
    -------
    bool
        Whether it may be taken.
    """
    main = trial.main
    omega = np.array([mode.omega for mode in trial.modes[1:]])
    rate = np.array([mode.rate for mode in trial.modes[1:]])
    near = abs(omega - main.omega) < 0.7 * guard(main, duration)
    # One that dies sooner is as wide as it dies soon: beside the main one it is what makes that no plain decay.
    early = rate > 2 / (_PARTS[1] * duration)
    near |= early & (abs(omega - main.omega) < 2 * pi * np.maximum(rate, main.rate))
    wild = (omega * duration < 2 * pi * _SLOW) | (rate * duration > 40) | (rate * duration < -1.5)
    moved = abs(main.omega - before.main.omega) > 0.2 * before.main.omega
    return trial.converged and trial.squares < before.squares and not (near.any() or wild.any() or moved)
