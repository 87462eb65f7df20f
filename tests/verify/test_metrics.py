import numpy as np
import pytest

from metrology.verify import METRICS, excess
from metrology.verify.metrics import combined, magnitude, peak_error, phase_error, r_squared, ringing, rms

T = np.arange(20_000) / 1000
WAVE = np.sin(2 * np.pi * T)


def test_closed_form_magnitude_ignores_phase_and_phase_ignores_magnitude():
    shifted = 1.2 * np.sin(2 * np.pi * T - 0.3)
    assert magnitude(WAVE, shifted) == pytest.approx(0.2, abs=1e-9)
    assert phase_error(WAVE, shifted) == pytest.approx(0.3 / np.pi, abs=1e-9)
    assert combined(WAVE, shifted) == pytest.approx(np.hypot(0.2, 0.3 / np.pi), abs=1e-9)


def test_closed_form_rms_r_squared_and_peak():
    assert rms(WAVE, WAVE + 0.1) == pytest.approx(0.1)
    assert r_squared(WAVE, 0.5 * WAVE) == pytest.approx(0.75)
    assert peak_error(WAVE, -1.5 * WAVE) == pytest.approx(0.5)


def test_limit_every_metric_of_a_perfect_model():
    for name, metric in METRICS.items():
        assert metric(WAVE, WAVE) == pytest.approx(1.0 if name == "r_squared" else 0.0, abs=1e-7)


def test_closed_form_frequency_and_decay_of_a_swing():
    rng = np.random.default_rng(1)
    t = np.arange(2000) / 200
    found = ringing(t, 0.6 + 2.0 * np.exp(-0.15 * t) * np.cos(2.6 * t + 1.0) + 0.01 * rng.standard_normal(2000), 2.4)
    assert abs(found.omega - 2.6) < 4 * found.omega_u
    assert abs(found.rate - 0.15) < 4 * found.rate_u
    assert found.omega_u < 1e-3


def test_limit_noise_shows_no_swing():
    rng = np.random.default_rng(2)
    assert ringing(np.arange(2000) / 200, rng.standard_normal(2000), 2.4) is None


def test_limit_a_reading_that_stands_still_shows_no_swing():
    assert ringing(np.arange(200) / 50, np.full(200, 0.087), 2.4) is None


def test_law_slow_part_of_white_noise_stays_small_and_a_small_offset_shows():
    rng = np.random.default_rng(3)
    assert np.mean([excess(rng.standard_normal(3000)) > 5 for _ in range(400)]) < 0.02
    assert excess(rng.standard_normal(3000) + 0.2) > 5


@pytest.mark.parametrize("seed", range(40))
def test_limit_a_reading_that_only_grows_ends_without_a_swing(seed):
    rng = np.random.default_rng(seed)
    t = np.arange(200) / 50
    for y in (np.exp(30 * (t - 4)) + 1e-3 * rng.standard_normal(200), rng.standard_normal(200).cumsum()):
        found = ringing(t, y, rng.uniform(3, 60))
        assert found is None or np.isfinite([found.omega, found.omega_u, found.rate, found.rate_u]).all()
