"""Free decay, its parts by themselves: lines in a spectrum, flat tops, peaks with their clock, verdicts."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.stats import norm, ttest_1samp
from test_decay import AL, analysed, record

from metrology.decay.decrement import by_peaks, rates
from metrology.decay.decrement import design as design_filter
from metrology.decay.envelope import ALARM, Extra, _verdict
from metrology.decay.modes import _mains_line, _others
from metrology.decay.oscillation import Mode, fit
from metrology.decay.separation import separate
from metrology.decay.start import Unusable
from metrology.decay.start import refuse_clipped as _refuse_clipped
from metrology.timeseries import Channel

RATE = 1000.0
T = np.arange(2000) / RATE


def test_closed_form_line_of_the_mains_is_found_within_its_width() -> None:
    for frequency in (49.6, 50.0, 50.3):
        swing = 3.0 + np.cos(2 * pi * frequency * T + 0.4) + 5 * np.exp(-4 * T) * np.cos(2 * pi * 22.9 * T)
        assert _mains_line(T, swing, 50.0).frequency == pytest.approx(frequency, abs=0.5 / 40)


def test_closed_form_frequency_of_another_oscillation_lies_between_the_lines_of_the_spectrum() -> None:
    noise = np.random.default_rng(1).standard_normal(T.size)
    main = fit(T, 1e3 * np.exp(-8 * T) * np.cos(2 * pi * 22.9 * T), [Mode(2 * pi * 22.9, 8.0)], lags=50)
    for frequency in (97.03, 97.11, 210.27):
        (found,) = _others(T, replace(main, residual=noise + 5 * np.cos(2 * pi * frequency * T)), [])
        # A bin is 0.12 Hz wide; noise leaves √6/(π·T·√n·A/σ) = 0.002 Hz, and the parabola through three logs its part.
        assert found.frequency == pytest.approx(frequency, abs=0.01)


def test_refusal_clipped_tops_wherever_they_stand() -> None:
    swing = np.sin(2 * pi * 10 * T) * np.exp(-0.5 * T)
    with pytest.raises(Unusable, match=r"samples in a row stand at 0\.9 m"):
        _refuse_clipped(Channel("r", T, np.minimum(swing, 0.9), "m"))
    with pytest.raises(Unusable, match=r"samples in a row stand at -0\.8 m"):
        _refuse_clipped(Channel("r", T, np.maximum(-swing, -0.8), "m"))
    # A flat end has no flank behind it by which it could be told from a rounded top.
    _refuse_clipped(Channel("r", T, np.minimum(1 - np.exp(-T), 1 - np.exp(-1.99)), "m"))


def taken(count: int) -> tuple[Channel, float, float]:
    """A clean decay of `count` half periods with ω = 2π·22.9/s and λ = 6/s."""
    omega, decay = 2 * pi * 22.9, 6.0
    t = np.arange(int(count * pi / omega * RATE)) / RATE
    noise = 1e-4 * np.random.default_rng(2).standard_normal(t.size)
    return Channel("r", t, np.exp(-decay * t) * np.cos(omega * t) + noise, "m"), omega, decay


def test_closed_form_rates_of_every_pair_of_peaks_of_one_sign() -> None:
    made, omega, decay = taken(24)
    separated = separate(made, mains=50.0)
    chosen = design_filter(RATE, separated.fit.main, [], 40)
    found = by_peaks(separated, chosen)
    told = rates(found)
    assert told.rate.size == sum(found.used) - 2  # peaks one period apart, one pair for each but the last two
    np.testing.assert_allclose(told.rate, decay, rtol=0.1)
    np.testing.assert_allclose(told.omega, omega, rtol=5e-3)


def test_twice_times_of_peaks_are_correlated_as_the_derivative_of_filtered_noise() -> None:
    """ρ(τ) = (2r(τ) − r(τ + 1/f_s) − r(τ − 1/f_s)) / (2r(0) − 2r(1/f_s)), r the autocorrelation of the taps."""
    made, _, _ = taken(24)
    separated = separate(made, mains=50.0)
    chosen = design_filter(RATE, separated.fit.main, [], 40)
    found = by_peaks(separated, chosen)
    r = np.pad(np.correlate(chosen.taps, chosen.taps, mode="full"), 2)
    bend = 2 * r[1:-1] - r[2:] - r[:-2]
    lags = (np.arange(bend.size) - bend.size // 2) / RATE
    time = found.time[: sum(found.used)]
    expected = np.interp(time[0] - time, lags, bend / bend.max(), left=0.0, right=0.0)
    deviation = np.sqrt(np.diag(found.clock))
    assert found.clock[0] / deviation[0] / deviation * (-1.0) ** np.arange(time.size) == pytest.approx(expected)


@pytest.mark.parametrize(("z", "gains", "verdict"), [
    ((9.0, 0.0), (80.0, 1.0), "dry"),
    ((0.0, 9.0), (1.0, 80.0), "quadratic"),
    ((9.0, 9.0), (80.0, 78.0), "not viscous"),
    ((9.0, 9.0), (78.0, 80.0), "not viscous"),
    ((ALARM, ALARM), (80.0, 1.0), "viscous"),
])  # fmt: skip
def test_limit_verdict_on_an_envelope(z: tuple[float, float], gains: tuple[float, float], verdict: str) -> None:
    dry, drag = (Extra(value, 1.0, gain, 0.3) for value, gain in zip(z, gains, strict=True))
    assert _verdict(dry, drag, z, "numbers")[0] == verdict


@pytest.mark.parametrize("seed", [9, 10])
def test_closed_form_two_ways_of_one_release_are_compared_on_both_sides(seed: int) -> None:
    checks = {check.name: check for check in analysed(record(AL, np.random.default_rng(seed))).finding.checks}
    found = checks["log decrement against direct fit"]
    assert found.statistic is not None
    assert found.p_value == pytest.approx(2 * norm.sf(abs(found.statistic)), rel=1e-12)


def test_closed_form_two_ways_of_several_releases_by_students_t() -> None:
    made = [record(AL, np.random.default_rng(seed)) for seed in (3, 4, 5)]
    found = analysed(*made).finding
    check = next(check for check in found.checks if check.name == "log decrement against direct fit")
    apart = np.array([one.zeta_decrement - one.zeta_fit for one in found.records])
    expected = ttest_1samp(apart, 0.0)
    assert check.statistic == pytest.approx(expected.statistic, rel=1e-9)
    assert check.p_value == pytest.approx(expected.pvalue, rel=1e-9)


def test_closed_form_two_ways_of_one_release_by_both_uncertainties() -> None:
    found = analysed(record(AL, np.random.default_rng(9))).finding
    (one,) = found.records
    check = next(check for check in found.checks if check.name == "log decrement against direct fit")
    u = np.hypot(one.zeta_decrement_u, one.zeta_fit_u)
    assert check.statistic == pytest.approx((one.zeta_decrement - one.zeta_fit) / u, rel=1e-6)


@pytest.mark.long
def test_planted_scatter_of_decrement_and_frequency_is_their_uncertainty() -> None:
    clean = replace(AL, contaminated=False, noise=4e-6, zeta=0.03)
    found = [analysed(record(clean, np.random.default_rng(seed))).finding.records[0] for seed in range(40)]
    for value, u in (("log_decrement", None), ("omega_decrement", "omega_decrement_u")):
        spread = np.std([getattr(one, value) for one in found], ddof=1)
        # ζ ≈ δ/2π for light damping; of 40 draws a standard deviation is known within a ninth.
        stated = [getattr(one, u) if u else 2 * pi * one.zeta_decrement_u for one in found]
        assert spread == pytest.approx(np.mean(stated), rel=0.45)


def test_law_results_carry_their_units() -> None:
    found = analysed(record(AL, np.random.default_rng(9)))
    assert {one.name: one.unit for one in found.measurands} == {
        "d.zeta": "1", "d.omega_n": "rad/s", "d.c": "N·s/m", "d.k": "N/m",
    }  # fmt: skip
