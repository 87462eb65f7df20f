"""Free decays as laboratories have them: heavily damped, gaps, uneven stamps, spikes, coloured noise, angles."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from rig_folder import run, shown, sought
from scipy.integrate import solve_ivp
from scipy.signal import lfilter
from truth_decay import Decaying, swing

from metrology import decay
from metrology.campaign.load import load
from metrology.chain import evaluate as evaluated
from metrology.decay import DecayTest
from metrology.decay.envelope import _variance_near
from metrology.decay.oscillation import Mode, fit
from metrology.decay.outliers import masked
from metrology.decay.separation import separate
from metrology.gum.inputs import Input
from metrology.timeseries import Channel
from metrology.timeseries.white_noise import against_neighbours

MASS, FREQUENCY, NOISE = 1.2, 5.0, 2e-6
OMEGA = 2 * pi * FREQUENCY


def truth(zeta, duration=4.0):
    return Decaying(MASS, MASS * OMEGA**2, 2 * zeta * MASS * OMEGA, 1e-3, duration)


def noise(rng, count, phi=0.0):
    """Noise of one standard deviation: white, or AR(1)."""
    white = rng.standard_normal(count + 200)
    return lfilter([sqrt(1 - phi**2)], [1, -phi], white)[200:]


def record(zeta, rng, *, phi=0.0, kind="", rate=500.0):
    """A record from 0.1 s before the release on; `kind`: what is wrong with it."""
    t = np.arange(-round(0.1 * rate), round(4 * rate)) / rate
    if kind == "uneven":
        t = t + rng.uniform(-0.3, 0.3, t.size) / rate
    x = np.full(t.size, 1e-3)
    x[t >= 0] = swing(truth(zeta), t[t >= 0])
    x += 3e-5 + NOISE * noise(rng, t.size, phi)
    kept = np.ones(t.size, dtype=bool)
    if kind == "gaps":
        kept = rng.random(t.size) > 0.05
        kept[400:460] = False
    if kind == "spikes":
        x[rng.choice(t.size, 8, replace=False)] += NOISE * rng.choice([-1, 1], 8) * rng.uniform(50, 500, 8)
    return Channel("r", t[kept], x[kept], "m")


def results(*records, mass=MASS):
    """Results of a test on a stiffness of its own, with u by the GUM uncertainty framework, and the analysis."""
    found = decay.analyse(DecayTest("d", records, Input("d.mass", mass), "d.k"))
    assert found.finding.failures == ()

    def at(shift):
        known = {one.name: one.value for one in found.inputs}
        known |= {name: known[name] + step for name, step in shift.items()}
        for measurand in found.measurands:
            known[measurand.name] = measurand.function(known)
        return known

    names = [one.name for one in found.inputs[:2]]
    u = np.array([one.u for one in found.inputs[:2]])
    r = next(iter(found.correlations.values()), 0.0)
    values, spread = at({}), {}
    for measurand in found.measurands:
        key = measurand.name
        slopes = np.array([(at({name: s})[key] - at({name: -s})[key]) / 2 for name, s in zip(names, u, strict=True)])
        spread[key[2:]] = sqrt(slopes @ np.array([[1, r], [r, 1]]) @ slopes)
    return {key[2:]: values[key] for key in values}, spread, found


CASES = [("", 0.0), ("", 0.7), ("gaps", 0.0), ("uneven", 0.0), ("spikes", 0.0)]


def pulls(zeta, kind, phi, count, seed):
    """Errors of ζ, ω_n, c and k over their u, shape (count, 4)."""
    true = {"zeta": zeta, "omega_n": OMEGA, "c": 2 * zeta * MASS * OMEGA, "k": MASS * OMEGA**2}
    found = []
    for at in range(count):
        value, u, _ = results(record(zeta, np.random.default_rng([seed, at]), phi=phi, kind=kind))
        found.append([(value[name] - true[name]) / u[name] for name in true])
    return np.array(found)


@pytest.mark.long
@pytest.mark.parametrize("zeta", [0.02, 0.3, 0.5, 0.7, 0.9])
@pytest.mark.parametrize(("kind", "phi"), CASES)
def test_planted_damping_of_any_size_is_found_within_its_uncertainty(zeta, kind, phi):
    apart = pulls(zeta, kind, phi, 6, 11)
    assert np.abs(apart).max() < 4.5
    assert np.sqrt((apart**2).mean()) < 1.6


def test_planted_coloured_noise_is_nothing_that_the_fit_leaves():
    """Neighbouring readings show a quarter of such noise; what a bent reading leaves is no colour."""
    for bend, passed in ((0.0, True), (0.02, False)):
        one = record(0.02, np.random.default_rng(3), phi=0.85)
        one = replace(one, value=one.value + bend * one.value**2 / 1e-3)
        (check,) = [each for each in results(one)[2].finding.checks if each.name == "residuals of the direct fit"]
        assert check.passed is passed, check.sentence


@pytest.mark.study
@pytest.mark.parametrize("zeta", [0.02, 0.3, 0.5, 0.7, 0.9])
@pytest.mark.parametrize(("kind", "phi"), CASES)
def test_planted_coverage_of_any_damping(zeta, kind, phi):
    apart = pulls(zeta, kind, phi, 200, 12)
    covered = (np.abs(apart) < 1.96).mean(axis=0)
    assert (covered > 0.89).all(), covered
    assert (covered < 0.99).all(), covered


def test_limit_a_mode_that_grows_beyond_the_largest_number_ends_at_the_rest():
    value, u, _ = results(record(0.5, np.random.default_rng([12, 100]), phi=0.7))
    assert abs(value["zeta"] - 0.5) < 3 * u["zeta"]


def test_planted_spikes_are_masked_counted_and_leave_no_trace():
    rng = np.random.default_rng(3)
    clean = record(0.02, rng)
    places = np.array([300, 777, 900, 1200, 1900])
    spoiled = replace(clean, value=clean.value + 1e-4 * np.isin(np.arange(len(clean)), places))
    before, _, _ = results(clean)
    after, u, found = results(spoiled)
    (one,) = found.finding.records
    assert one.others.endswith("; 5 outliers masked")
    assert masked(spoiled)[1] == pytest.approx(clean.time[places])
    for name in ("zeta", "omega_n"):
        assert after[name] == pytest.approx(before[name], abs=0.3 * u[name])
    # A lost reading costs a filter nothing: what is missing is filled with the fit.
    assert sum(one.peak_used) > 20


@pytest.mark.parametrize("sign", [1, -1])
def test_planted_spike_on_the_last_reading_is_masked(sign: int):
    """Its neighbours are on one side: off their cubic it is six times less than off the motion. It bent the rest."""
    clean = record(0.02, np.random.default_rng(3))
    size = 30 * float(np.median(abs(against_neighbours(clean)))) / 0.6745
    last = np.arange(len(clean)) == len(clean) - 1
    spoiled = replace(clean, value=clean.value + sign * size * last)
    assert not masked(spoiled)[1].size
    before, after = separate(clean, mains=50.0), separate(spoiled, mains=50.0)
    assert (before.outliers, after.outliers) == ((), (clean.time[-1],))
    assert after.fit.degree == before.fit.degree


def test_law_noise_alone_has_no_outliers():
    t = np.arange(4000) / 1000
    for seed in range(100):
        rng = np.random.default_rng(seed)
        for x in (
            noise(rng, t.size),
            noise(rng, t.size, 0.9),
            np.round(noise(rng, t.size) / 3) * 3,
            50 * np.sin(9 * t),
        ):
            assert masked(Channel("r", t, x))[1].size == 0


SAME = """\
    rig: {mass: 2 kg, taut: 0 m, attachment: both ways}
    known:
      start_position: {per_run: 10 mm}
      start_velocity: {per_run: 0.1 m/s}
      free_length: {common: 10 mm}
    identification: {free: [k, c], start: {k: 450 N/m, c: 3 N*s/m}}
"""


@pytest.mark.long
@pytest.mark.parametrize(("zeta", "seed"), [(0.004, 1), (0.05, 2), (0.3, 5), (0.7, 4)])
def test_twice_decay_and_response_give_the_same_k_and_c(zeta, seed, tmp_path):
    """One record let go from rest, written for either method: one likelihood, so one answer."""
    rng, t, m, omega = np.random.default_rng(seed), np.arange(2000) / 100, 2.0, 2 * pi * 2.5
    one = Decaying(m, m * omega**2, 2 * zeta * m * omega, 0.03, 20.0)
    x = swing(one, t) + 5e-5 * rng.standard_normal(t.size)
    value, _, _ = results(Channel("r", t, x, "m"), mass=m)
    name, _, files, extra = run(0, [("time / s,x / m", [t, x])], "start: {position: 0.03 m}")
    finding, _ = shown(tmp_path, SAME, [(name, "identification", files, extra)])
    for entry in (sought(finding)["k"], sought(finding)["c"]):
        assert abs(value[entry.name] - entry.value) < 0.1 * entry.u, entry.name


def test_law_releases_that_differ_by_more_than_noise_take_the_decrement_and_others_the_fit():
    same = [record(0.05, np.random.default_rng([7, at])) for at in range(4)]
    value, _, found = results(*same)
    fits = [one.zeta_fit for one in found.finding.records]
    assert value["zeta"] == pytest.approx(np.mean(fits), rel=1e-6)
    differing = [record(0.05 + 0.002 * at, np.random.default_rng([7, at])) for at in range(4)]
    value, _, found = results(*differing)
    assert found.inputs[0].value == pytest.approx(np.mean([one.log_decrement for one in found.finding.records]))


HEAD = """\
format: metrology-campaign/1
id: turning
title: A body that turns
diagnosis: {off: true}
samples: {wire: {}}
instruments: {eye: {kind: encoder}}
tests:
  swing: {method: decay, sample: wire, instruments: {displacement: eye}, inertia: 0.02 kg*m^2, readings: [r.csv]}
"""


def turning(folder, unit, factor):
    """Results of a campaign of one release of a pendulum of small swings by SciPy, with empty cells."""
    folder.mkdir()
    t = np.arange(1500) / 50
    phi = solve_ivp(
        lambda _, y: [y[1], (-0.35 * y[0] - 0.004 * y[1]) / 0.02],
        (0, 30),
        [0.1, 0.0],
        "DOP853",
        t,
        rtol=1e-11,
        atol=1e-13,
    ).y[0]
    phi = factor * (phi + 1e-4 * np.random.default_rng(1).standard_normal(t.size))
    cells = ["" if 200 <= at < 210 else f"{value:.12g}" for at, value in enumerate(phi)]
    rows = [f"{stamp:.3f},{cell}" for stamp, cell in zip(t, cells, strict=True)]
    (folder / "r.csv").write_text("\n".join([f"time / s,angle / {unit}", *rows]) + "\n")
    (folder / "campaign.yaml").write_text(HEAD)
    return {one.quantity: one for one in evaluated(load(folder / "campaign.yaml")).results}


def test_planted_torsion_pendulum_in_degrees_or_radians(tmp_path):
    one, other = turning(tmp_path / "deg", "deg", 180 / pi), turning(tmp_path / "rad", "rad", 1.0)
    assert {name: found.unit for name, found in one.items()} == {
        "zeta": "1", "omega_n": "rad/s", "k": "N·m/rad", "c": "N·m·s/rad",
    }  # fmt: skip
    for name, true in (("k", 0.35), ("c", 0.004)):
        assert abs(one[name].value - true) < 4 * one[name].u
        assert one[name].value == pytest.approx(other[name].value, rel=1e-6)
        assert one[name].u < 0.01 * true


@pytest.mark.long
def test_planted_pendulum_of_large_swings_as_an_angle():
    """J·φ″ = −M·g·l·sin φ − c·φ′ from 0.7 rad: a pendulum by its sine, κ = 1/rad, and k of small swings."""
    inertia, k, c = 0.02, 1.2, 1.5e-3
    t = np.arange(3000) / 100
    phi = solve_ivp(
        lambda _, y: [y[1], (-k * np.sin(y[0]) - c * y[1]) / inertia],
        (0, 30),
        [0.7, 0.0],
        "DOP853",
        t,
        rtol=1e-11,
        atol=1e-13,
    ).y[0]
    made = Channel("swing", t, phi + 2e-3 * np.random.default_rng(1).standard_normal(t.size), "rad")
    from metrology.diagnostics import decay as diagnose

    found = diagnose(DecayTest("p", (made,), Input("p.J", inertia), "p.k"), rng=np.random.default_rng(2))
    assert found.possible[0] == "pendulum"
    (size,) = next(one.parameters for one in found.causes if one.effect == "pendulum")
    assert size.unit == "1/rad"
    assert size.value == pytest.approx(1.0, rel=0.05)
    stiffness = next(one for one in found.shifts if one.name == "k")
    assert stiffness.after == pytest.approx(k, rel=3e-3)


def returning(zeta, sigma, rng):
    """A record of a body that returns at critical damping, or beyond it."""
    t = np.arange(-50, 1000) / 500
    fall, spread = zeta * OMEGA * t, OMEGA * sqrt(zeta**2 - 1) * t
    both = 1 + OMEGA * t if zeta == 1 else np.cosh(spread) + zeta / sqrt(zeta**2 - 1) * np.sinh(spread)
    x = np.where(t >= 0, 1e-3 * np.exp(-fall) * both, 1e-3)
    return Channel("r", t, x + sigma * rng.standard_normal(t.size), "m")


@pytest.mark.long
@pytest.mark.parametrize("sigma", [2e-6, 1e-5])
@pytest.mark.parametrize("zeta", [1.0, 1.1, 1.3])
def test_misuse_a_motion_that_returns_without_an_oscillation_is_refused_for_that_reason(zeta, sigma):
    # The fit went for the noise: "sampled too slowly", or no fit at all where its frequency was beyond its samples.
    for seed in range(3):
        found = decay.analyse(
            DecayTest("d", (returning(zeta, sigma, np.random.default_rng(seed)),), Input("d.mass", MASS), "d.k")
        )
        assert found.measurands == ()
        assert "no oscillation" in found.finding.failures[0]


@pytest.mark.parametrize("seed", [0, 2])
def test_misuse_a_frequency_that_may_be_zero_gives_no_result(seed):
    # k was several times as uncertain as large, or the check of the damping divided by zero.
    rng = np.random.default_rng(seed)
    t = np.arange(-50, 2000) / 500
    x = np.full(t.size, 1e-3)
    x[t >= 0] = swing(truth(0.98), t[t >= 0])
    near = Channel("r", t, x + 1.2e-5 * noise(rng, t.size, 0.5), "m")
    found = decay.analyse(DecayTest("d", (near,), Input("d.mass", MASS), "d.k"))
    assert found.measurands == ()
    assert "no oscillation" in found.finding.failures[0]


def test_limit_noise_about_a_mode_is_found_in_a_record_shorter_than_its_period():
    t = np.arange(60) / 60
    shorter = fit(t, np.cos(3 * t), [Mode(3.0, 0.1)], lags=3, degree=0)
    assert 0 < _variance_near(shorter, 60.0) < 1
