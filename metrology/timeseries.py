"""A read-only sampled channel: rate, filters without phase, extrema, spectrum, noise, and thinning for a drawing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import comb, pi, sqrt

import numpy as np
import numpy.typing as npt

from metrology.errors import Fault, MetrologyError

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Trace = Mapping[str, Floats]
"""Samples of one plot over time, for the screen: ``time`` in s, and columns on it by name; NaN is a gap."""
SCREEN = 100_000
"""Samples that a plot on the screen holds at most: a longer record is thinned, smallest and largest kept."""

_UNEVEN = 0.05  # of a sampling interval: what writing times with few digits may do, and a lost sample does not


@dataclass(frozen=True, eq=False)
class Channel:
    """One sampled quantity of one run, read-only.

    Parameters
    ----------
    name : str
        What the report calls it, such as ``"al-1100-decay-1.csv"``.
    time : array_like, shape (n,)
        Times of the samples in s, increasing.
    value : array_like, shape (n,)
        The quantity, in SI.
    unit : str
        SI unit of `value`, such as ``"m"``.

    Raises
    ------
    MetrologyError
        For times and values that are not finite, not of one length, or times that do not increase; every fault at
        once.
    """

    name: str
    time: npt.NDArray[np.float64]
    value: npt.NDArray[np.float64]
    unit: str = "1"

    def __post_init__(self) -> None:
        time, value = _frozen(self.time), _frozen(self.value)
        faults = tuple(_faults(self.name, time, value))
        if faults:
            raise MetrologyError(*faults)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "value", value)

    def __len__(self) -> int:
        return self.time.size

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, in s."""
        return float(self.time[-1] - self.time[0])

    @cached_property
    def step(self) -> float:
        """Usual sampling interval in s: the median, so that one gap does not make all other intervals look wrong."""
        return float(np.median(np.diff(self.time)))

    @cached_property
    def is_even(self) -> bool:
        """Whether no interval differs by more than 5 % from the usual one."""
        return bool(np.abs(np.diff(self.time) - self.step).max() <= _UNEVEN * self.step + 1e-9)

    @property
    def rate(self) -> float:
        """Sampling rate in Hz, of a channel sampled evenly.

        Raises
        ------
        MetrologyError
            Where an interval differs by more than 5 % from the usual one: a lost sample, or a clock that is not even.

        Examples
        --------
        >>> round(Channel("a", [0.0, 0.5, 1.0], [1.0, 2.0, 3.0]).rate, 12)
        2.0
        """
        steps, step = np.diff(self.time), self.step
        worst = int(np.argmax(abs(steps - step)))
        if not self.is_even:
            got = f"an interval of {steps[worst]:.6g} s after t = {self.time[worst]:.6g} s among others of {step:.6g} s"
            raise MetrologyError(
                Fault(self.name, got, "samples at one rate", "export the record again without gaps, or resample it")
            )
        return (self.time.size - 1) / self.duration

    def part(self, start: float, stop: float = np.inf) -> Channel:
        """Return the samples with start ≤ t ≤ stop (s)."""
        inside = (self.time >= start) & (self.time <= stop)
        return replace(self, time=self.time[inside], value=self.value[inside])


def _frozen(values: npt.ArrayLike) -> Floats:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def _faults(name: str, time: Floats, value: Floats) -> list[Fault]:
    if time.ndim != 1 or time.shape != value.shape or time.size < 2:
        got = f"{time.size} times and {value.size} values"
        return [Fault(name, got, "as many values as times, two at least")]
    found = []
    for what, array in (("time", time), ("value", value)):
        if not np.isfinite(array).all():
            first = int(np.argmin(np.isfinite(array)))
            found.append(Fault(name, f"{what} {array[first]} at sample {first + 1}", "finite numbers"))
    if not found and not (np.diff(time) > 0).all():
        first = int(np.argmax(np.diff(time) <= 0))
        found.append(Fault(name, f"t = {time[first + 1]} s after t = {time[first]} s", "times that increase"))
    return found


def filter_symmetric(channel: Channel, taps: npt.ArrayLike) -> Channel:
    """Filter with a symmetric (zero-phase) impulse response; samples without full support at either end are cut off.

    y_i = Σ_j h_j·x_{i+j}, j = −M … M, h_{−j} = h_j. Every oscillation e^{st}, decaying or not, comes out as
    H(s)·e^{st} with one constant H(s) = h_0 + 2·Σ h_j·cosh(s·j·Δt): no such filter touches its frequency or its
    decay rate.

    Parameters
    ----------
    channel : Channel
        Sampled evenly.
    taps : array_like, shape (2·M + 1,)
        Impulse response h, symmetric about its middle.

    Returns
    -------
    Channel
        Shorter by M samples at either end.

    Raises
    ------
    MetrologyError
        An impulse response of even length, not symmetric, or longer than the record.
    """
    response = np.asarray(taps, dtype=np.float64)
    half = response.size // 2
    if response.size % 2 == 0 or not np.allclose(response, response[::-1]) or channel.value.size < response.size:
        got = f"{response.size} taps for {channel.value.size} samples"
        raise MetrologyError(Fault(channel.name, got, "an odd, symmetric impulse response no longer than the record"))
    value = np.convolve(channel.value, response, mode="valid")
    return replace(channel, time=channel.time[half : channel.time.size - half], value=value)


def resample(channel: Channel, rate: float) -> Channel:
    """Return the channel at another rate (Hz), band-limited so that nothing is folded down (polyphase)."""
    from scipy.signal import resample_poly

    ratio = Fraction(rate / channel.rate).limit_denominator(1000)
    value = resample_poly(channel.value, ratio.numerator, ratio.denominator, padtype="line")
    step = ratio.denominator / ratio.numerator / channel.rate
    return replace(channel, time=channel.time[0] + step * np.arange(value.size), value=value)


def average(channel: Channel, count: int) -> Channel:
    """Return the means of blocks of `count` samples, each at the mean time of its block: a symmetric filter.

    Parameters
    ----------
    channel : Channel
        Sampled evenly.
    count : int
        Samples of a block; those left at the end are dropped.

    Returns
    -------
    Channel
        At 1/count of the rate.
    """
    blocks = channel.time.size // count
    time, value = (a[: blocks * count].reshape(blocks, count).mean(axis=1) for a in (channel.time, channel.value))
    return replace(channel, time=time, value=value)


@dataclass(frozen=True, eq=False)
class Extrema:
    """Extrema of a channel: `time` s and `value`, between the samples (quartic through five)."""

    time: Floats
    value: Floats


def peaks(channel: Channel, *, distance: float, floor: float = 0.0) -> Extrema:
    """Find the extrema of both signs: maxima above `floor` and minima below −`floor`, at least `distance` apart.

    Parameters
    ----------
    channel : Channel
        Sampled evenly, about zero.
    distance : float
        Least time between two maxima, and between two minima, in s.
    floor : float
        Least size, in the unit of the channel.

    Returns
    -------
    Extrema
        Times in s and values in the unit of the channel, between samples, by a quartic through five of them.
    """
    gap = max(1, round(distance * channel.rate))
    index = np.sort(np.concatenate([maxima(sign * channel.value, floor=floor, gap=gap) for sign in (1, -1)]))
    shift, value = _summits(channel.value, index[(index > 1) & (index < channel.value.size - 2)])
    return Extrema(shift / channel.rate + channel.time[0], value)


def _summits(value: Floats, index: npt.NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Return place (in samples) and value of the extrema at `index`, of the quartic through five samples."""
    a, b, c, d, e = (value[index + shift] for shift in range(-2, 3))
    first, second = (a - 8 * b + 8 * d - e) / 12, (-a + 16 * b - 30 * c + 16 * d - e) / 12
    third, fourth = (-a + 2 * b - 2 * d + e) / 2, a - 4 * b + 6 * c - 4 * d + e
    x = np.zeros(index.size)
    for _ in range(4):
        slope = first + x * (second + x * (third / 2 + x * fourth / 6))
        bend = second + x * (third + x * fourth / 2)
        x = np.clip(x - slope / np.where(bend == 0, np.inf, bend), -1.0, 1.0)
    return index + x, c + x * (first + x * (second / 2 + x * (third / 6 + x * fourth / 24)))


def maxima(value: Floats, *, floor: float, gap: int) -> npt.NDArray[np.intp]:
    """Return where a sequence has local maxima above `floor`, the highest within `gap` samples, in order.

    Parameters
    ----------
    value : ndarray, shape (n,)
        In any unit.
    floor : float
        In the unit of `value`.
    gap : int
        In samples.

    Returns
    -------
    ndarray of int, shape (m,)
        Indices.

    Examples
    --------
    >>> maxima(np.array([0.0, 2.0, 1.0, 3.0, 0.0, 1.0, 0.0]), floor=0.5, gap=3).tolist()
    [3]
    """
    middle = value[1:-1]
    found = 1 + np.flatnonzero((middle > value[:-2]) & (middle >= value[2:]) & (middle > floor))
    free, kept = np.ones(value.size, dtype=bool), []
    for i in found[np.argsort(-value[found], kind="stable")]:
        if free[i]:
            kept.append(i)
            free[max(i - gap + 1, 0) : i + gap] = False
    return np.sort(np.array(kept, dtype=np.intp))


def thinned(value: Floats, points: int = 4000) -> npt.NDArray[np.intp]:
    """Return the indices to draw: the least and the greatest sample of each of points/2 blocks; no spike is lost.

    Parameters
    ----------
    value : ndarray, shape (n,)
        In any unit.
    points : int
        Indices to keep, about.

    Returns
    -------
    ndarray of int, shape (m,)
        In order, with both ends.

    Examples
    --------
    >>> spike = np.zeros(100_000)
    >>> spike[77_777] = 1.0
    >>> 77_777 in thinned(spike)
    True
    """
    if value.size <= points:
        return np.arange(value.size)
    blocks = np.array_split(np.arange(value.size), points // 2 - 1)
    ends = np.array([0, value.size - 1])
    lows = [block[np.argmin(value[block])] for block in blocks]
    highs = [block[np.argmax(value[block])] for block in blocks]
    return np.unique(np.concatenate([ends, lows, highs]))


def spectrum(channel: Channel) -> tuple[Floats, Floats]:
    """Return frequency (Hz) and amplitude: a steady sine of amplitude a shows as a (Hann window, mean removed)."""
    window = np.hanning(channel.value.size)
    amplitude = abs(np.fft.rfft(window * (channel.value - channel.value.mean()))) * 2 / window.sum()
    return np.fft.rfftfreq(channel.value.size, 1 / channel.rate).astype(np.float64), amplitude


def periodogram(time: Floats, value: Floats, finer: int = 1) -> tuple[Floats, Floats]:
    """Return frequency (Hz) and power of values at any stamps (Hann window); white noise has its variance everywhere.

    Parameters
    ----------
    time, value : ndarray, shape (n,)
        Times in s, and values about zero; what is missing on even steps counts as zero.
    finer : int
        Times that the frequencies lie closer than those of the record, at least (zeros behind it); 1: they are those.

    Returns
    -------
    tuple of two ndarray, shape (m,)
        Frequencies in Hz, and power in the squared unit of `value`.
    """
    step, window = float(np.median(np.diff(time))), np.hanning(time.size)
    even = on_grid(time, window * value, step)
    size = even.size if finer == 1 else finer * 2 ** int(np.ceil(np.log2(even.size)))
    power = np.abs(np.fft.rfft(even, size)) ** 2 / float(window @ window)
    return np.fft.rfftfreq(size, step).astype(np.float64), power.astype(np.float64)


def noise(channel: Channel, order: int = 4) -> float:
    """Return the standard deviation of the white noise, from differences that a smooth signal does not survive.

    s = 1.4826·median|Δⁿx| / √C(2n, n); never below the q/√12 that rounding to multiples of q alone makes.

    Parameters
    ----------
    channel : Channel
        Where it is not sampled evenly, each value is compared with the cubic through its four neighbours.
    order : int
        n, the number of differences.

    Returns
    -------
    float
        In the unit of the channel.
    """
    if not channel.is_even:
        return max(1.4826 * float(np.median(abs(against_neighbours(channel)))), quantum(channel) / sqrt(12))
    differences = np.diff(channel.value, n=order)
    rounding = quantum(channel) / sqrt(12)
    return max(1.4826 * float(np.median(abs(differences))) / sqrt(comb(2 * order, order)), rounding)


def against_neighbours(channel: Channel) -> Floats:
    """Return what each value lies off the cubic through its four neighbours, over the factor that noise has there.

    For even steps this is the fourth difference over √70. The first and last two values are 0.

    Parameters
    ----------
    channel : Channel
        With any stamps; fewer than five samples give zeros.

    Returns
    -------
    ndarray, shape (n,)
        In the unit of the channel, of the standard deviation of its white noise.
    """
    t, y = channel.time, channel.value
    found = np.zeros(t.size)
    if t.size < 5:
        return found
    beside = (0, 1, 3, 4)
    places = [t[shift : t.size - 4 + shift] - t[2:-2] for shift in beside]
    weights = [
        np.prod([other / (other - own) for at, other in enumerate(places) if at != number], axis=0)
        for number, own in enumerate(places)
    ]
    cubic = sum(w * y[shift : t.size - 4 + shift] for w, shift in zip(weights, beside, strict=True))
    found[2:-2] = (y[2:-2] - cubic) / np.sqrt(1 + sum(w**2 for w in weights))
    return found


def on_grid(time: Floats, value: Floats, step: float) -> Floats:
    """Return values on even steps from the first time on, zero where there is none, for a spectrum.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Increasing, in s.
    value : ndarray, shape (n,)
        In any unit.
    step : float
        Of the grid, in s.

    Returns
    -------
    ndarray, shape (m,)
        In the unit of `value`.
    """
    places = np.round((time - time[0]) / step).astype(int)
    found = np.zeros(places[-1] + 1)
    found[places] = value
    return found


def quantum(channel: Channel) -> float:
    """Return the step q that all values are multiples apart, as a converter or a last digit leaves it, or 0.

    Parameters
    ----------
    channel : Channel
        With any stamps.

    Returns
    -------
    float
        q, in the unit of the channel.
    """
    levels = np.unique(channel.value)
    steps = np.diff(levels)
    steps = steps[steps > 1e-9 * max(abs(levels).max(), 1e-300)]
    if steps.size == 0:
        return 0.0
    step = float(steps.min())
    multiples = steps / step
    return step if bool((abs(multiples - np.round(multiples)) < 0.01).all()) else 0.0


def rounding_bias(noise: float, step: float) -> float:
    """Return the standard uncertainty of a mean of readings that rest, by rounding to multiples of `step` alone.

    What a reading at rest lies off a multiple is unknown, and the same for all of them: noise of standard deviation σ
    leaves q/(π√2)·√Σ exp(−(2πnσ/q)²)/n² of it (Widrow & Kollár, Quantization Noise (2008), 5.4): q/√12 without noise,
    less than a hundredth of that from σ = q/2 on.

    Parameters
    ----------
    noise : float
        Standard deviation of the readings, rounding included.
    step : float
        q, 0 where the readings are not rounded.

    Returns
    -------
    float
        In the unit of `noise`.
    """
    if step == 0.0:
        return 0.0
    before = max(noise**2 - step**2 / 12, 0.0) / step**2
    order = np.arange(1, 100)
    return step / (pi * sqrt(2)) * float(np.sqrt(np.sum(np.exp(-((2 * pi * order) ** 2) * before) / order**2)))
