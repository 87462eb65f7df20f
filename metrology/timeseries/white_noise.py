"""White noise of a channel, and what rounding to multiples of a step leaves."""

from __future__ import annotations

from math import comb, pi, sqrt

import numpy as np

from metrology.timeseries import Channel, Floats


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
