"""A sampled channel: rate, zero-phase filters, extrema, spectrum, noise, thinning."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from metrology import timeseries
from metrology.errors import MetrologyError
from metrology.timeseries import Channel, extrema, spectra, white_noise
from metrology.timeseries.spectra import periodogram


def sampled(function, *, rate=1000.0, duration=2.0, name="channel"):
    time = np.arange(round(duration * rate)) / rate
    return Channel(name, time, function(time), "m")


def test_refusal_every_fault_of_a_channel_at_once():
    with pytest.raises(MetrologyError) as caught:
        Channel("a.csv", np.array([0.0, np.nan, 2.0]), np.array([1.0, 2.0, np.inf]))
    assert [str(fault) for fault in caught.value.faults] == [
        "a.csv: got time nan at sample 2; expected finite numbers",
        "a.csv: got value inf at sample 3; expected finite numbers",
    ]


@pytest.mark.parametrize(
    ("time", "value", "message"),
    [
        ([0.0, 1.0, 1.0], [0.0, 0.0, 0.0], "t = 1.0 s after t = 1.0 s"),
        ([0.0, 1.0], [0.0], "2 times and 1 values"),
        ([0.0], [0.0], "1 times and 1 values"),
    ],
)
def test_refusal_times_that_do_not_fit(time, value, message):
    with pytest.raises(MetrologyError, match=message):
        Channel("a", np.array(time), np.array(value))


def test_law_a_channel_is_read_only_and_keeps_its_own_copy():
    source = np.array([1.0, 2.0, 3.0])
    channel = Channel("a", np.array([0.0, 1.0, 2.0]), source)
    source[0] = 9.0
    assert channel.value[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        channel.value[0] = 5.0


def test_refusal_a_lost_sample_is_named():
    time = np.delete(np.arange(100) / 1000, 40)
    with pytest.raises(MetrologyError, match=r"an interval of 0\.002 s after t = 0\.039 s among others of 0\.001 s"):
        _ = Channel("a", time, time).rate


def test_limit_times_written_with_few_digits_still_have_a_rate():
    time = np.round(np.arange(3000) / 3000, 5)  # 1/3000 s is no multiple of 10 µs
    assert Channel("a", time, time).rate == pytest.approx(3000, rel=1e-4)


def test_closed_form_a_symmetric_filter_multiplies_a_decaying_oscillation_by_one_constant():
    s = complex(-20.0, 140.0)
    record = sampled(lambda t: np.exp(s.real * t) * np.cos(s.imag * t), duration=0.5)
    taps = np.hanning(43)
    filtered = timeseries.filter_symmetric(record, taps)
    j = np.arange(-21, 22)
    gain = (taps * np.exp(s * j / record.rate)).sum()  # H(s), straight from the definition
    expected = (gain * np.exp(s * filtered.time)).real
    assert filtered.time[0] == record.time[21]
    np.testing.assert_allclose(filtered.value, expected, atol=1e-12)


@pytest.mark.parametrize("taps", [[1.0, 2.0], [1.0, 2.0, 3.0], np.ones(5001)])
def test_refusal_filters_that_are_not_symmetric_or_too_long(taps):
    with pytest.raises(MetrologyError, match="symmetric"):
        timeseries.filter_symmetric(sampled(np.sin), taps)


def test_limit_butterworth_bends_the_decay_rate_of_a_high_damping():
    """Why the evaluation of decays does not use it: at ζ = 0.14 a band of one octave is 2.7 % wrong."""
    rate, omega = 20.1, 142.4
    record = sampled(
        lambda t: np.where(t >= 0.1, np.exp(-rate * (t - 0.1)) * np.cos(omega * (t - 0.1)), 1.0), duration=0.6
    )
    sections = butter(2, [16.0, 32.0], "bandpass", output="sos", fs=record.rate)
    filtered = replace(record, value=sosfiltfilt(sections, record.value))
    found = extrema.peaks(filtered.part(0.1), distance=0.02)
    slope = np.polyfit(found.time[:6], np.log(abs(found.value[:6])), 1)[0]
    assert abs(-slope / rate - 1) > 0.02


def test_closed_form_peaks_of_both_signs_between_the_samples():
    rate, omega = 3.0, 2 * np.pi * 7.3
    record = sampled(lambda t: np.exp(-rate * t) * np.cos(omega * t), duration=1.0)
    found = extrema.peaks(record, distance=0.05, floor=1e-3)
    first = (np.pi - np.arctan(rate / omega)) / omega  # where the derivative vanishes
    times = first + np.pi / omega * np.arange(found.time.size)
    np.testing.assert_allclose(found.time, times, atol=1e-8)
    np.testing.assert_allclose(found.value, np.exp(-rate * times) * np.cos(omega * times), rtol=1e-8)


def test_closed_form_spectrum_shows_the_amplitude_of_a_sine():
    record = sampled(lambda t: 0.25 * np.sin(2 * np.pi * 60 * t) + 3.0)
    frequency, amplitude = spectra.spectrum(record)
    top = int(np.argmax(amplitude))
    assert frequency[top] == pytest.approx(60)
    assert amplitude[top] == pytest.approx(0.25, rel=1e-3)


def test_law_resampling_keeps_a_slow_signal_and_folds_nothing_down():
    record = sampled(lambda t: np.sin(2 * np.pi * 8 * t) + np.sin(2 * np.pi * 240 * t), duration=3.0)
    slow = timeseries.resample(record, 250.0)
    assert slow.rate == pytest.approx(250)
    middle = slice(100, 600)
    np.testing.assert_allclose(slow.value[middle], np.sin(2 * np.pi * 8 * slow.time)[middle], atol=5e-3)


def test_law_block_means_keep_a_decay_rate_exactly():
    record = sampled(lambda t: np.exp(-4.0 * t))
    means = timeseries.average(record, 7)
    assert len(means) == 2000 // 7
    np.testing.assert_allclose(np.diff(np.log(means.value)), -4.0 * 0.007, rtol=1e-10)


def test_planted_spike_survives_thinning():
    value = np.sin(np.linspace(0, 60, 50_000))
    value[31_337] = 40.0
    index = timeseries.thinned(value)
    assert 31_337 in index
    assert index[0] == 0
    assert index[-1] == 49_999
    assert index.size <= 4000
    assert (np.diff(index) > 0).all()
    assert value[index].min() == value.min()


@pytest.mark.parametrize("sigma", [1e-3, 0.2])
def test_law_noise_is_found_under_a_signal(sigma):
    white = np.random.default_rng(5).normal(0.0, sigma, 20_000)
    time = np.arange(20_000) / 1000
    assert white_noise.noise(Channel("a", time, white + np.sin(30 * time))) == pytest.approx(sigma, rel=0.03)


def test_limit_noise_is_never_below_that_of_rounding():
    record = sampled(lambda t: np.round(np.sin(t) * 50) / 50)
    assert white_noise.quantum(record) == pytest.approx(0.02)
    assert white_noise.noise(record) == pytest.approx(0.02 / np.sqrt(12))


@pytest.mark.long
@pytest.mark.parametrize("sigma", [0.0, 0.1, 0.2, 0.3])
def test_twice_the_mean_of_rounded_readings_is_off_by_the_bias_of_rounding(sigma):
    rng = np.random.default_rng(3)
    at = rng.uniform(-0.5, 0.5, 4000)
    off = np.round(at[:, None] + sigma * rng.standard_normal((4000, 2000))).mean(axis=1) - at
    assert white_noise.rounding_bias(np.hypot(sigma, 12**-0.5), 1.0) == pytest.approx(off.std(), rel=0.04)


@pytest.mark.parametrize("function", [np.zeros_like, lambda t: np.random.default_rng(1).normal(size=t.size)])
def test_limit_no_quantum_where_none_is(function):
    assert white_noise.quantum(sampled(function)) == 0.0


@pytest.mark.parametrize("finer", [1, 4])
def test_closed_form_periodogram_of_white_noise_is_its_variance_and_of_a_line_its_energy(finer):
    t = np.arange(4000) / 500.0
    f, power = periodogram(t, 3.0 * np.random.default_rng(1).standard_normal(t.size), finer)
    assert f[-1] == pytest.approx(250.0)
    assert np.mean(power) == pytest.approx(9.0, rel=0.1)
    # a²/4·(Σw)²/Σw² = a²·n/6 for a Hann window; an eighth of a step beside the line it is 1.3 % less.
    assert np.max(periodogram(t, np.sin(100.0 * np.pi * t), finer)[1]) == pytest.approx(4000 / 6, rel=0.02)
