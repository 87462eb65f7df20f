"""Free decay: closed forms, an independent generator with contamination, planted kinds of damping, refusals."""

from __future__ import annotations

import gzip
import runpy
from dataclasses import dataclass, replace
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.stats import binom
from scipy.stats import t as student

from metrology import decay
from metrology.decay import DecayTest
from metrology.decay.correlated import sandwich
from metrology.decay.decrement import damping_ratio, design, log_decrement
from metrology.decay.oscillation import Mode, fit
from metrology.errors import MetrologyError
from metrology.gum.distributions import Normal
from metrology.gum.inputs import Component, Input
from metrology.timeseries import Channel

TAPES = Path(__file__).parents[1] / "campaigns" / "tapes"


@dataclass(frozen=True)
class Rig:
    """A plate on a line, and how a record of it is made: frequency in Hz, otherwise SI."""

    frequency: float = 22.9
    zeta: float = 0.14
    amplitude: float = 4e-4
    noise: float = 4e-7
    rate: float = 1000.0
    duration: float = 0.8
    mass: float = 1.2
    dry: float = 0.0  # N
    drag: float = 0.0  # N·s²/m²
    contaminated: bool = True
    mains: float = 2e-6


AL = Rig()
PEEK = Rig(frequency=6.2, zeta=0.004, amplitude=1.5e-3, rate=500.0, duration=8.0)


def motion(rig, time):
    """z of m·z″ + c·z′ + k·z + F·sign(z′) + b·|z′|·z′ = 0 from rest at the amplitude, by SciPy alone."""
    omega = 2 * pi * rig.frequency
    matrix = np.array([[0.0, 1.0], [-(omega**2), -2 * rig.zeta * omega]])
    if not (rig.dry or rig.drag):
        step, state, value = expm(matrix / rig.rate), np.array([rig.amplitude, 0.0]), np.empty(time.size)
        for i in range(time.size):
            value[i] = state[0]
            state = step @ state
        return value
    return swings(rig, time, omega)


def swings(rig, time, omega):
    """Integrate from turning point to turning point, so that dry friction never changes sign within an integration."""
    value, start, z = np.zeros(time.size), 0.0, rig.amplitude

    def turn(t, state):
        return state[1]

    turn.terminal = True
    while start < time[-1]:
        way = -np.sign(z)
        if omega**2 * abs(z) <= rig.dry / rig.mass or abs(z) < 1e-8 * rig.amplitude:
            value[time >= start] = z
            break

        def force(t, state, way=way):
            x, v = state
            return [v, -2 * rig.zeta * omega * v - omega**2 * x - (rig.dry * way + rig.drag * abs(v) * v) / rig.mass]

        push, turn.direction = 1e-9 * way * omega * abs(z), -way
        span = (start, min(time[-1], start + 2 / rig.frequency))
        part = solve_ivp(force, span, [z, push], "DOP853", dense_output=True, events=turn, rtol=1e-9, atol=1e-14)
        inside = (time >= start) & (time <= part.t[-1])
        value[inside] = part.sol(time[inside])[0]
        start, z = part.t[-1], part.y[0, -1]
    return value


def record(rig, generator, *, name="record", clip=None):
    """A record with 50 ms before the release, transverse, rocking, pendulum, mains, drift, noise, rounded to 0.1 µm."""
    time = np.arange(-round(0.05 * rig.rate), round(rig.duration * rig.rate)) / rig.rate
    free = np.maximum(time, 0.0)
    value = np.where(time < 0, rig.amplitude, 0.0)
    value[time >= 0] = motion(rig, time[time >= 0])
    phase = generator.uniform(0, 2 * pi, 6)
    if rig.contaminated:
        value += 4e-6 * np.exp(-0.6 * free) * np.sin(2 * pi * 9.6 * free + phase[0])
        value += 3e-6 * np.exp(-0.2 * free) * np.sin(2 * pi * 3.1 * free + phase[1])
        value += 15e-6 * np.cos(2 * pi * 0.288 * time + phase[2]) + 2e-5 + 2e-6 * time
        value += rig.mains * (
            np.cos(2 * pi * 50.02 * time + phase[3]) + 0.3 * np.cos(2 * pi * 150.06 * time + phase[4])
        )
    value += rig.noise * generator.standard_normal(time.size)
    if clip is not None:
        value = np.clip(value, -clip, clip)
    return Channel(name, time, np.round(value * 1e7) / 1e7, "m")


def analysed(*records, **options):
    return decay.analyse(DecayTest("d", records, Input("d.mass", 1.2, unit="kg"), "k", **options))


def values(analysis, k):
    known = {given.name: given.value for given in analysis.inputs} | {"k": k}
    for measurand in analysis.measurands:
        known[measurand.name] = measurand.function(known)
    return known


@pytest.mark.long
@pytest.mark.parametrize("rig", [AL, PEEK, replace(AL, frequency=40.0, zeta=0.3), replace(AL, zeta=0.02)])
def test_closed_form_clean_decay_gives_its_damping_back(rig):
    clean = replace(rig, contaminated=False, noise=0.0)
    time = np.arange(round(clean.duration * clean.rate)) / clean.rate
    omega = 2 * pi * clean.frequency
    damped, rate = omega * sqrt(1 - clean.zeta**2), clean.zeta * omega
    exact = clean.amplitude * np.exp(-rate * time) * (np.cos(damped * time) + rate / damped * np.sin(damped * time))
    found = analysed(Channel("exact", time, exact, "m"))
    result = values(found, 24734.25)
    assert result["d.zeta"] == pytest.approx(clean.zeta, rel=2e-4)
    assert result["d.omega_n"] == pytest.approx(omega, rel=1e-5)
    assert result["d.c"] == pytest.approx(2 * clean.zeta * sqrt(24734.25 * 1.2), rel=2e-4)
    assert result["d.k"] == pytest.approx(1.2 * omega**2, rel=2e-5)
    (one,) = found.finding.records
    assert one.zeta_fit == pytest.approx(clean.zeta, rel=1e-7)


def test_closed_form_decrement_and_damping_ratio_are_inverse():
    for zeta in (1e-4, 0.05, 0.14, 0.5):
        assert damping_ratio(log_decrement(zeta, sqrt(1 - zeta**2))) == pytest.approx(zeta, rel=1e-14)


def test_closed_form_filter_passes_its_mode_and_stops_what_is_large():
    main, other = Mode(142.0, 20.0), Mode(60.0, 0.6)
    chosen = design(2000.0, main, [(other, 1e4), (Mode(2 * pi * 50, 0.0), 1e4)], 110)
    j = np.arange(-chosen.half, chosen.half + 1) / 2000.0

    def gain(s):
        return (chosen.taps * np.exp(s * j)).sum()

    assert gain(complex(-20, 142)) == pytest.approx(1.0, abs=1e-9)
    assert abs(gain(0.0)) < 1e-9
    assert abs(gain(complex(-0.6, 60))) < 1e-3
    assert abs(gain(2j * pi * 50)) < 1e-3
    np.testing.assert_allclose(chosen.taps, chosen.taps[::-1], atol=1e-12)


def test_law_covariance_of_correlated_residuals():
    """The mean of an AR(1) sequence has the variance σ²·(1 + φ)/(1 − φ)/n, not σ²/n."""
    generator, phi, n = np.random.default_rng(3), 0.8, 40_000
    steps = generator.standard_normal(n)
    sequence = np.empty(n)
    sequence[0] = steps[0] / sqrt(1 - phi**2)
    for i in range(1, n):
        sequence[i] = phi * sequence[i - 1] + steps[i]
    variance = sandwich(np.ones((n, 1)), sequence, 100, np.full((n, 1), 1 / sqrt(n)))[0, 0]
    assert variance == pytest.approx(1 / (1 - phi) ** 2 / n, rel=0.15)


@pytest.mark.parametrize("form", ["dry", "quadratic"])
@pytest.mark.parametrize("rate", [0.0, 0.4])
def test_closed_form_extended_envelopes_solve_their_differential_equation(form, rate):
    mode = Mode(60.0, rate, 0.2)
    time = np.arange(2000) / 1000

    def slope(t, a):
        return -rate * a - (0.2 if form == "dry" else 0.2 * a**2)

    envelope = solve_ivp(slope, (0, 2), [1.0], t_eval=time, rtol=1e-10, atol=1e-12).y[0]
    found = fit(time, envelope * np.cos(60 * time), [replace(mode, rate=rate + 0.1, beta=0.1)], form=form, lags=50)
    assert found.main.rate == pytest.approx(rate, abs=1e-5)
    assert found.main.beta == pytest.approx(0.2, abs=1e-5)


def campaigns(count, size, generator, rig=AL, scatter=0.01):
    """Campaigns of several releases whose ζ and frequency scatter about those of the rig."""
    for _ in range(count):
        draws = 1 + scatter * generator.standard_normal((size, 2)) * [1.0, 0.1]
        rigs = [replace(rig, zeta=rig.zeta * z, frequency=rig.frequency * f) for z, f in draws]
        yield rigs, analysed(*(record(each, generator, name=f"r{i}") for i, each in enumerate(rigs)))


def interval(analysis, index):
    """Value, u and 95 % factor of δ or ω_d: scatter with its dof, Type B beside it (Welch–Satterthwaite)."""
    given, ensemble = analysis.inputs[index], analysis.ensembles[0]
    scatter, other = ensemble.covariance[index, index], given.u**2
    dof = ensemble.dof * ((scatter + other) / scatter) ** 2
    return given.value, sqrt(scatter + other), student.ppf(0.975, dof)


def covered(count, size, generator):
    hits, zs = np.zeros(2, int), []
    for rigs, found in campaigns(count, size, generator):
        assert not found.finding.failures
        true = log_decrement(AL.zeta, sqrt(1 - AL.zeta**2)), 2 * pi * AL.frequency * sqrt(1 - AL.zeta**2)
        for i in range(2):
            value, u, factor = interval(found, i)
            hits[i] += abs(value - true[i]) <= factor * u
        for one, rig in zip(found.finding.records, rigs, strict=True):
            zs.append(
                [(one.zeta_fit - rig.zeta) / one.zeta_fit_u, (one.zeta_decrement - rig.zeta) / one.zeta_decrement_u]
            )
    return hits, np.array(zs)


@pytest.mark.long
def test_planted_damping_is_recovered_with_calibrated_coverage():
    hits, zs = covered(24, 4, np.random.default_rng(20261120))
    low, high = binom.ppf([0.001, 0.9999], 24, 0.95)
    assert (hits >= low).all(), hits
    assert (hits <= high).all()
    rms = np.sqrt((zs**2).mean(axis=0))
    # Each record's own u: by direct fit, and by peaks (which add what of the other motions the filter lets through).
    assert 0.8 < rms[0] < 1.25
    assert 0.6 < rms[1] < 1.25


@pytest.mark.study
def test_planted_coverage_over_many_campaigns():
    hits, zs = covered(500, 5, np.random.default_rng(7))
    assert (hits >= 0.92 * 500).all()
    assert (hits <= 0.98 * 500).all()
    assert 0.9 < np.sqrt((zs[:, 0] ** 2).mean()) < 1.1


@pytest.mark.long
def test_twice_decrement_and_direct_fit_agree_on_many_cycles():
    found = analysed(*(record(PEEK, np.random.default_rng([4, i]), name=f"r{i}") for i in range(3)))
    for one in found.finding.records:
        assert one.zeta_fit == pytest.approx(0.004, abs=4 * one.zeta_fit_u)
        assert one.zeta_decrement == pytest.approx(one.zeta_fit, abs=4 * (one.zeta_decrement_u + one.zeta_fit_u))
        assert sum(one.peak_used) > 50
        assert one.filtered[-1] != 0


def test_limit_weak_signal_deep_in_noise_and_mains():
    weak = replace(PEEK, amplitude=6e-6, noise=1e-6, zeta=0.01, contaminated=True)
    found = analysed(record(weak, np.random.default_rng(11)), expected=2 * pi * 6.2)
    (one,) = found.finding.records
    assert one.zeta_decrement == pytest.approx(0.01, abs=4 * one.zeta_decrement_u)
    assert one.zeta_decrement_u > 1e-4


def test_law_stated_effect_of_the_filter_is_what_it_does():
    """A clean decay evaluated without contamination has the bias that the record says, and no more."""
    one = analysed(record(replace(AL, noise=1e-10), np.random.default_rng(2))).finding.records[0]
    assert abs(one.filter_bias) < 1e-5
    assert one.zeta_decrement - AL.zeta == pytest.approx(one.filter_bias, abs=3 * one.zeta_decrement_u)


def verdict(rig, seed, count=3):
    made = [record(rig, np.random.default_rng([seed, i]), name=f"r{i}") for i in range(count)]
    return analysed(*made).finding


@pytest.mark.long
@pytest.mark.parametrize("rig", [AL, PEEK])
def test_planted_dry_friction_is_told_with_its_force(rig):
    k = rig.mass * (2 * pi * rig.frequency) ** 2
    force = 0.004 * k * rig.amplitude if rig is PEEK else 0.01 * k * rig.amplitude
    found = verdict(replace(rig, dry=force, zeta=0.004 if rig is PEEK else 0.05), 21)
    assert found.shape.verdict == "dry"
    assert found.shape.dry_force == pytest.approx(force, rel=0.1)
    assert "dry (Coulomb) friction" in found.damping


@pytest.mark.long
def test_planted_quadratic_drag_is_told_with_its_coefficient():
    found = verdict(replace(PEEK, drag=1.0), 22)
    assert found.shape.verdict == "quadratic"
    assert found.shape.quadratic == pytest.approx(1.0, rel=0.1)


@pytest.mark.long
def test_planted_air_drag_too_small_to_matter_is_measured_and_called_negligible():
    found = verdict(replace(PEEK, drag=0.02), 23)
    assert found.shape.verdict == "viscous"
    assert found.shape.quadratic_z > 3.5
    assert "negligible" in found.damping


@pytest.mark.long
def test_planted_nothing_raises_no_alarm():
    assert [verdict(rig, seed, count=2).shape.verdict for rig in (AL, PEEK) for seed in range(30, 36)] == [
        "viscous"
    ] * 12


@pytest.mark.study
def test_planted_nothing_raises_no_alarm_in_many_tests():
    alarms = [
        verdict(rig, seed, count=3).shape.verdict != "viscous" for rig in (AL, PEEK) for seed in range(1000, 1150)
    ]
    assert sum(alarms) <= 3


@pytest.mark.long
def test_law_scatter_between_releases_is_counted_once():
    generator = np.random.default_rng(8)
    _, found = next(campaigns(1, 5, generator, scatter=0.02))
    (ensemble,) = found.ensembles
    pairs = np.array([(one.log_decrement, one.omega_decrement) for one in found.finding.records])
    np.testing.assert_allclose(ensemble.covariance, np.cov(pairs, rowvar=False) / 5)
    assert ensemble.dof == 4
    assert ensemble.members == ("d.log_decrement", "d.omega_d")
    assert [component.kind for given in found.inputs[:2] for component in given.components] == ["B", "B"]
    scatter = next(check for check in found.finding.checks if check.name == "scatter between releases")
    assert scatter.passed is False


def test_limit_one_release_has_only_the_noise_within():
    found = analysed(record(AL, np.random.default_rng(9)))
    (one,) = found.finding.records
    assert found.ensembles == ()
    delta, omega = found.inputs[:2]
    assert [component.name for component in delta.components] == ["noise within the record"]
    slope = 4 * pi**2 / (4 * pi**2 + delta.value**2) ** 1.5
    assert slope * delta.components[0].u == pytest.approx(one.zeta_fit_u, rel=1e-6)
    assert omega.u == pytest.approx(one.omega_fit_u, rel=1e-12)
    assert list(found.correlations) == [("d.log_decrement", "d.omega_d")]
    assert "Release again" in found.finding.notes[0]


@pytest.mark.long
def test_law_clock_changes_frequency_and_not_damping():
    clock = Input("vibrometer.clock", 0.01, (Component("certificate", Normal(1e-4)),))
    scale = Input("vibrometer.scale", 0.0, (Component("certificate", Normal(5e-3)),))
    made = record(AL, np.random.default_rng(10))
    plain, timed = values(analysed(made), 1e4), values(analysed(made, clock=clock, scale=scale), 1e4)
    assert timed["d.zeta"] == plain["d.zeta"]
    assert timed["d.omega_n"] == pytest.approx(plain["d.omega_n"] / 1.01, rel=1e-12)
    assert timed["d.k"] == pytest.approx(plain["d.k"] / 1.01**2, rel=1e-12)
    assert any("5.0e-03) cancels" in note for note in analysed(made, scale=scale).finding.notes)


def test_law_what_is_drawn_fits_together():
    one = analysed(record(AL, np.random.default_rng(12))).finding.records[0]
    assert len({len(one.time), len(one.displacement), len(one.filtered), len(one.fit), len(one.residual)}) == 1
    assert len(one.peak_time) == len(one.peak_amplitude) == len(one.peak_used)
    assert len({len(one.amplitude), len(one.rate), len(one.rate_u), len(one.frequency), len(one.frequency_u)}) == 1
    late = np.array(one.time) > one.filtered_from
    np.testing.assert_allclose(np.array(one.filtered)[late], np.array(one.fit)[late], atol=3e-6)
    assert one.rate[0] == pytest.approx(0.14 * 2 * pi * 22.9, rel=0.05)
    assert min(size for size, used in zip(one.peak_amplitude, one.peak_used, strict=True) if used) > one.noise_floor
    assert "mains" in one.others


def noise_only(generator):
    time = np.arange(2000) / 1000
    return Channel("r", time, 1e-6 * generator.standard_normal(2000), "m")


REFUSALS = {
    "noise": (noise_only(np.random.default_rng(1)), "Nothing oscillates|No decay is seen|Too few peaks"),
    "stuck": (Channel("r", np.arange(500) / 1000, np.linspace(0, 1e-6, 500), "m"), "Nothing oscillates"),
    "clipped": (record(replace(AL, zeta=0.02), np.random.default_rng(2), clip=2e-4), "is clipped"),
    "mains": (record(replace(AL, amplitude=2e-5, mains=4e-4), np.random.default_rng(3)), "Mains dominates"),
    "few": (record(replace(AL, zeta=0.2, noise=6e-5, contaminated=False), np.random.default_rng(4)), "Too few peaks"),
    "driven": (record(replace(PEEK, zeta=1e-7), np.random.default_rng(5)), "No decay is seen"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_refusal_is_a_sentence_and_not_a_number(case):
    made, words = REFUSALS[case]
    found = analysed(made)
    (sentence,) = found.finding.failures
    assert sentence.startswith("r")
    assert any(word in sentence for word in words.split("|")), sentence
    assert found.measurands == ()
    assert found.inputs == ()


def test_refusal_of_one_record_leaves_the_others():
    good = record(AL, np.random.default_rng(6), name="good")
    found = analysed(good, noise_only(np.random.default_rng(1)))
    assert [one.record for one in found.finding.records] == ["good"]
    assert len(found.finding.failures) == 1
    assert found.measurands


def test_refusal_all_faults_of_a_test_at_once():
    volts = Channel("r.csv", np.array([0.0, 1.0]), np.array([0.0, 1.0]), "V")
    with pytest.raises(MetrologyError) as caught:
        DecayTest("d", (volts,), Input("d.mass", 0.0), "k")
    assert [str(fault) for fault in caught.value.faults] == [
        "d r.csv: got readings in V; expected one of m, m/s, m/s², rad, rad/s, rad/s²",
        "d.mass: got 0 kg; expected a mass above zero, such as '1.196(1) kg'",
    ]
    with pytest.raises(MetrologyError, match="no record"):
        DecayTest("d", (), Input("d.mass", 1.0), "k")


def shipped(name):
    for path in sorted(TAPES.glob(f"{name}-decay-*.csv*")):
        data = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        columns = np.loadtxt(data.decode().splitlines(), delimiter=",", skiprows=1)
        yield Channel(path.name, columns[:, 0], 1e-6 * columns[:, 1], "m")


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "mass", "k", "digits", "expected"),
    [("al-1100", 1.196, 24734.25, 2, ("48.16", "14")), ("peek", 1.194, 1810.91, 3, ("0.370", "0"))],
)
def test_reference_shipped_records_give_the_published_damping(name, mass, k, digits, expected):
    test = DecayTest("d", tuple(shipped(name)), Input("d.mass", mass, unit="kg"), "k")
    found = decay.analyse(test)
    result = values(found, k)
    assert len(found.finding.records) == 5
    assert f"{result['d.c']:.{digits}f}" == expected[0]
    assert f"{100 * result['d.zeta']:.0f}" == expected[1]
    assert result["d.k"] == pytest.approx(k, rel=0.01)
    assert found.finding.shape.verdict == "viscous"


@pytest.mark.study
def test_twice_reconstruction_makes_the_shipped_files_again(tmp_path):
    made = runpy.run_path(str(TAPES / "reconstruct_decay.py"))
    made["main"](tmp_path)
    for path in sorted(tmp_path.iterdir()):
        assert path.read_bytes() == (TAPES / path.name).read_bytes(), path.name
