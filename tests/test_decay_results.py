"""Free decay, from filter and peaks to inputs and what is drawn: second ways, closed forms, what each input says."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from scipy.special import stdtrit
from test_decay import AL, analysed, noise_only, record
from test_decay_evidence import release
from test_decay_separation import MAIN, RATE, swing

from metrology.decay import DecayTest
from metrology.decay.analysis import spread_of_mean
from metrology.decay.decrement import (
    FLOOR,
    _line,
    _usable,
    best_filter,
    bias,
    by_peaks,
    damping_ratio,
    design,
    line_through_peaks,
    log_decrement,
    rates,
)
from metrology.decay.envelope import _variance_near, extra, shape
from metrology.decay.oscillation import Mode, fit
from metrology.decay.release import drawn, evaluate, fitted_zeta_u, trace
from metrology.decay.separated import Separated
from metrology.decay.separation import separate
from metrology.decay.start import Unusable
from metrology.errors import MetrologyError
from metrology.gum.distributions import Normal
from metrology.gum.inputs import Component, Input
from metrology.gum.rounding import significant
from metrology.timeseries import Channel, filter_symmetric

T = np.arange(1000) / RATE


def apart(noise: float, residual: np.ndarray | None = None) -> Separated:
    """A clean decay of 1 m taken apart, with a noise and residuals as they are stated."""
    found = fit(T, swing(MAIN, T), [MAIN], lags=50)
    left = np.zeros(T.size) if residual is None else residual
    return Separated(Channel("r", T, swing(MAIN, T) + left, "m"), replace(found, residual=left), 0.0, noise)


# ---------------------------------------------------------------- filter


@pytest.mark.parametrize("drift", [0.0, 400.0])
def test_twice_filter_of_least_variance_by_lagrange(drift: float) -> None:
    """All 2M + 1 taps free: least Σh² + Σ(r·|H(s)|)² + (d·H″(0)/2)² under H(−λ ± iω) = 1 and H(0) = 0."""
    others, half = [(Mode(60.0, 0.6), 30.0), (Mode(300.0, 0.0), 5.0)], 40
    chosen = design(RATE, MAIN, others, half, drift=drift)
    j = np.arange(-half, half + 1) / RATE
    rows = [drift / 2 * j**2]
    for mode, size in others:
        both = np.cosh(complex(-mode.rate, mode.omega) * j) * size
        rows += [both.real, both.imag]
    power = np.eye(j.size) + np.array(rows).T @ np.array(rows)
    kept = np.cosh(complex(-MAIN.rate, MAIN.omega) * j)
    bound = np.array([kept.real, kept.imag, np.ones(j.size)])
    whole = np.block([[power, bound.T], [bound, np.zeros((3, 3))]])
    taps = np.linalg.solve(whole, np.concatenate([np.zeros(j.size), [1.0, 0.0, 0.0]]))[: j.size]
    np.testing.assert_allclose(chosen.taps, taps, atol=1e-9)
    assert chosen.passed == pytest.approx(sqrt(taps @ power @ taps), rel=1e-9, abs=0)
    assert chosen.half == half


def test_law_the_filter_chosen_is_the_shortest_near_the_best() -> None:
    for noise, rate in ((1e-3, 8.0), (1e-3, 30.0), (1e-5, 1.0)):
        mode = Mode(MAIN.omega, rate)
        separated = separate(
            Channel("r", T, swing(mode, T) + noise * np.random.default_rng(3).standard_normal(T.size)), mains=50.0
        )
        chosen = best_filter(separated)
        main, period = separated.fit.main, 2 * pi / separated.fit.main.omega
        cost = {}
        for n in (0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0):
            half = round(n * period * RATE)
            cost[half] = design(RATE, main, [], half).passed * np.exp(main.rate * half / RATE)
        near = [half for half, value in cost.items() if value <= 1.3 * min(cost.values())]
        assert chosen.half == min(near)


# ---------------------------------------------------------------- peaks


def test_closed_form_floor_is_five_times_the_noise_that_passes() -> None:
    quiet = apart(1e-3)
    chosen = design(RATE, MAIN, [], 30)
    found = by_peaks(quiet, chosen)
    sigma = 1e-3 * chosen.passed
    assert found.floor == pytest.approx(5 * sigma, rel=1e-9, abs=0)
    loud = apart(1e-9, 0.01 * np.random.default_rng(1).standard_normal(T.size))
    rest = filter_symmetric(replace(loud.free, value=loud.fit.residual), chosen.taps).value
    noisy = by_peaks(loud, chosen)
    assert noisy.floor == pytest.approx(5 * rest.std(), rel=1e-9, abs=0)
    # The derivative of what passes is at least ω times as large: u(t) = σ/(a·ω) then.
    a = found.size[: sum(found.used)]
    assert np.sqrt(np.diag(found.clock)) == pytest.approx(sigma / (a * quiet.fit.main.omega), rel=1e-9, abs=0)
    assert np.sqrt(np.diag(found.scatter)) == pytest.approx(sigma / a, rel=1e-9, abs=0)
    steep = 1e-2 * np.where(np.arange(T.size) % 2, 1.0, -1.0) * np.random.default_rng(2).standard_normal(T.size)
    far = by_peaks(apart(1e-9, steep), chosen)
    rest = filter_symmetric(replace(loud.free, value=steep), chosen.taps).value
    slope = max(np.diff(rest).std() * RATE, rest.std() * quiet.fit.main.omega)
    b = far.size[: sum(far.used)]
    assert np.sqrt(np.diag(far.clock)) == pytest.approx(slope / (b * quiet.fit.main.omega**2), rel=1e-6, abs=0)


def test_closed_form_decrement_of_a_clean_decay() -> None:
    chosen = design(RATE, MAIN, [], 30)
    found = by_peaks(apart(1e-6), chosen)
    assert found.delta == pytest.approx(log_decrement(8.0, MAIN.omega), rel=1e-6, abs=0)
    assert found.omega == pytest.approx(MAIN.omega, rel=1e-5)
    assert found.zeta == pytest.approx(8.0 / np.hypot(8.0, MAIN.omega), rel=1e-6, abs=0)
    share = 4 * pi**2 / (4 * pi**2 + found.delta**2) ** 1.5
    assert found.zeta_u == pytest.approx(share * sqrt(found.covariance[0, 0]), rel=1e-12, abs=0)
    # Weights a²/σ²: slope and its u of a line through correlated logarithms.
    count = sum(found.used)
    logs = np.log(found.size[:count])
    design_matrix = np.column_stack([np.ones(count), np.arange(count)])
    weight = np.diag(1 / np.diag(found.scatter))
    solve = np.linalg.inv(design_matrix.T @ weight @ design_matrix) @ design_matrix.T @ weight
    rest = logs - design_matrix @ solve @ logs
    inflate = max(1.0, rest @ weight @ rest / (count - 2))
    assert found.delta == pytest.approx(-2 * (solve @ logs)[1], rel=1e-9, abs=0)
    assert found.covariance[0, 0] == pytest.approx(
        4 * inflate * (solve @ found.scatter @ solve.T)[1, 1], rel=1e-9, abs=0
    )
    assert found.chi_squared == pytest.approx(rest @ weight @ rest, rel=1e-6, abs=0)
    timed = np.diag(1 / np.diag(found.clock))
    solve = np.linalg.inv(design_matrix.T @ timed @ design_matrix) @ design_matrix.T @ timed
    period, variance = (solve @ found.time[:count])[1], (solve @ found.clock @ solve.T)[1, 1]
    assert found.omega == pytest.approx(pi / period, rel=1e-12, abs=0)
    assert found.covariance[1, 1] == pytest.approx((pi / period**2) ** 2 * variance, rel=1e-9, abs=0)
    assert found.covariance[0, 1] == 0
    np.testing.assert_allclose(found.scatter, found.scatter.T, atol=1e-15)
    np.testing.assert_allclose(found.clock, found.clock.T, atol=1e-15)


def test_closed_form_scatter_beyond_the_noise_widens_the_decrement() -> None:
    """Logarithms that leave the line by more than their u: u(δ) grows by √(χ²/(n − 2))."""
    t = np.arange(2000) / RATE
    beat = swing(replace(MAIN, rate=0.5), t) * (1 + 0.1 * np.cos(11 * t))
    found = line_through_peaks(Channel("r", t, beat, "m"), np.eye(3)[1], MAIN.omega, sigma=1e-3, slope=1.0)
    count = sum(found.used)
    assert found.chi_squared > 50 * count
    _, variance, chi_squared = _line(np.log(found.size[:count]), found.scatter)
    assert found.covariance[0, 0] == pytest.approx(4 * variance * chi_squared / (count - 2), rel=1e-9, abs=0)


@pytest.mark.parametrize(("count", "refused"), [(2, True), (3, False)])
def test_refusal_fewer_than_three_peaks(count: int, refused: bool) -> None:
    mode = Mode(MAIN.omega, 40.0)
    sizes = np.exp(-40.0 * pi / MAIN.omega * np.arange(1, 5)) / sqrt(1 + (40.0 / MAIN.omega) ** 2)
    first = np.exp(-40.0 * (pi - np.arctan(40.0 / MAIN.omega)) / MAIN.omega) / np.exp(-40.0 * pi / MAIN.omega)
    sigma = first * sqrt(sizes[count - 1] * sizes[count]) / FLOOR
    channel = Channel("r", T, swing(mode, T), "m")
    if not refused:
        assert sum(line_through_peaks(channel, np.eye(3)[1], MAIN.omega, sigma=sigma, slope=1.0).used) == 3
        return
    with pytest.raises(Unusable) as caught:
        line_through_peaks(channel, np.eye(3)[1], MAIN.omega, sigma=sigma, slope=1.0)
    assert str(caught.value) == (
        f"Too few peaks: 2 over the noise floor of {5e6 * sigma:.3g} µm; 3 are needed. A larger release, less noise, or"
        " less of the other motions near the frequency of the decay would give more."
    )


def test_limit_peaks_count_as_long_as_they_alternate_in_time_and_are_large_enough() -> None:
    time, value = np.arange(6.0), np.array([8.0, -7.0, 6.0, -5.0, 4.0, -3.0])
    assert _usable(time, value, 1.0, 1.0) == 6
    assert _usable(time, value, 5.0, 1.0) == 3
    assert _usable(time, abs(value), 1.0, 1.0) == 1
    assert _usable(time + np.where(time > 3, 0.24, 0.0), value, 1.0, 1.0) == 6
    assert _usable(time + np.where(time > 3, 0.26, 0.0), value, 1.0, 1.0) == 4
    assert _usable(time - np.where(time > 2, 0.26, 0.0), value, 1.0, 1.0) == 3
    assert _usable(time, 0.0 * value, 1.0, 1.0) == 0


def test_closed_form_rates_of_stated_peaks() -> None:
    one = release().decrement
    time, size = np.array([0.1, 0.13, 0.17, 0.2]), np.array([8.0, 5.0, 3.0, 1.0])
    scatter = np.diag([1.0, 2.0, 3.0, 4.0]) + 0.25
    clock = np.diag([4.0, 3.0, 2.0, 1.0]) + 0.5
    stated = replace(one, time=time, size=size, used=(True, True, True, False), scatter=scatter, clock=clock)
    found = rates(stated)
    assert found.amplitude == pytest.approx([sqrt(24.0)])
    assert found.rate == pytest.approx([np.log(8 / 3) / 0.07])
    assert found.rate_u == pytest.approx([sqrt(1.25 + 3.25 - 2 * 0.25) / 0.07])
    assert found.omega == pytest.approx([2 * pi / 0.07])
    assert found.omega_u == pytest.approx([2 * pi / 0.07 * sqrt(4.5 + 2.5 - 2 * 0.5) / 0.07])
    many = 60
    long = replace(one, time=np.arange(many) * 0.02, size=np.exp(-0.1 * np.arange(many)), used=(True,) * many,
                   scatter=np.eye(many), clock=np.eye(many))  # fmt: skip
    found = rates(long)
    # Strides of 2·(60 // 24) peaks, a new pair every second peak.
    np.testing.assert_allclose(found.amplitude, np.exp(-0.1 * (np.arange(0, 56, 2) + 2)))
    np.testing.assert_allclose(found.rate, 0.4 / 0.08)


def test_twice_effect_of_a_filter_on_a_clean_decay() -> None:
    """What a filter that does nothing, and a long one, do to ζ of a clean decay: what its own peaks tell."""
    separated = apart(1e-4)
    for taps in (np.eye(3)[1], design(RATE, MAIN, [], 60).taps):
        found = line_through_peaks(filter_symmetric(separated.free, taps), taps, MAIN.omega, sigma=1e-4, slope=0.02)
        told = bias(separated, found, taps)
        count = sum(found.used)
        own = _line(np.log(found.size[:count]), found.scatter)[0]
        # The record is the clean decay itself, so that its own line tells the same.
        assert told == pytest.approx(damping_ratio(-2 * own) - damping_ratio(log_decrement(8.0, MAIN.omega)), abs=1e-9)
        assert 0 < abs(told) < 1e-5


# ---------------------------------------------------------------- the envelope's further causes


@pytest.mark.parametrize("form", ["dry", "quadratic"])
def test_planted_force_of_a_stated_envelope_with_its_u_and_its_share(form: str) -> None:
    """dA/dt = −λA − 2F/(πmω) − 4bωA²/(3πm): F = 4 N and b = 0.5 N·s²/m² on 2 kg, A(0) = 0.1 m."""
    m, omega, start = 2.0, 60.0, 0.1
    t = np.arange(3000) / RATE
    beta = 2 * 0.04 / (pi * m * omega) / start if form == "dry" else 4 * 0.5 * omega * start / (3 * pi * m)
    grown = (1 - np.exp(-0.5 * t)) / 0.5
    envelope = np.exp(-0.5 * t) - beta * grown if form == "dry" else np.exp(-0.5 * t) / (1 + beta * grown)
    sigma = 1e-5
    value = start * envelope * np.cos(omega * t) + sigma * np.random.default_rng(6).standard_normal(t.size)
    separated = Separated(Channel("r", t, value, "m"), fit(t, value, [Mode(omega, 1.0)], lags=50), 0.0, sigma)
    last = 0.04
    found = extra(separated, form, m, last)
    expected = 0.04 if form == "dry" else 0.5
    # The means of blocks of a 24th of a period have 0.997 of the amplitude.
    assert found.value == pytest.approx(expected, abs=4e-3 * expected + 5 * found.u)
    assert 0 < found.u < 0.02 * expected
    base = fit(t, value, [Mode(omega, 1.0)], lags=50).main.rate
    assert found.share == pytest.approx(beta / (last / start if form == "dry" else 1.0) / base, rel=0.02)
    # χ² falls by the squares that the exponential left over noise of variance σ² a sample.
    left = fit(t, value, [Mode(omega, 1.0)], lags=50).squares - sigma**2 * t.size
    assert found.gain == pytest.approx(left / sigma**2, rel=0.25)


def test_law_shape_of_two_records_tells_forces_ratios_shares_and_gains() -> None:
    t = np.arange(3000) / RATE
    records = []
    for seed in (1, 2):
        value = 0.1 * np.exp(-0.5 * t) * np.cos(60 * t) + 1e-4 * np.random.default_rng(seed).standard_normal(t.size)
        records.append(
            (Separated(Channel("r", t, value, "m"), fit(t, value, [Mode(60.0, 1.0)], lags=50), 0.0, 1e-4), 0.04)
        )
    found = shape(records, 2.0)
    dry, drag = ([extra(one, form, 2.0, last) for one, last in records] for form in ("dry", "quadratic"))
    for name, parts in (("dry_force", dry), ("quadratic", drag)):
        values, u = np.array([(one.value, one.u) for one in parts]).T
        mean = (values / u**2).sum() / (1 / u**2).sum()
        wide = sqrt(max(1.0, (((values - mean) / u) ** 2).sum()) / (1 / u**2).sum())
        short = name.removesuffix("_force")
        assert getattr(found, name) == pytest.approx(mean, rel=1e-9, abs=0)
        assert getattr(found, f"{name}_u") == pytest.approx(wide, rel=1e-9, abs=0)
        assert getattr(found, f"{short}_z") == pytest.approx(mean / wide, rel=1e-9, abs=0)
        assert getattr(found, f"{short}_share") == pytest.approx(np.mean([one.share for one in parts]), rel=1e-9, abs=0)
        assert getattr(found, f"gain_{short}") == pytest.approx(sum(one.gain for one in parts if one.value > 0))
    assert found.verdict == "viscous"
    dry, drag = (" ± ".join(significant(*pair)) for pair in (
        (1e3 * found.dry_force, 1e3 * found.dry_force_u), (found.quadratic, found.quadratic_u),
    ))  # fmt: skip
    assert found.sentence == (
        f"The envelope agrees with viscous damping: dry friction {dry} mN ({found.dry_z:+.1f} u), quadratic drag {drag}"
        f" N·s²/m² ({found.quadratic_z:+.1f} u) together with the viscous part; neither is significantly above zero."
    )


def test_closed_form_variance_near_the_mode_is_that_of_white_noise() -> None:
    found = fit(T, swing(MAIN, T), [MAIN], lags=50)
    white = replace(found, residual=0.3 * np.random.default_rng(4).standard_normal(100_000))
    assert _variance_near(white, RATE) == pytest.approx(0.09, rel=0.03)
    far = replace(found, residual=np.cos(2 * pi * 150 * np.arange(2000) / RATE))
    assert _variance_near(far, RATE) == pytest.approx(0.0, abs=1e-20)
    tone = replace(found, residual=np.cos(2 * pi * 30.0 * np.arange(2000) / RATE))
    # All of n/4 in one of the lines between 11.45 and 34.35 Hz, every half hertz.
    assert _variance_near(tone, RATE) == pytest.approx(500 / 46, rel=1e-6, abs=0)


# ---------------------------------------------------------------- inputs, and what is drawn


def test_law_inputs_of_several_releases_say_what_they_are() -> None:
    rigs = [replace(AL, zeta=zeta) for zeta in (0.139, 0.14, 0.142)]  # by more than noise: the decrement leads
    found = analysed(*(record(rig, np.random.default_rng(at), name=f"r{at}") for at, rig in enumerate(rigs)))
    records = found.finding.records
    delta, omega, mass = found.inputs
    assert (delta.name, delta.unit, delta.description) == (
        "d.log_decrement", "1", "logarithmic decrement δ, mean over the releases"
    )  # fmt: skip
    assert (omega.name, omega.unit, omega.description) == (
        "d.omega_d", "rad/s", "damped angular frequency ω_d, mean over the releases"
    )  # fmt: skip
    assert mass.name == "d.mass"
    assert delta.value == pytest.approx(np.mean([one.log_decrement for one in records]), rel=1e-12, abs=0)
    assert omega.value == pytest.approx(np.mean([one.omega_decrement for one in records]), rel=1e-12, abs=0)
    fitted = np.mean([2 * pi * one.zeta_fit / sqrt(1 - one.zeta_fit**2) for one in records])
    (two_ways,) = delta.components
    assert (two_ways.name, two_ways.kind, two_ways.source) == (
        "peaks against direct fit", "B", "difference between the two ways"
    )  # fmt: skip
    assert two_ways.distribution.name == "rectangular"
    assert two_ways.u == pytest.approx(abs(delta.value - fitted) / sqrt(3), rel=1e-6, abs=0)
    (two_ways,) = omega.components
    apart = np.mean([one.omega_decrement - one.omega_fit for one in records])
    assert two_ways.u == pytest.approx(abs(apart) / sqrt(3), rel=1e-6, abs=0)
    (ensemble,) = found.ensembles
    assert (ensemble.name, ensemble.source) == (
        "d releases", "scatter of 3 releases, noise within each record included"
    )  # fmt: skip
    assert [(one.name, one.unit, one.equation) for one in found.measurands] == [
        ("d.zeta", "1", "ζ = δ/√(4π² + δ²)"),
        ("d.omega_n", "rad/s", "ω_n = ω_d/√(1 − ζ²)"),
        ("d.c", "N·s/m", "c = 2·ζ·√(k·m)"),
        ("d.k", "N/m", "k_dyn = m·ω_n²"),
    ]
    assert (found.finding.mass, found.finding.significance, found.correlations) == (1.2, 0.01, {})


def test_limit_two_releases_have_a_scatter() -> None:
    rigs = [replace(AL, zeta=zeta, frequency=AL.frequency * zeta / 0.14) for zeta in (0.139, 0.14)]
    found = analysed(*(record(rig, np.random.default_rng(at), name=f"r{at}") for at, rig in enumerate(rigs)))
    (ensemble,) = found.ensembles
    pairs = np.array([(one.log_decrement, one.omega_decrement) for one in found.finding.records])
    np.testing.assert_allclose(ensemble.covariance, np.cov(pairs, rowvar=False) / 2, rtol=1e-6)
    assert ensemble.dof == 1


def test_law_releases_that_agree_by_chance_are_no_surer_than_their_noise() -> None:
    made = record(AL, np.random.default_rng(3))
    found = analysed(*(replace(made, name=name) for name in "abc"))
    assert found.ensembles == ()
    (one, *_) = found.finding.records
    # Both ways differ alike in each, so that their difference is added.
    within, _ = found.inputs[1].components
    assert within.u == pytest.approx(one.omega_fit_u / sqrt(3), rel=1e-9, abs=0)
    assert within.dof == pytest.approx(3 * analysed(made).inputs[0].components[0].dof)
    assert list(found.correlations) == [("d.log_decrement", "d.omega_d")]
    assert (within.name, within.kind, within.source) == (
        "noise within the record", "A", "mean over 3 records, which scatter by no more than it explains"
    )  # fmt: skip


def test_closed_form_means_of_which_one_scatters() -> None:
    noise = np.tile(np.diag([1.0, 4.0]), (3, 1, 1))
    # χ² = 2·1.2 and 2·0.01: one in three and nearly all are larger by noise alone.
    values = sqrt(1.2) * np.array([[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]) + [[0.0, 0.2], [0.0, 0.0], [0.0, -0.2]]
    scattered, scatter, within = spread_of_mean(values, noise)
    assert scattered == [0]
    np.testing.assert_allclose(scatter, [[1.2 / 3]])
    np.testing.assert_allclose(within, np.diag([1.0, 4.0]) / 3)
    # What scatters by no more than noise has that of the noise at least: S/σ² = 0.75, P(χ² > 1.5) = 0.47.
    scattered, scatter, _ = spread_of_mean(values * sqrt(0.75 / 1.2), noise)
    np.testing.assert_allclose(scatter, [[1.0 / 3]])
    # Where one differs by far more than noise, so may the other; it has its noise at least.
    scattered, scatter, _ = spread_of_mean(values * [10.0, 1.0], noise)
    assert scattered == [0, 1]
    np.testing.assert_allclose(np.diag(scatter), [120.0 / 3, 4.0 / 3])


@pytest.mark.long
@pytest.mark.parametrize("count", [3, 5])
@pytest.mark.parametrize("between", [0.0, 1.0, 2.0, 10.0])
def test_planted_interval_of_a_mean_holds_it_however_releases_differ(count: int, between: float) -> None:
    rng, noise, held, repetitions = np.random.default_rng([count, int(between)]), np.ones((count, 1, 1)), 0, 3000
    for values in sqrt(1 + between**2) * rng.standard_normal((repetitions, count, 1)):
        scattered, scatter, within = spread_of_mean(values, noise)
        variance = scatter[0, 0] if scattered else within[0, 0]
        assert variance >= 1 / count - 1e-12
        reach = stdtrit(count - 1, 0.975) if scattered else 1.96
        held += abs(values.mean()) <= reach * sqrt(variance)
    assert 0.935 < held / repetitions < 0.985


def test_law_one_release_with_a_clock_and_its_own_stiffness() -> None:
    clock = Input("clock", 0.0, (Component("certificate", Normal(1e-4)),))
    made, mass = record(AL, np.random.default_rng(9)), Input("d.mass", 1.2, unit="kg")
    from metrology import decay

    found = decay.analyse(DecayTest("d", (made,), mass, "d.k", clock=clock))
    assert [one.name for one in found.inputs] == ["d.log_decrement", "d.omega_d", "d.mass", "clock"]
    within = found.inputs[1].components[0]
    assert (within.name, within.kind, within.source) == (
        "noise within the record", "A", "one release only: no scatter known"
    )  # fmt: skip
    (one,) = found.finding.records
    assert within.u == pytest.approx(one.omega_fit_u, rel=1e-12, abs=0)
    # k comes before the c that it enters.
    assert [m.name for m in found.measurands] == ["d.zeta", "d.omega_n", "d.k", "d.c"]
    assert found.measurands[1].equation == "ω_n = ω_d/√(1 − ζ²)/(1 + δ_t)"


def test_limit_a_test_without_any_record_of_use() -> None:
    found = analysed(noise_only(np.random.default_rng(1)))
    assert found.finding.mass == 1.2
    assert found.finding.damping == "Not tested: no record could be evaluated."
    assert (found.finding.records, found.finding.checks, found.finding.filter) == ((), (), "")
    assert found.finding.equations[1] == "ζ = δ/√(4π² + δ²)"
    assert (found.ensembles, found.correlations, dict(found.traces)) == ((), {}, {})


def test_refusal_of_a_test_without_record_is_told_whole() -> None:
    with pytest.raises(MetrologyError) as caught:
        DecayTest("d", (), Input("d.mass", 1.0), "k")
    assert [str(fault) for fault in caught.value.faults] == [
        "d.readings: got no record; expected the record of one release at least"
    ]


def test_law_what_is_drawn_is_what_was_found() -> None:
    made = record(AL, np.random.default_rng(12))
    one = evaluate(made, separate(made, mains=50.0))
    shown, separated, fitted = drawn(one, mains=50.0), one.separated, one.separated.fit
    begin = separated.release
    late = made.time >= begin
    np.testing.assert_allclose(shown.time, made.time[late] - begin, atol=1e-12)
    np.testing.assert_array_equal(shown.displacement, made.value[late])
    t = made.time[late] - separated.free.time[0]
    a, b = fitted.coefficients[0]
    wave = np.exp(-fitted.main.rate * t) * (a * np.cos(fitted.main.omega * t) + b * np.sin(fitted.main.omega * t))
    np.testing.assert_allclose(shown.fit, wave, atol=1e-12)
    whole = np.zeros(t.size)
    whole[t >= -1e-12] = fitted.residual
    np.testing.assert_array_equal(shown.residual, whole)
    first = int(np.searchsorted(made.time[late], one.decrement.filtered.time[0] - 1e-9))
    count = one.decrement.filtered.time.size
    np.testing.assert_array_equal(shown.filtered[first : first + count], one.decrement.filtered.value)
    # Where the filter has no support: the record less all else that was fitted.
    unsupported = np.array(shown.filtered)[:first][t[:first] >= 0]
    own = (wave + whole)[:first][t[:first] >= 0]
    np.testing.assert_allclose(unsupported, own, atol=1e-9)
    assert shown.peak_time == pytest.approx(one.decrement.time - begin, abs=1e-12)
    assert shown.peak_amplitude == pytest.approx(one.decrement.size)
    assert shown.peak_used == one.decrement.used
    rate, omega = fitted.main.rate, fitted.main.omega
    assert shown.zeta_fit == pytest.approx(rate / np.hypot(rate, omega), rel=1e-9, abs=0)
    assert shown.omega_fit == omega
    assert (shown.fitted_from, shown.filtered_from) == pytest.approx(
        (separated.free.time[0] - begin, one.decrement.filtered.time[0] - begin), abs=1e-12
    )
    assert (shown.noise, shown.noise_floor, shown.count) == (separated.noise, one.decrement.floor, made.time.size)
    assert shown.filter_length == pytest.approx(2 * one.filter.half / 1000.0, rel=1e-9, abs=0)
    assert shown.omega_fit_u == pytest.approx(sqrt(fitted.covariance[0, 0]))
    assert shown.omega_decrement_u == pytest.approx(sqrt(one.decrement.covariance[1, 1]))
    assert shown.others == separated.describe(50.0)
    screen = trace(one)
    np.testing.assert_array_equal(screen["displacement"], made.value)
    np.testing.assert_allclose(screen["time"], made.time - begin, atol=1e-12)
    before = int((~late).sum())
    for name in ("filtered", "fit"):
        assert np.isnan(screen[name][:before]).all()
        np.testing.assert_array_equal(screen[name][before:], getattr(shown, name))


def test_twice_u_of_the_fitted_damping_ratio_by_differences() -> None:
    """ζ(ω, λ) = λ/√(λ² + ω²), both with u and a correlation."""
    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    found = replace(release().separated.fit, modes=(Mode(100.0, 14.0),), covariance=covariance)

    def zeta(omega: float, rate: float) -> float:
        return float(rate / np.hypot(rate, omega))

    h = 1e-4
    slope = np.array([zeta(100 + h, 14) - zeta(100 - h, 14), zeta(100, 14 + h) - zeta(100, 14 - h)]) / (2 * h)
    assert fitted_zeta_u(found) == pytest.approx(sqrt(slope @ covariance @ slope), rel=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("periods", [4, 8])
def test_law_the_interval_of_one_short_record_holds_the_true_value(periods: int) -> None:
    """Of 150 records of few periods with white noise; 1.96·u of its residuals alone held it in 85 % of four periods."""
    from metrology import decay

    t, rate, mass = np.arange(0, periods * 2 * pi / 30, 2e-3), 0.6, Input("d.mass", 1.0, unit="kg")
    omega = sqrt(30**2 - rate**2)
    true = 5e-3 * np.exp(-rate * t) * (np.cos(omega * t) + rate / omega * np.sin(omega * t))
    held = np.zeros(2)
    for seed in range(150):
        noise = 1e-5 * np.random.default_rng(seed).standard_normal(t.size)
        made = Channel("r", t, true + noise, "m")
        for at, exact in enumerate((2 * pi * rate / omega, omega)):
            one = decay.analyse(DecayTest("d", (made,), mass, "d.k")).inputs[at]
            (within,) = one.components
            held[at] += abs(one.value - exact) <= stdtrit(within.dof, 0.975) * within.u
    assert np.all(abs(held / 150 - 0.95) < 0.06)
