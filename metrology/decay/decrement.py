"""Logarithmic decrement: zero-phase filter, peaks, and the line through the logarithms of the peaks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np

from metrology.decay.oscillation import Floats, Mode
from metrology.decay.separated import Separated, curvature
from metrology.decay.start import Unusable
from metrology.message import said
from metrology.timeseries import Channel, filter_symmetric
from metrology.timeseries.extrema import peaks

FLOOR = 5.0
"""Peaks smaller than this many standard deviations of the filtered noise are not used."""

GONE = 350.0
"""Ln of what a mode grows or falls to along a filter, from which on there is nothing of it to stop: half of that of the
largest number, so that its square is a number."""
FEWEST = 3
"""Fewest peaks (maxima and minima) from which a decrement is taken."""


@dataclass(frozen=True)
class Decrement:
    """Log decrement δ and damped angular frequency ω_d (rad/s) of one record, by the peaks of the filtered signal.

    `covariance` of (δ, ω_d); `time`, `size` of all peaks, `used` which entered; `scatter`: covariance of the
    logarithms of the peaks used, `clock`: covariance of their times (s²).
    """

    delta: float
    omega: float
    covariance: Floats
    time: Floats
    size: Floats
    used: tuple[bool, ...]
    floor: float
    scatter: Floats
    clock: Floats
    filtered: Channel
    chi_squared: float

    @property
    def zeta(self) -> float:
        """Damping ratio, ζ = δ/√(4π² + δ²)."""
        return damping_ratio(self.delta)

    @property
    def zeta_u(self) -> float:
        """Standard uncertainty of ζ, (4π²/(4π² + δ²)^{3/2})·u(δ)."""
        return float(4 * pi**2 / (4 * pi**2 + self.delta**2) ** 1.5 * sqrt(self.covariance[0, 0]))


def damping_ratio(delta: float) -> float:
    """Return the damping ratio ζ = δ/√(4π² + δ²) of a log decrement.

    Examples
    --------
    >>> round(damping_ratio(0.8883953), 6)
    0.14
    """
    return delta / sqrt(4 * pi**2 + delta**2)


def log_decrement(rate: float, omega: float) -> float:
    """Return the log decrement δ = 2π·λ/ω_d of a decay rate λ and a damped angular frequency ω_d."""
    return 2 * pi * rate / omega


@dataclass(frozen=True)
class Filter:
    """Taps of a symmetric filter; `passed`: what it lets through of noise and other oscillations, over the noise."""

    taps: Floats
    passed: float

    @property
    def half(self) -> int:
        """Taps on either side of the middle."""
        return self.taps.size // 2


def design(rate: float, main: Mode, others: Sequence[tuple[Mode, float]], half: int, *, drift: float = 0.0) -> Filter:
    """Return the symmetric filter of 2·half + 1 taps that passes one mode unchanged and least of everything else.

    Of all h with h_{−j} = h_j it has the least P² = Σ h_j² + Σ_l (r_l·|H(s_l)|)² + (d·H″(0)/2)² under H(−λ + iω) = 1
    and H(0) = 0, where H(s) = h_0 + 2·Σ h_j·cosh(s·j/f_s): white noise, every other oscillation and the curvature of
    the drift in proportion to their sizes (the minimum-variance filter; Capon, Proc. IEEE 57 (1969) 1408).

    Parameters
    ----------
    rate : float
        Sampling rate f_s, Hz.
    main : Mode
        The mode to pass: with gain one and phase zero.
    others : sequence of (Mode, float)
        What to stop, each with its amplitude over the standard deviation of the noise, r_l.
    half : int
        Taps on either side of the middle.
    drift : float
        Second derivative of the baseline over the noise, d in 1/s².
    """
    j = np.arange(half + 1)
    double = np.where(j == 0, 1.0, sqrt(2.0))  # h_j = w_j/√2 for j > 0 makes |w| the norm of all taps
    rows = [drift / 2 * (j / rate) ** 2]
    for mode, size in others:
        response = size * np.cosh(complex(-mode.rate, mode.omega) / rate * j)
        rows += [response.real, response.imag]
    stop = double * np.array(rows)
    kept = np.cosh(complex(-main.rate, main.omega) / rate * j)
    wanted = double * np.array([kept.real, kept.imag, np.ones(half + 1)])
    power = np.eye(half + 1) + stop.T @ stop
    eased = np.linalg.solve(power, wanted.T)
    w = eased @ np.linalg.solve(wanted @ eased, [1.0, 0.0, 0.0])
    side = w[1:] / sqrt(2.0)
    return Filter(np.concatenate([side[::-1], w[:1], side]), float(np.sqrt(max(w @ power @ w, 0.0))))


def best_filter(separated: Separated) -> Filter:
    """Return the filter whose length leaves the first peaks with nearly most signal over noise.

    Longer filters pass less, but the decay goes on while they wait for full support: e^{λ·t_half}·P is the measure,
    and the shortest filter within a factor 1.3 of its least value is taken, since it keeps more of the decay.
    """
    fit, free = separated.fit, separated.free
    rate, period = free.rate, 2 * pi / fit.main.omega
    longest = (free.value.size - 1) // 6
    noise = max(separated.noise, 1e-7 * float(fit.amplitudes[0]))
    drift = curvature(separated) / noise
    halves = sorted({min(longest, max(4, round(n * period * rate))) for n in (0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0)})
    # A mode beyond Nyquist's frequency, or gone within a reading or two, is one of noise; its cosine has no end.
    others = [(mode, size / noise) for mode, size in fit.others
              if mode.omega < pi * rate and abs(mode.rate) * halves[-1] < GONE * rate]  # fmt: skip
    designs = [design(rate, fit.main, others, half, drift=drift) for half in halves]
    cost = np.array([found.passed * np.exp(fit.main.rate * found.half / rate) for found in designs])
    return designs[int(np.argmax(cost <= 1.3 * cost.min()))]


def by_peaks(separated: Separated, chosen: Filter) -> Decrement:
    """Return the log decrement by the line through the logarithms of all usable peaks, weighted by their noise.

    ln a_i = ln a_0 − (δ/2)·i and t_i = t_0 + (π/ω_d)·i, i counting maxima and minima in turn.

    Raises
    ------
    Unusable
        When fewer than three peaks stand above the noise floor.
    """
    taps, noise = chosen.taps, separated.noise
    filtered = filter_symmetric(separated.free, taps)
    rest = filter_symmetric(replace(separated.free, value=separated.fit.residual), taps).value
    sigma = max(float(rest.std()), noise * chosen.passed)
    # What passes is narrow-band about the mode: its derivative is not far from ω times as large.
    slope = max(float(np.diff(rest).std()) * separated.free.rate, sigma * separated.fit.main.omega)
    return line_through_peaks(filtered, taps, separated.fit.main.omega, sigma=sigma, slope=slope)


def line_through_peaks(filtered: Channel, taps: Floats, omega: float, *, sigma: float, slope: float) -> Decrement:
    """Return the decrement of a filtered record; `sigma` (m): u of its samples, `slope` (m/s): of their derivative."""
    half_period = pi / omega
    found = peaks(filtered, distance=1.2 * half_period)
    size, count = abs(found.value), _usable(found.time, found.value, FLOOR * sigma, half_period)
    if count < FEWEST:
        raise Unusable(
            said(
                "Too few peaks: {count} over the noise floor of {floor:.3g} µ{unit}; {least} are needed. A larger "
                "release, less noise, or less of the other motions near the frequency of the decay would give more.",
                count=int(count),
                floor=float(1e6 * FLOOR * sigma),
                unit=filtered.unit,
                least=FEWEST,
            )
        )
    time, a, sign = found.time[:count], size[:count], np.sign(found.value[:count])
    scatter = sigma**2 * _correlation(time, taps, filtered.rate) * np.outer(sign / a, sign / a)
    steeper = np.diff(taps, prepend=0, append=0)
    weight = slope / (a * omega**2) * sign
    clock = _correlation(time, steeper, filtered.rate) * np.outer(weight, weight)
    logs, times = _line(np.log(a), scatter), _line(time, clock)
    inflate = max(1.0, logs[2] / max(count - 2, 1))
    omega_d = pi / times[0]
    covariance = np.diag([4 * logs[1] * inflate, (omega_d**2 / pi) ** 2 * times[1]])
    used = tuple(i < count for i in range(size.size))
    return Decrement(
        delta=-2 * logs[0],
        omega=omega_d,
        covariance=covariance,
        time=found.time,
        size=size,
        used=used,
        floor=FLOOR * sigma,
        scatter=scatter,
        clock=clock,
        filtered=filtered,
        chi_squared=logs[2],
    )


def _usable(time: Floats, value: Floats, floor: float, half_period: float) -> int:
    """Return how many peaks from the first on stand above the floor, alternate in sign and come half a period apart."""
    good = abs(value) > floor
    good[1:] &= (abs(np.diff(time) / half_period - 1) < 0.25) & (value[1:] * value[:-1] < 0)
    return int(np.argmin(good)) if not good.all() else good.size


def _correlation(time: Floats, taps: Floats, rate: float) -> Floats:
    """Return the correlation of white noise filtered by `taps` between the given times, shape (n, n)."""
    autocorrelation = np.correlate(taps, taps, mode="full")
    lags = (np.arange(autocorrelation.size) - (taps.size - 1)) / rate
    apart = time[:, None] - time[None, :]
    matrix = np.interp(apart.ravel(), lags, autocorrelation / autocorrelation.max(), left=0.0, right=0.0)
    correlation: Floats = matrix.reshape(apart.shape)
    return correlation


def _line(y: Floats, covariance: Floats) -> tuple[float, float, float]:
    """Return slope, its variance with all covariances, and χ² of the line through y_0, y_1, … (weights 1/variance)."""
    index = np.arange(y.size, dtype=np.float64)
    weight = 1 / np.diag(covariance)
    x = index - (weight @ index) / weight.sum()
    share = weight * x / (weight @ x**2)
    slope = float(share @ y)
    rest = y - (weight @ y) / weight.sum() - slope * x
    return slope, float(share @ covariance @ share), float(weight @ rest**2)


def bias(separated: Separated, decrement: Decrement, taps: Floats) -> float:
    """Return ζ of the fitted clean decay after the same filter, peaks and line, less its own ζ."""
    main = separated.fit.main
    clean = replace(separated.free, value=separated.fit.part(separated.t))
    filtered = filter_symmetric(clean, taps)
    count = sum(decrement.used)
    sigma = decrement.floor / FLOOR
    last = float(decrement.time[count - 1]) + 0.25 * pi / main.omega
    # The same peaks: the clean decay has further ones below the noise of the record.
    again = line_through_peaks(filtered.part(-np.inf, last), taps, main.omega, sigma=1e-6 * sigma, slope=sigma)
    sizes = np.log(again.size[:count])
    slope, _, _ = _line(sizes, decrement.scatter[: sizes.size, : sizes.size])
    return damping_ratio(-2 * slope) - damping_ratio(log_decrement(main.rate, main.omega))


@dataclass(frozen=True)
class Rates:
    """Decay rate λ (1/s) and angular frequency (rad/s) against amplitude (m), from pairs of peaks, with u."""

    amplitude: Floats
    rate: Floats
    rate_u: Floats
    omega: Floats
    omega_u: Floats


def rates(decrement: Decrement) -> Rates:
    """Return λ = ln(a_i/a_j)/(t_j − t_i) and ω = π·(j − i)/(t_j − t_i) of peaks of one sign, against √(a_i·a_j)."""
    count = sum(decrement.used)
    stride = min(2 * max(1, count // 24), 2 * ((count - 1) // 2))
    i = np.arange(0, count - stride, max(stride // 2, 1))
    j = i + stride
    apart = decrement.time[j] - decrement.time[i]
    a, b = decrement.size[i], decrement.size[j]

    def u(covariance: Floats) -> Floats:
        variance = covariance[i, i] + covariance[j, j] - 2 * covariance[i, j]
        return np.sqrt(np.maximum(variance, 0.0))

    omega = pi * stride / apart
    return Rates(
        np.sqrt(a * b), np.log(a / b) / apart, u(decrement.scatter) / apart, omega, omega * u(decrement.clock) / apart
    )
