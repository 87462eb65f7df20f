import numpy as np
import pytest

from metrology.estimation.noise import estimate, resolution


@pytest.mark.parametrize("step", [0.0, 1e-3, 5e-3])
def test_closed_form_noise_under_motion_and_rounding(step):
    rng = np.random.default_rng(1)
    t = np.arange(12_000) / 200
    y = 20 * np.abs(np.sin(3.0 * t)) ** 3 + 5e-3 * rng.standard_normal(t.size)
    y = np.round(y / step) * step if step else y
    assert estimate(y).u == pytest.approx(np.hypot(5e-3, step / np.sqrt(12)), rel=0.025)


def test_limit_rounding_that_hides_the_noise():
    y = np.round(np.sin(np.arange(4000) / 300) / 0.01) * 0.01
    assert estimate(y).u == pytest.approx(0.01 / np.sqrt(12), rel=0.4)


def test_law_outliers_and_gaps_do_not_matter():
    rng = np.random.default_rng(3)
    y = 0.1 * rng.standard_normal(5000)
    y[::50] += 30.0
    y[7::90] = np.nan
    assert estimate(y).u == pytest.approx(0.1, rel=0.2)


def test_limit_too_few_readings():
    assert estimate(np.arange(10.0)) is None


def test_closed_form_resolution():
    rng = np.random.default_rng(1)
    assert resolution(np.round(rng.standard_normal(3000) / 0.02) * 0.02) == pytest.approx(0.02)
    assert resolution(rng.standard_normal(3000)) == 0.0
