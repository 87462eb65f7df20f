import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from response_cases import HELD_OUT, PRIORS, SCATTER, SHORT, measured, runs_of, stated, truth_of
from truth_response import Instruments, Scatter, Test, Truth, campaign

from metrology.errors import MetrologyError
from metrology.estimation import Prior, fit
from metrology.rig import Force, Rig, Run, simulate
from metrology.verify import RULE, compare, phases, thinned, trace


def verified(truth, seed, material="nylon"):
    runs = runs_of(truth, seed, tests=(*SHORT, *HELD_OUT))
    held = [replace(run, purpose="verification") for run in runs[2:]]
    found = fit(stated(material), [*runs[:2], *held], priors=PRIORS)
    return compare(found, held, np.random.default_rng(0), names=(material, f"{material}-response"))


@pytest.fixture(scope="module")
def right():
    return verified(truth_of("nylon"), 24)


def test_planted_nothing_is_validated(right):
    assert right.verdict == "validated within u_val", right.sentence
    for run in right.runs:
        # Noise leads in most readings, and 95 % of it lies within the band. What a whole run shares (thrust, start)
        # moves many readings together: of 24 runs (twelve seeds) 3 had 89 % to 92 % in the band, the others 94 % to
        # 97 %. A band twice too wide holds 99.9 %.
        assert 0.92 < run.share < 0.99
        assert 0.92 < run.in_band < 0.99
        # RMS over noise of n readings scatters by 1/√(2·n), and about twice that with noise that is estimated itself.
        scored = [score for score in run.scores if score.closed_rms]
        assert len(scored) > 9
        assert all(abs(score.closed_rms - 1) < 5 / np.sqrt(2 * score.count) for score in scored)


def autoregressive(size, rng, phi=0.5):
    """Noise of unit variance in which each reading holds half of the one before."""
    from scipy.signal import lfilter

    return np.sqrt(1 - phi**2) * lfilter([1.0], [1.0, -phi], rng.standard_normal(size))


@pytest.mark.long
@pytest.mark.parametrize("kind", ["colour", "spikes"])
def test_planted_noise_of_its_own_colour_and_single_spikes_are_validated(kind):
    """In place of white noise, of the size that is stated."""
    rng = np.random.default_rng(4)
    records = campaign(truth_of("nylon"), (*SHORT, *HELD_OUT), Instruments(), SCATTER, rng)
    runs = []
    for record in records:
        run = measured(record)
        x = run.x.copy()
        if kind == "colour":
            x = record.clean["x"] + run.noise["x"] * autoregressive(x.size, rng)
        else:
            x[rng.choice(x.size - 2, 4, replace=False) + 1] += 20 * run.noise["x"]
        runs.append(replace(run, x=x))
    held = [replace(run, purpose="verification") for run in runs[2:]]
    found = fit(stated("nylon"), runs[:2], priors=PRIORS)
    judged = compare(found, [replace(run, noise=runs[0].noise) for run in held], np.random.default_rng(0))
    for run in judged.runs:
        (score,) = (one for one in run.scores if (one.channel, one.name) == ("x", "all"))
        assert score.closed_rms < 1.1
        assert score.closed_excess < 5


def narrow(size, rng):
    """Noise of unit variance, four tenths of it in a band of a hundredth of the rate."""
    from scipy.signal import lfilter

    band = lfilter([1.0], [1.0, -2 * 0.97 * np.cos(1.3), 0.97**2], rng.standard_normal(size + 400))[400:]
    return np.sqrt(0.4) * band / band.std() + np.sqrt(0.6) * rng.standard_normal(size)


@pytest.mark.long
@pytest.mark.parametrize("noise", [autoregressive, narrow])
def test_planted_noise_that_is_more_than_neighbours_show_is_validated(noise):
    """Of every channel; nobody states its size, and readings next to each other are alike in it."""
    rng = np.random.default_rng(8)
    runs = []
    for record in campaign(truth_of("nylon"), (*SHORT, *HELD_OUT), Instruments(), SCATTER, rng):
        run = measured(record)
        read = {name: record.clean[name] + run.noise[name] * noise(run.readings(name).size, rng) for name in "xvT"}
        runs.append(replace(run, noise={}, **read))
    held = [replace(run, purpose="verification") for run in runs[2:]]
    judged = compare(fit(stated("nylon"), runs[:2], priors=PRIORS), held, np.random.default_rng(0))
    assert judged.verdict == "validated within u_val", judged.sentence


@pytest.mark.long
def test_planted_friction_is_not_validated():
    wrong = verified(truth_of("nylon", friction=5e-3), 21)
    assert wrong.verdict == "not validated"
    assert all(run.sentence.startswith("not validated: ") for run in wrong.runs if run.verdict == "not validated")


def test_law_u_val_holds_its_parts(right):
    """u_val is never below the noise, and where inputs matter (a snatch) far above it."""
    for run in right.runs:
        tension = next(one for one in run.series if one.channel == "T")
        twice = np.array(tension.twice_u_val)
        assert twice.min() > 2 * 4.5e-3
        assert twice.max() > 10 * twice.min()


def test_law_finding_is_plain_json_of_bounded_size(right):
    told = json.loads(json.dumps(asdict(thinned(right)), allow_nan=False))
    assert told["rule"] == RULE
    for run in told["runs"]:
        for series in run["series"]:
            assert len(series["time"]) == len(series["measured"]) == len(series["low"]) <= 2300


def test_law_screen_holds_every_reading_and_paper_the_extremes_of_it(right):
    assert max(one.count for one in right.runs[0].series) > 2300
    for run, short in zip(right.runs, thinned(right).runs, strict=True):
        for whole, few in zip(run.series, short.series, strict=True):
            score = next(one for one in run.scores if (one.channel, one.name) == (whole.channel, "all"))
            assert len(whole.time) == whole.count == few.count == score.count
            assert len(few.time) < 2300 < len(whole.time) or few == whole
            known = [value for value in whole.measured if value is not None]
            assert {min(known), max(known)} <= set(few.measured)
            assert trace(few)["measured"].size == len(few.time)
            assert np.nanmax(trace(whole)["measured"]) == max(known)


@pytest.mark.long
def test_planted_right_law_with_a_delay_beats_a_wrong_law_with_a_better_score():
    """Dry friction against viscous damping of a swing on a taut line: the wrong law fits the delayed run better by
    RMS, and is refused all the same; the right law takes the delay into the clock, and is validated."""
    truth = Truth(m=25.0, k=167.64, c=0.05, taut=0.0, friction=0.02)
    hung = 0.62 / 167.64
    tests = [Test(name, ((0.0, 0.62),), 14.0, x0=hung + 3.2e-3) for name in ("a", "b", "late")]
    sharp = Instruments(rates=(100.0, 0, 0), noise=(2e-5, 0, 0), rounding=(0, 0, 0))
    records = campaign(truth, tests[:2], sharp, Scatter(), np.random.default_rng(1))
    records += campaign(truth, tests[2:], replace(sharp, offset=(0.3, 0, 0)), Scatter(), np.random.default_rng(2))
    runs = [measured(records[0]), measured(records[1]), measured(records[2], "verification")]
    priors = [Prior("clock.x", 0.0, 0.15)]
    rig = Rig(m=25.0, k=167.64, c=1.0, taut=0.0)
    wrong = compare(fit(rig, runs, priors=priors), runs, np.random.default_rng(0))
    start = replace(rig, effects={"friction.force": 0.01})
    right = compare(fit(start, runs, free=("k", "c", "friction.force"), priors=priors), runs, np.random.default_rng(0))
    score = {name: next(one.rms for one in one_of.runs[0].scores) for name, one_of in (("w", wrong), ("r", right))}
    assert score["w"] < score["r"]
    assert (wrong.verdict, right.verdict) == ("not validated", "validated within u_val")


def test_refusal_run_that_went_into_the_fit():
    runs = runs_of(truth_of("nylon"), 21)
    found = fit(stated("nylon"), runs, priors=PRIORS)
    with pytest.raises(MetrologyError, match=r"verify.step-a: got a run that went into the fit"):
        compare(found, [replace(runs[0], purpose="verification")], np.random.default_rng(0))


def test_limit_run_in_which_the_line_never_pulls_is_not_testable():
    truth = truth_of("nylon")
    push = Test("short push", ((1.0, 0.38), (2.0, 0.0)), 4.0)
    runs = runs_of(truth, 3, tests=(*SHORT, push))
    found = fit(stated("nylon"), runs[:2], priors=PRIORS)
    told = compare(found, [replace(runs[2], purpose="verification")], np.random.default_rng(0))
    assert told.verdict == "not testable"
    assert told.runs[0].sentence == "not testable: the line never pulls in this run"


def names_of(rig, run):
    return [(part.name, part.start, part.stop) for part in phases(rig, run, simulate(rig, run))]


def test_closed_form_first_contact_begins_the_spike():
    """x = ½·F/m·t² reaches the taut position at √(2·m·x_t/F)."""
    rig = Rig(m=25.0, k=167.64, c=8.0, taut=0.1)
    found = names_of(rig, Run.sampled(np.arange(6001) / 100, 0.0, force=Force.step(0.62)))
    assert [name for name, _, _ in found] == ["slack", "spike", "rebound", "decay", "steady"]
    assert found[1][1] == pytest.approx(np.sqrt(2 * 25.0 * 0.1 / 0.62), rel=1e-6)
    assert found[-1][2] == 60.0


def test_limit_phases_of_other_rigs():
    run = Run.sampled(np.arange(2001) / 100, 0.01)
    assert [name for name, _, _ in names_of(Rig(1.0, 4.0, 1.6, attachment="both ways"), run)] == ["decay", "steady"]
    assert [name for name, _, _ in names_of(Rig(1.0, 0.0, attachment="none"), replace(run, v0=0.1))] == ["coast"]
    impulse = Run.sampled(np.arange(2001) / 100, 0.0, force=Force.impulse(0.62, stop=2.0))
    found = names_of(Rig(m=25.0, k=167.64, c=8.0, taut=0.1), impulse)
    assert [name for name, _, _ in found] == ["slack", "spike", "rebound"]
