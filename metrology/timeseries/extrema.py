"""Extrema of a channel, between its samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from metrology.timeseries import Channel, Floats


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
