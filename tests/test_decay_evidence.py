"""Free decay, what is said of the records: every check by its closed form, every sentence whole, on stated releases."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf, log, pi, sqrt

import numpy as np
import pytest
from scipy import stats

from metrology.check import Check
from metrology.decay.decrement import Decrement, Filter
from metrology.decay.envelope import Extra, _mean, _verdict
from metrology.decay.evidence import checks, filter_words, notes
from metrology.decay.finding import DampingShape
from metrology.decay.modes import is_mains
from metrology.decay.oscillation import Fit, Mode
from metrology.decay.release import Release
from metrology.decay.separated import Separated
from metrology.gum.distributions import Normal
from metrology.gum.inputs import Component, Input
from metrology.timeseries import Channel

OMEGA = 100.0
T = np.arange(64) / 1000
VISCOUS = DampingShape("viscous", 1e-3, 5e-4, 2.0, 0.1, 0.3, 0.1, 3.0, 0.2, 4.0, 9.0, "As viscous damping.")


def release(
    zeta: float = 0.14, u: float = 1e-4, *, fitted: float = 0.14, bias: float = 1e-6, left: float = 1e-7, half: int = 30
) -> Release:
    """A release with ζ and u(ζ) by peaks, ζ by the direct fit (u = 3e-4) and residuals of a standard deviation."""
    delta = 2 * pi * zeta / sqrt(1 - zeta**2)
    u_delta = u / (4 * pi**2 / (4 * pi**2 + delta**2) ** 1.5)
    # λ = ζ·ω_n at ω_d = 100 rad/s; the covariance of (ω_d, λ) is one of λ alone, with ∂ζ/∂λ = ω_d²/(ω_d² + λ²)^{3/2}.
    rate = OMEGA * fitted / sqrt(1 - fitted**2)
    covariance = np.diag([0.0, (3e-4 * (OMEGA**2 + rate**2) ** 1.5 / OMEGA**2) ** 2])
    swing = left * np.where(np.arange(T.size) % 2, 1.0, -1.0)
    modes = (Mode(OMEGA, rate), Mode(2 * pi * 50.1, 0.0), Mode(2 * pi * 9.6, 0.5))
    fit = Fit(modes, "viscous", np.array([[3e-4, 4e-4], [0.0, 2e-6], [3e-6, 4e-6]]), covariance, swing, True, inf)
    channel = Channel("r", T, swing, "m")
    one, used = np.eye(3), (True,) * 3
    spread = np.diag([u_delta**2, 1e-4])
    by_peaks = Decrement(delta, OMEGA, spread, T[:3], np.ones(3), used, 1e-7, one, one, channel, 1.0)
    return Release(channel, Separated(channel, fit, 0.0, 1e-7), by_peaks, bias, Filter(np.zeros(2 * half + 1), 1.0))


def found(*releases: Release, shape: DampingShape = VISCOUS) -> dict[str, Check]:
    return {check.name: check for check in checks(releases, shape)}


def told(check: Check) -> tuple[bool | None, str]:
    return check.passed, check.sentence


def test_law_checks_come_in_the_order_of_the_evaluation() -> None:
    assert list(found(release())) == [
        "residuals of the direct fit",
        "effect of the filter on ζ",
        "log decrement against direct fit",
        "scatter between releases",
        "viscous damping",
    ]


@pytest.mark.parametrize(("left", "passed", "sentence"), [
    (1.29e-7, True, "The direct fit leaves 1.29 times the noise of the sensor (worst record): nothing of size is"
     " left over."),
    (1.31e-7, False, "The direct fit leaves 1.31 times the noise of the sensor (worst record): something in the"
     " record is not in the model."),
])  # fmt: skip
def test_closed_form_residuals_are_held_against_the_noise(left: float, passed: bool, sentence: str) -> None:
    check = found(release(left=1.1e-7), release(left=left), release(left=0.9e-7))["residuals of the direct fit"]
    assert told(check) == (passed, sentence)
    assert check.statistic == pytest.approx(left / 1e-7, rel=1e-12, abs=0)
    assert check.p_value is None


@pytest.mark.parametrize(("bias", "passed", "sentence"), [
    (-9e-6, True, "The fitted clean decay, passed through the same filter and peaks, comes out with a ζ that differs"
     " by -9.0e-06 (worst record), 0.09 of the standard uncertainty of one record."),
    (2e-5, False, "The fitted clean decay, passed through the same filter and peaks, comes out with a ζ that differs"
     " by +2.0e-05 (worst record), 0.2 of the standard uncertainty of one record: too much."),
])  # fmt: skip
def test_closed_form_effect_of_the_filter_is_held_against_u(bias: float, passed: bool, sentence: str) -> None:
    check = found(release(bias=1e-7), release(bias=bias), release(bias=5e-6))["effect of the filter on ζ"]
    assert told(check) == (passed, sentence)
    assert (check.statistic, check.p_value) == (bias, None)


def test_closed_form_two_ways_of_one_release() -> None:
    check = found(release(0.1405, 4e-4))["log decrement against direct fit"]
    z = 5e-4 / hypot(4e-4, 3e-4)
    assert check.statistic == pytest.approx(z, rel=1e-9, abs=0)
    assert check.p_value == pytest.approx(2 * stats.norm.sf(z), rel=1e-9, abs=0)
    assert told(check) == (True, "ζ by the log decrement less ζ by the direct fit is +5.0e-04 ± 5.0e-04 (standard"
                           " uncertainty): the two methods agree. The difference is within their noise.")  # fmt: skip


@pytest.mark.parametrize(("apart", "passed", "words"), [
    ((-1e-4, -2e-4, -3e-4), True, "-2.0e-04 ± 5.8e-05 (standard uncertainty): the two methods agree"),
    ((-1.8e-4, -2e-4, -2.2e-4), False, "-2.0e-04 ± 1.2e-05 (standard uncertainty): the two methods disagree"),
])  # fmt: skip
def test_twice_two_ways_of_three_releases(apart: tuple[float, ...], passed: bool, words: str) -> None:
    check = found(*(release(0.14 + d) for d in apart))["log decrement against direct fit"]
    expected = stats.ttest_1samp(apart, 0.0)
    assert (check.statistic, check.p_value) == pytest.approx((expected.statistic, expected.pvalue), rel=1e-8, abs=0)
    assert check.passed is passed
    assert words in check.sentence


def test_closed_form_scatter_between_releases_by_chi_squared() -> None:
    zeta, u = np.array([0.1400, 0.1402, 0.1397]), np.array([1e-4, 2e-4, 3e-4])
    check = found(*map(release, zeta, u))["scatter between releases"]
    mean = (zeta / u**2).sum() / (1 / u**2).sum()
    chi_squared = (((zeta - mean) / u) ** 2).sum()
    assert check.statistic == pytest.approx(chi_squared, rel=1e-8, abs=0)
    assert check.p_value == pytest.approx(stats.chi2.sf(chi_squared, 2), rel=1e-8, abs=0)
    assert told(check) == (
        True, "Over 3 releases ζ has a standard deviation of 2.5e-04, where noise gives 2.0e-04: noise explains it.",
    )  # fmt: skip


def test_planted_scatter_between_releases_is_told() -> None:
    check = found(release(0.1400), release(0.1410))["scatter between releases"]
    assert told(check) == (
        False, "Over 2 releases ζ has a standard deviation of 7.1e-04, where noise gives 1.0e-04: the releases differ"
        " in more than noise. The Type A uncertainty, taken from the scatter, contains that.",
    )  # fmt: skip


def test_limit_one_release_tells_nothing_of_scatter() -> None:
    assert found(release())["scatter between releases"] == Check(
        "scatter between releases", None, None, None, "One release only: nothing is known of the repeatability."
    )


@pytest.mark.parametrize(("dry", "quadratic"), [(2.0, 3.0), (3.0, 2.0)])
@pytest.mark.parametrize("verdict", ["viscous", "dry"])
def test_law_check_of_the_shape_is_its_verdict(dry: float, quadratic: float, verdict: str) -> None:
    shape = replace(VISCOUS, verdict=verdict, dry_z=dry, quadratic_z=quadratic)
    assert found(release(), shape=shape)["viscous damping"] == Check(
        "viscous damping", 3.0, None, verdict == "viscous", "As viscous damping."
    )


def test_law_what_was_filtered_is_told_with_lengths_and_effect() -> None:
    one, two = release(half=30, bias=-2e-6), release(half=40)
    told = (
        "Symmetric (zero-phase) FIR filter of {} ms: of each record the minimum-variance filter, which passes the"
        " longitudinal oscillation with gain one and lets through least of drift, noise and the other oscillations"
        " found in the record. It changes ζ of the fitted clean decay by 2e-06 at most."
    )
    assert filter_words([one, two]) == told.format("60 to 80")
    assert filter_words([one, one]) == told.format("60")


def test_law_notes_tell_how_the_result_came_about() -> None:
    mass = "The mass is that which oscillates: plate, released mass and a third of the mass of the sample."
    scale = Input("scale", 0.0, (Component("certificate", Normal(5e-3)),))
    once = "The scatter between releases contains the noise within each record, which is not added a second time."
    once += " Where it is no larger than that noise explains, the noise is the uncertainty."
    assert notes([release()], scale=scale) == (
        "One release only: its noise is all there is of Type A, and repeatability is not known. Release again.",
        mass,
        "The scale of the sensor (relative standard uncertainty 5.0e-03) cancels in every ratio of amplitudes: it"
        " enters neither δ, ζ nor ω_n.",
    )
    more = "With 3 releases the scatter has 2 degree(s) of freedom: more would pay."
    # Of a scale that nobody stated a figure of zero says nothing.
    assert len(notes([release()], scale=Input("scale", 0.0))) == 2
    assert notes([release()] * 3, scale=None) == (once, mass, more)
    assert notes([release()] * 2, scale=None)[2] == more.replace("3", "2").replace("has 2", "has 1")
    assert notes([release()] * 4, scale=None) == (once, mass)


def test_law_other_oscillations_are_told_with_their_sizes() -> None:
    apart = release().separated
    assert apart.describe(50.0) == "50.1 Hz (mains) of 2 µm, 9.6 Hz of 5 µm"
    alone = replace(apart, fit=replace(apart.fit, modes=apart.fit.modes[:1], coefficients=apart.fit.coefficients[:1]))
    assert alone.describe(50.0) == "no other oscillation"
    assert [is_mains(Mode(2 * pi * f, 0.0), 50.0) for f in (0.2, 49.4, 49.6, 99.6, 75.0)] == [
        False, False, True, True, False,
    ]  # fmt: skip


# ---------------------------------------------------------------- envelope

NUMBERS = "numbers"
CAUTION = " One ζ then does not describe the sample: it is a mean over the amplitudes of these records."
GAINS = "χ² falls by 80 with dry friction, by {} with quadratic drag."
SHAPES = {
    "neither": ((1.0, 2.0), (1.0, 4.0), 0.3, "viscous",
                "The envelope agrees with viscous damping: numbers; neither is significantly above zero."),
    "negligible": ((1.0, 9.0), (1.0, 80.0), 0.0299, "viscous",
                   "The envelope is that of viscous damping: numbers. What is significant is at most 3 % of the decay"
                   " rate at any amplitude used, and negligible."),
    "dry": ((9.0, 9.0), (80.0, 73.9), 0.03, "dry",
            "The envelope shows dry (Coulomb) friction: numbers. " + GAINS.format("73.9") + CAUTION),
    "quadratic": ((9.0, 9.0), (80.0, 86.1), 0.03, "quadratic",
                  "The envelope shows quadratic damping: numbers. " + GAINS.format("86.1") + CAUTION),
    "either": ((9.0, 9.0), (80.0, 86.0), 0.03, "not viscous",
               "The envelope is not that of viscous damping, but dry and quadratic damping cannot be distinguished: "
               "numbers. "
               + GAINS.format("86") + CAUTION),
}  # fmt: skip


@pytest.mark.parametrize("name", SHAPES)
def test_law_verdict_on_an_envelope_is_a_sentence(name: str) -> None:
    z, gains, share, verdict, sentence = SHAPES[name]
    dry, drag = (Extra(x, 1.0, gain, share) for x, gain in zip(z, gains, strict=True))
    assert _verdict(dry, drag, z, NUMBERS) == (verdict, sentence)


def test_limit_share_counts_only_of_what_is_significant() -> None:
    dry, drag = Extra(1.0, 1.0, 1.0, 0.9), Extra(9.0, 1.0, 80.0, 0.01)
    assert _verdict(dry, drag, (1.0, 9.0), NUMBERS)[0] == "viscous"
    assert _verdict(drag, dry, (9.0, 1.0), NUMBERS)[0] == "viscous"


def test_closed_form_mean_over_records_is_widened_by_their_scatter() -> None:
    one, two, three = Extra(1.0, 0.1, 5.0, 0.1), Extra(2.0, 0.2, 7.0, 0.3), Extra(-1.0, 0.4, 11.0, 0.2)
    mean = _mean([one, two, three])
    weight = np.array([100.0, 25.0, 6.25])
    expected = (weight @ [1.0, 2.0, -1.0]) / weight.sum()
    ratio = weight @ (np.array([1.0, 2.0, -1.0]) - expected) ** 2 / 2  # Birge
    assert mean.value == pytest.approx(expected, rel=1e-12, abs=0)
    assert mean.u == pytest.approx(sqrt(ratio / weight.sum()), rel=1e-12, abs=0)
    assert (mean.gain, mean.share) == pytest.approx((12.0, 0.2), rel=1e-12, abs=0)
    alone, alike = _mean([one]), _mean([one, replace(one, value=1.01)])
    assert (alone.value, alone.u, alone.gain) == pytest.approx((1.0, 0.1, 5.0), rel=1e-12, abs=0)
    assert alike.u == pytest.approx(0.1 / sqrt(2), rel=1e-12, abs=0)


def test_closed_form_release_reads_its_numbers_off_its_parts() -> None:
    one = release(fitted=0.2)
    assert one.fitted_zeta == pytest.approx(0.2, rel=1e-12, abs=0)
    assert one.fitted_delta == pytest.approx(2 * pi * 0.2 / sqrt(1 - 0.04), rel=1e-12, abs=0)
    sizes = replace(one.decrement, size=np.exp([-1.0, -2.0, -3.0]), used=(True, True, False))
    assert log(replace(one, decrement=sizes).least) == pytest.approx(-2)
    assert log(replace(one, decrement=replace(sizes, used=(True,) * 3)).least) == pytest.approx(-3)
