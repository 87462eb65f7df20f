"""Noise of a channel as it is: level and colour, estimated from residuals, and the filter that makes it white."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Marks = NDArray[np.bool_]

ORDER = 3
"""Terms of ln S(ω) beside its mean (Bloomfield, Biometrika 60 (1973) 217): smooth colours, no lines."""
BANDS = 20
"""Bands of frequency over whose medians the spectrum is smoothed."""
TAPS = 24
"""Length of the filter: noise whose memory is longer than that is no colour but a drift."""
FAINT = 1e-6
"""Part of the first tap below which the last ones change no digit that is printed."""
CACHED = 2**16
"""Numbers that are filtered at a time."""
FEW = 4 * BANDS
"""Readings below which no colour is estimated: fewer than two values of the spectrum would fall into a band."""
PLACES = 4
"""Decimal places of the coefficients: 10⁶ readings tell them to 1e-3."""
BESIDE = 5
"""Readings whose median a single one is set beside, to see whether it is a spike."""
OUTLYING = 7.0
"""Distance in standard uncertainties from which a single reading among good neighbours is an outlier."""
HARDLY = 0.3
"""Part of the power of noise that has to be left at a frequency to say how much there was."""
FAR = 5.0
"""Standard deviations beyond which a single reading is drawn in before the spectrum is taken."""


@dataclass(frozen=True)
class Colour:
    """Level and whitening filter of the noise of one channel.

    Parameters
    ----------
    level : float
        Standard deviation of the innovation: of what the readings before do not predict.
    filter : ndarray, shape (TAPS,) at most
        Impulse response; filtered noise is white with standard deviation 1.
    """

    level: float
    filter: Array

    @property
    def deviation(self) -> float:
        """Standard deviation of the noise, what the readings before predict of it included."""
        response = np.abs(np.fft.rfft(self.filter, 1024))
        return math.sqrt(float(np.mean(response[1:-1] ** -2.0)))

    def whitened(self, rows: Array) -> Array:
        """Filter along the first axis, shape (n, …) → (n, …)."""
        found: Array = self.filter[0] * rows
        # Some rows at a time, which stay in the processor's cache from tap to tap.
        step = max(CACHED // max(math.prod(rows.shape[1:]), 1), 1)
        for first in range(0, len(rows), step):
            last = min(first + step, len(rows))
            for delay, tap in enumerate(self.filter[1:last], start=1):
                begun = max(first, delay)
                found[begun:last] += tap * rows[begun - delay : last - delay]
        return found


WHITE = Colour(1.0, np.ones(1))
"""White noise of unit size."""


def outlying(residual: Array) -> Marks:
    """Which single readings are far off among good neighbours: spikes, drop-outs, reflections.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        In standard deviations of the noise.

    Returns
    -------
    ndarray of bool, shape (n,)
        True where a reading is an outlier.
    """
    far = np.abs(residual)
    beside = np.maximum(np.roll(far, 1), np.roll(far, -1))
    found: Marks = (far > OUTLYING) & (beside < 0.5 * far)
    return found


def spikes(values: Array, noise: float = 0.0) -> Marks:
    """Single readings far off among their neighbours, by what these scatter by and by the noise that is stated.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Readings, without gaps.
    noise : float
        Standard deviation of one, in the same unit, below which nothing is far off.

    Returns
    -------
    ndarray of bool, shape (n,)
        True where a reading is far off.
    """
    from scipy.ndimage import median_filter

    off = values - median_filter(values, BESIDE, mode="mirror")
    return outlying(off / max(1.4826 * float(np.median(np.abs(off))), noise, 1e-300))


def colour(parts: Sequence[Array], floor: float = 0.0, taken: Sequence[Array] = ()) -> Colour:
    """Level and colour of noise from the residuals of several records of one channel.

    ln S(ω) = c₀ + Σ cₙ·cos(nω), n ≤ 3, through the medians of the periodogram over 20 bands: structure that a model
    leaves stands in few bands, which weigh little. The filter has the frequency response 1/√S and the least delay:
    exp(−c₀/2 − ½Σ cₙ·e^(−inω)).

    Parameters
    ----------
    parts : sequence of ndarray
        Residuals, evenly sampled; zero where a reading does not count.
    floor : float
        Level below which the noise is not estimated: what is stated of it, or what rounding leaves.
    taken : sequence of ndarray, shape (n, q), optional
        Orthonormal columns that were taken out of all records, by record: noise that lies along them is not in the
        residuals any more, at low frequencies most of it where a record holds few periods.

    Returns
    -------
    Colour
        Level in the unit of the residuals, and the whitening filter, shape (taps,).
    """
    seen = [part[part != 0.0] for part in parts]
    count = sum(len(part) for part in seen)
    if count == 0:
        return WHITE
    everything = np.concatenate(seen)
    scale = float(np.median(np.abs(everything))) / 0.6745 or float(np.std(everything)) or 1.0
    free = count - sum(float(np.sum(columns**2)) for columns in taken)
    if free < FEW:
        level = max(float(np.sqrt(np.sum(everything**2) / max(free, 1.0))), floor, 1e-300)
        return Colour(level, np.array([1.0 / level]))
    omega, power = _periodograms([np.clip(part, -FAR * scale, FAR * scale) for part in parts], taken)
    c = _bloomfield(omega, power)
    # A tenth of what even 10⁶ readings tell; it is then the same on every processor.
    c = np.round(c, PLACES)
    c[0] = max(c[0], 2 * math.log(max(floor, 1e-300)))
    return Colour(math.exp(0.5 * c[0]), _minimum_phase(c))


def _periodograms(parts: Sequence[Array], taken: Sequence[Array]) -> tuple[Array, Array]:
    """Frequencies / rad a reading and powers of all records, tapered; scaled to the variance of white noise.

    White noise of variance 1 leaves 1 − Σ|q̂|² of its power at a frequency, with q̂ the tapered columns that were taken
    out; where that is less than `HARDLY`, nothing is known of it.
    """
    omega, power = [], []
    for at, part in enumerate(parts):
        taper = np.hanning(len(part) + 2)[1:-1] * (part != 0.0)
        weight = float(taper @ taper)
        if weight > 0:
            found = np.abs(np.fft.rfft(part * taper)) ** 2 / weight
            left = np.ones(len(found))
            if taken:
                left -= power_of(taper[:, None] * taken[at]) / weight
            known = left > HARDLY
            known[0] = False
            omega.append(np.linspace(0.0, math.pi, len(found))[known])
            power.append(found[known] / left[known])
    return np.concatenate(omega), np.concatenate(power)


def power_of(columns: Array) -> Array:
    """Squares of the Fourier transforms of some columns by frequency, added up.

    Two real columns are transformed as one complex one, of whose two halves the squares add up to those of both.

    Parameters
    ----------
    columns : ndarray, shape (n, q)
        Real.

    Returns
    -------
    ndarray, shape (n // 2 + 1,)
        From frequency 0 on, in the square of the columns' unit.
    """
    count = len(columns)
    even = columns if columns.shape[1] % 2 == 0 else np.column_stack([columns, np.zeros(count)])
    turned = np.fft.fft(np.ascontiguousarray(even).view(complex), axis=0).view(float)
    whole = np.einsum("nq,nq->n", turned, turned)
    at = np.arange(count // 2 + 1)
    return np.asarray(0.5 * (whole[at] + whole[-at]))


def _bloomfield(omega: Array, power: Array) -> Array:
    """Coefficients c₀ … c₃ through the medians of the bands, bands far off the curve weighing less."""
    edges = np.linspace(0.0, math.pi, BANDS + 1)
    band = np.clip(np.searchsorted(edges, omega) - 1, 0, BANDS - 1)
    rows = [(float(np.mean(omega[band == at])), float(np.median(power[band == at]))) for at in range(BANDS)
            if (band == at).sum() >= 2]  # fmt: skip
    at, median = np.array(rows).T
    # The median of χ²(2)/2 is ln 2.
    log_power = np.log(np.maximum(median, 1e-300) / math.log(2))
    columns = np.cos(np.outer(at, np.arange(ORDER + 1)))
    weight, found = np.ones(len(at)), np.zeros(ORDER + 1)
    for _ in range(10):
        found = np.linalg.solve(columns.T @ (weight[:, None] * columns) + 1e-9 * np.eye(ORDER + 1),
                                columns.T @ (weight * log_power))  # fmt: skip
        off = np.abs(log_power - columns @ found)
        weight = 1.0 / np.maximum(1.0, off / (2.0 * float(np.median(off)) + 0.02))
    return np.asarray(found, dtype=float)


def _minimum_phase(c: Array) -> Array:
    """Taps of exp(−c₀/2 − ½Σ cₙ·zⁿ), by the recursion for the exponential of a power series."""
    half = np.zeros(TAPS)
    half[1 : ORDER + 1] = -0.5 * c[1:]
    taps = np.zeros(TAPS)
    taps[0] = 1.0
    for m in range(1, TAPS):
        taps[m] = sum(n * half[n] * taps[m - n] for n in range(1, min(m, ORDER) + 1)) / m
    last = np.flatnonzero(np.abs(taps) > FAINT)[-1]
    return np.asarray(taps[: last + 1] * math.exp(-0.5 * c[0]), dtype=float)
