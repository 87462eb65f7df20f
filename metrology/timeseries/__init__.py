"""A read-only sampled channel: rate, filters without phase, and thinning for a drawing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

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
