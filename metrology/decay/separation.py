"""What of a record is the longitudinal oscillation, and what is not: its start, its modes, and when to refuse."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import log, pi

import numpy as np

from metrology.decay.hop import CLEAR, Hop, sought, step_at, without
from metrology.decay.oscillation import DEGREE, Fit, Floats, Mode, at_rate, baseline, fit, project
from metrology.decay.outliers import masked
from metrology.decay.start import Unusable, free_motion, heavy, refuse_clipped, refuse_short
from metrology.timeseries import Channel, average, maxima, noise, on_grid

OTHERS = 10
"""Most further oscillations (transverse, pendulum, mains) that are looked for in one record."""
HOPS = 3
"""Most steps of one record: what seems to have more, such as a step of the gain, has another fault."""

_FALSE_ALARM = 1e-4  # of one search of a record of noise alone
_PER_PERIOD = 24  # samples kept per period for the fit: block means lose nothing of a decaying oscillation
_FAR = 25.0  # times the mean square of the rest, beyond which what comes before the first crossing is not looked at
_PLAIN = 0.05  # chance below which the fit leaves more before the first crossing than after it
_DRIFT = 0.05  # chance of as large a drift from noise alone below which it is taken for one
_PASSES = 6  # of looking at what is left
_MAINS_WIDTH = 0.5  # Hz about a multiple of the mains frequency
_SLOW = DEGREE / 2  # cycles in a record: what turns less often is what the polynomial of the baseline follows


@dataclass(frozen=True)
class Separated:
    """A record taken apart: `free`, what follows the release at time `release` (s), and the fit at its full rate.

    `outliers`: times (s) of readings after the release that were masked; `crossed`: time (s) from the first sample to
    the first crossing of the rest position; `hops`: steps of the reading that were taken out.
    """

    free: Channel
    fit: Fit
    release: float
    noise: float
    outliers: tuple[float, ...] = ()
    crossed: float = 0.0
    hops: tuple[Hop, ...] = ()

    @property
    def t(self) -> Floats:
        """Times of `free` in s, from its first sample."""
        t: Floats = self.free.time - self.free.time[0]
        return t

    def describe(self, mains: float) -> str:
        """Say what was found together with the longitudinal mode."""
        unit = f"µ{self.free.unit}"
        found = [
            f"{mode.frequency:.4g} Hz{' (mains)' if is_mains(mode, mains) else ''} of {1e6 * size:.2g} {unit}"
            for mode, size in self.fit.others
        ]
        masked = f"; {len(self.outliers)} outlier{'s' * (len(self.outliers) > 1)} masked" if self.outliers else ""
        hops = "".join(f"; a step of {1e6 * one.size:.3g} {unit} at {one.time:.4g} s taken out" for one in self.hops)
        return (", ".join(found) if found else "no other oscillation") + masked + hops


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
        raise Unusable("The record has no even steps, or misses more than a tenth of them: it cannot be filtered.")
    value = drift(separated)(t) + sum(fitted.part(t, i) for i in range(len(fitted.modes)))
    residual = np.zeros(t.size)
    value[places], residual[places] = free.value, fitted.residual
    return replace(
        separated,
        free=replace(free, time=free.time[0] + t, value=value),
        fit=replace(fitted, residual=residual),
    )


def is_mains(mode: Mode, mains: float) -> bool:
    """Tell whether a mode lies at a multiple of the mains frequency (Hz)."""
    multiple = round(mode.frequency / mains)
    return multiple >= 1 and abs(mode.frequency - multiple * mains) < _MAINS_WIDTH


def separate(record: Channel, *, mains: float, expected: float | None = None) -> Separated:
    """Find the free decay in a record, and fit the longitudinal mode together with all that overlies it.

    Parameters
    ----------
    record : Channel
        Displacement in m or angle in rad, with or without samples from before the release. Steps need not be even, and
        readings may be missing: the fit stands at the stamps.
    mains : float
        Frequency of the mains in Hz.
    expected : float, optional
        Where the longitudinal mode is expected, √(k/m) in rad/s; without it, it is the strongest that is not mains.

    Raises
    ------
    Unusable
        When the record has no decay that can be evaluated.
    """
    whole, outliers = masked(record)
    refuse_short(whole)
    free, is_heavy = free_motion(whole, expected)
    level = noise(free)
    refuse_clipped(free)
    first = heavy(free) if is_heavy else None
    first = first or _longitudinal(free, level, mains=mains, expected=expected)
    fitted = _disentangle(free, first)
    free, fitted, hops = _without_hops(free, fitted, first, level)
    whole = without(whole, hops)
    _refuse_weak(fitted, mains=mains, step=free.step)
    crossed = float(free.time[0])
    free, fitted = _from_release(whole, free, fitted)
    fitted = _without_drift(free, fitted)
    start = float(free.time[0])
    return Separated(
        free, fitted, start + _release(fitted), level, tuple(outliers[outliers > start].tolist()), crossed - start, hops
    )


def _longitudinal(free: Channel, level: float, *, mains: float, expected: float | None) -> Mode:
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
    coarse = average(free, _count(free, first))
    t, lags = coarse.time - coarse.time[0], int(2 / coarse.step / first.frequency)
    full = free.time - free.time[0]
    # The block means blur what is faster: its frequency is taken from the spectrum, and held.
    fast = 0.6 * pi / coarse.step
    fitted = fit(t, coarse.value, [first], lags=lags)
    if abs(fitted.main.omega - first.omega) > 0.2 * first.omega:  # drawn away by something stronger: fit that with it
        fixed = project(t, coarse.value, [first], baseline(t))
        alone = replace(fitted, modes=(first,), coefficients=fixed.coefficients, residual=fixed.residual)
        strong = [mode for mode in _others(t, alone, []) if mode.omega <= fast]
        together = fit(t, coarse.value, [first, *strong], lags=lags)
        fitted = together if together.converged else fitted
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


def _without_hops(free: Channel, fitted: Fit, first: Mode, level: float) -> tuple[Channel, Fit, tuple[Hop, ...]]:
    """Return a record less its steps, and its fit; a step stays where its fit explains no more with fewer modes."""
    hops: tuple[Hop, ...] = ()
    given = free, fitted
    while (hop := sought(free, fitted, level)) is not None:
        if len(hops) == HOPS:
            return *given, ()
        less = without(free, [hop])
        again = _disentangle(less, first)
        # What is fitted with it now says what its size is.
        hop = replace(hop, size=hop.size + step_at(less, again, hop.time))
        less = without(free, [hop])
        again = _disentangle(less, first)
        plain, stepped = _without_drift(free, fitted), _without_drift(less, again)
        fewer = 4 * (len(plain.modes) - len(stepped.modes)) + plain.degree - stepped.degree - 3
        gain = 0.5 * (plain.squares - stepped.squares) / max(level**2, stepped.squares / len(free))
        if gain + 0.5 * fewer * log(len(free)) < CLEAR:
            break
        hops, free, fitted = (*hops, hop), less, again
    return free, fitted, hops


def _from_release(whole: Channel, free: Channel, fitted: Fit) -> tuple[Channel, Fit]:
    """Return the record from the release itself on, and its fit, where it moves freely before the first crossing too.

    It is where the fit leaves no more of it than of the rest (F test): there the amplitude is largest, and a response
    test of the same record has it as well. A magnet whose pull dies away fails the test.
    """
    from scipy.special import fdtrc

    start, rest = float(free.time[0]) + _release(fitted), float(np.mean(fitted.residual**2))
    for early in (0.5, 0.0):  # the release is known to half a step at best, and its own reading is the largest of all
        longer = whole.part(start - early * free.step)
        count = len(longer) - len(free)
        before = longer.value[:count] - _at(free, fitted, longer.time[:count])
        if count < 1 or np.mean(before**2) > _FAR * rest:
            continue
        again = _refitted(longer, fitted)
        ratio = float(np.mean(again.residual[:count] ** 2) / np.mean(again.residual[count:] ** 2))
        if again.converged and fdtrc(count, len(free), ratio) >= _PLAIN:
            return longer, again
    return free, fitted


def _at(free: Channel, fitted: Fit, time: Floats) -> Floats:
    """Return the fit, baseline and all modes, at times of the record."""
    t = time - free.time[0]
    value: Floats = _baseline(free, fitted)(t) + sum(fitted.part(t, i) for i in range(len(fitted.modes)))
    return value


def _without_drift(free: Channel, fitted: Fit) -> Fit:
    """Return the fit over a constant zero where the record shows no drift (F test): what is not there costs nothing."""
    from scipy.special import fdtrc

    plain = _refitted(free, fitted, degree=0)
    left = len(free) - DEGREE - 4 * len(fitted.modes) - 1
    ratio = (plain.squares - fitted.squares) / DEGREE / (max(fitted.squares, 1e-300) / left)
    return plain if plain.converged and fdtrc(DEGREE, left, max(ratio, 0.0)) >= _DRIFT else fitted


def _refitted(free: Channel, fitted: Fit, degree: int = DEGREE) -> Fit:
    """Return the fit of the same modes to a longer part of the record, or over another polynomial."""
    coarse = average(free, _count(free, fitted.main))
    fast = 0.6 * pi / coarse.step
    slow, held = ([mode for mode in fitted.modes if (mode.omega > fast) == is_fast] for is_fast in (False, True))
    lags = int(2 / coarse.step / fitted.main.frequency)
    again = fit(coarse.time - coarse.time[0], coarse.value, slow, held=held, lags=lags, degree=degree)
    return at_rate(again, free.time - free.time[0], free.value, held=held)


def _count(free: Channel, main: Mode) -> int:
    """Return how many readings go into a mean; uneven ones are fitted one by one, since no two blocks are alike."""
    return max(1, int(1 / free.step / (_PER_PERIOD * max(main.frequency, main.rate)))) if free.is_even else 1


def guard(main: Mode, duration: float) -> float:
    """Return how far (rad/s) another oscillation must lie from the longitudinal one to be told from it.

    Nearer ones would take up what dry or quadratic damping leaves of the longitudinal mode itself.
    """
    return max(abs(main.rate), 6 * pi / duration)


def _others(t: Floats, fitted: Fit, refused: list[float]) -> list[Mode]:
    """Return the oscillations that stand out of the spectrum of the residuals (Hann window), the strongest first."""
    step = float(np.median(np.diff(t)))
    windowed = on_grid(t, np.hanning(t.size) * fitted.residual, step)
    size, width = 4 * 2 ** int(np.ceil(np.log2(windowed.size))), 2 * pi / t[-1]
    omega = 2 * pi * np.fft.rfftfreq(size, step)
    power: Floats = np.square(abs(np.fft.rfft(windowed, size))).astype(np.float64)
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
    wild = (omega * duration < 2 * pi * _SLOW) | (rate * duration > 40) | (rate * duration < -1.5)
    moved = abs(main.omega - before.main.omega) > 0.2 * before.main.omega
    return trial.converged and trial.squares < before.squares and not (near.any() or wild.any() or moved)


def _refuse_weak(fitted: Fit, *, mains: float, step: float) -> None:
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
    if 1 / step < 8 * main.frequency * (1 - 1e-9):
        raise Unusable(
            f"Sampled too slowly: {1 / step:.4g} Hz for an oscillation at {main.frequency:.4g} Hz; eight samples a"
            " period are needed at least."
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
    less: Floats = value - drift(separated)(t)
    return less


def drift(separated: Separated) -> np.polynomial.Polynomial:
    """Return the fitted baseline as a polynomial in the time from the first sample fitted."""
    return _baseline(separated.free, separated.fit)


def _baseline(free: Channel, fitted: Fit) -> np.polynomial.Polynomial:
    t = free.time - free.time[0]
    rest = free.value - fitted.residual - sum(fitted.part(t, i) for i in range(len(fitted.modes)))
    return np.polynomial.Polynomial.fit(t, rest, DEGREE)


def curvature(separated: Separated) -> float:
    """Return the root mean square of the second derivative of the fitted baseline, m/s²."""
    bend = drift(separated).deriv(2)(separated.t)
    return float(np.sqrt(np.mean(bend**2)))
