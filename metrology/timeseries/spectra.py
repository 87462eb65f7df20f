"""Spectrum of a channel, and power of values at any stamps."""

from __future__ import annotations

import numpy as np

from metrology.timeseries import Channel, Floats


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
