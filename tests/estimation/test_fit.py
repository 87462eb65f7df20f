import math
from dataclasses import replace

import numpy as np
import pytest
from response_cases import MATERIALS, PRIORS, SHORT, measured, runs_of, stated, truth_of
from truth_response import Instruments, Scatter, Test, Truth, campaign, measure

from metrology.errors import MetrologyError
from metrology.estimation import MeasuredRun, Prior, fit, lay_out, paper_way, shares
from metrology.estimation.inspection import faults
from metrology.rig import Force, Rig, Run


@pytest.fixture(scope="module")
def nylon():
    runs = runs_of(truth_of("nylon"), 11)
    return runs, fit(stated("nylon"), runs, priors=PRIORS)


@pytest.mark.long
@pytest.mark.parametrize("material", MATERIALS)
def test_planted_stiffness_and_damping_are_found(material):
    found = fit(stated(material, on_k=0.75), runs_of(truth_of(material), 5), priors=PRIORS)
    assert found.status == "ok"
    for name, true in zip("kc", MATERIALS[material], strict=True):
        assert abs(found.value(name) - true) < 3.5 * found.u(name)
        assert found.u(name) < 0.01 * true
    assert found.reduced_chi_squared == pytest.approx(1.0, abs=0.05)


def test_planted_inputs_come_back_common_and_per_run():
    """What differs from the stated inputs is found where the runs can tell it, inside its uncertainty."""
    records = campaign(
        truth_of("nylon"), SHORT, Instruments(), Scatter(mass=0.01, start_run=1e-3), np.random.default_rng(8)
    )
    priors = (Prior("mass.factor", 0.01), Prior("start.x", 0.0, 1e-3))
    found = fit(stated("nylon"), [measured(record) for record in records], priors=priors)
    mass = records[0].truth.m / 25.0
    assert abs(found.value("mass.factor") - mass) < 3.5 * found.u("mass.factor")
    assert abs(mass - 1) > 5 * found.u("mass.factor")
    for record in records:
        name = f"start.x@{record.test.name}"
        assert abs(found.value(name) - record.true_test.x0) < 3.5 * found.u(name)


def test_law_sources_add_up_to_the_covariance(nylon):
    found = nylon[1]
    parts = sum(source.columns @ source.columns.T for source in found.sources)
    np.testing.assert_allclose(parts, found.total, rtol=1e-9, atol=1e-12 * found.total.max())
    assert sum(shares(found, "k").values()) == pytest.approx(1.0)


@pytest.mark.long
@pytest.mark.parametrize("name", ["thrust.gain", "free_length.shift", "cell.gain"])
def test_twice_sensitivity_to_a_known_input_against_a_refit(name):
    """The row of a known input in the budget is what a refit with that input shifted does."""
    priors = [*PRIORS, Prior("cell.gain", 0.004)]
    runs = runs_of(truth_of("nylon"), 11)
    found = fit(stated("nylon"), runs, priors=priors)
    source = next(one for one in found.sources if one.name == name and one.kind == "common")
    moved = []
    for sign in (-1, 1):
        mean = found.rig.value(name) + sign * 0.5 * source.u
        shifted = [replace(one, mean=mean) if one.name == name else one for one in priors]
        moved.append(fit(found.fitted, runs, priors=shifted).theta[:2])
    u = np.sqrt(np.diag(found.total)[:2])
    np.testing.assert_allclose((moved[1] - moved[0]) / u, source.columns[:2, 0] / u, rtol=0.03, atol=2e-3)


def test_limit_one_gain_on_mass_and_cell_is_carried_by_their_priors():
    """A factor on mass, thrust, k, c and the cell leaves every reading as it was: only the priors fix it."""
    priors = (Prior("mass.factor", 0.01), Prior("thrust.gain", 0.01), Prior("cell.gain", 0.01))
    found = fit(stated("nylon"), runs_of(truth_of("nylon"), 2, scatter=Scatter()), priors=priors)
    assert found.u("k") / found.value("k") == pytest.approx(0.01 / np.sqrt(3), rel=0.05)
    assert shares(found, "k")["readings"] < 0.05
    assert found.correlation("k", "mass.factor") > 0.98


def test_limit_that_gain_stays_free_with_friction_over_a_long_run():
    """Steps too wide carry late contacts past a reading; that jump once made u(k) ten times too small."""
    priors = (Prior("mass.factor", 0.01), Prior("thrust.gain", 0.01), Prior("cell.gain", 0.01))
    tests = (Test("step-a", ((1.0, 0.62),), 30.0),)
    runs = runs_of(truth_of("nylon", friction=1e-3), 2, scatter=Scatter(), tests=tests)
    rig = replace(stated("nylon"), effects={"friction.force": 5e-4})
    found = fit(rig, runs, free=("k", "c", "friction.force"), priors=priors)
    assert found.u("k") / found.value("k") == pytest.approx(0.01 / np.sqrt(3), rel=0.02)
    assert abs(found.value("friction.force") - 1e-3) < 4 * found.u("friction.force")


def test_limit_damping_that_the_runs_do_not_show_is_bounded():
    truth = Truth(m=25.0, k=1810.91, c=0.02, taut=0.1)
    test = Test("one snatch", ((1.0, 0.62), (4.0, 0.0)), 6.0)
    noisy = Instruments(noise=(2e-3, 2e-2, 0.5), rounding=(0, 0, 0))
    found = fit(stated("peek"), runs_of(truth, 1, tests=(test,), scatter=Scatter(), instruments=noisy))
    damping = found.parameter("c")
    assert not damping.determined
    assert damping.high > 0.02
    assert damping.low is None
    assert damping.sentence.startswith("c is not determined by these runs; it is at most")


def test_limit_line_that_never_pulls_says_nothing_about_k():
    test = Test("short push", ((1.0, 0.38), (2.0, 0.0)), 4.0)
    found = fit(stated("nylon"), runs_of(truth_of("nylon"), 1, tests=(test,), scatter=Scatter()))
    assert [found.parameter(name).determined for name in "kc"] == [False, False]
    assert found.parameter("k").sentence == "these runs say nothing about k"


@pytest.mark.parametrize("rates", [(100.0, 0, 0), (0, 100.0, 0), (0, 0, 200.0)])
def test_planted_one_channel_is_enough(rates):
    runs = runs_of(truth_of("nylon"), 4, scatter=Scatter(), instruments=Instruments(rates=rates))
    found = fit(stated("nylon"), runs)
    assert abs(found.value("k") - 167.64) < 4 * found.u("k")


def test_planted_contradicted_prior_is_told():
    scatter = Scatter()
    runs = runs_of(replace(truth_of("nylon"), m=26.0), 3, scatter=scatter)
    found = fit(stated("nylon"), runs, priors=[Prior("mass.factor", 0.002)])
    (told,) = (
        note
        for note in found.notes
        if note.startswith("the fitted and the stated mass.factor disagree by ") and ": 1.0" in note
    )
    assert told.endswith("the residuals are noise, so the statement is wrong, or the model lacks what acts alike")


def test_planted_friction_drives_a_known_input_off_and_is_told_to_be_missing():
    """Without friction in the runs, or with it in the model, the mass stays where the balance put it."""
    priors = [Prior("mass.factor", 0.002), Prior("thrust.gain", 0.001)]
    told = {}
    for friction, effects in ((0.0, {}), (0.01, {}), (0.01, {"friction.force": 0.005})):
        runs = runs_of(truth_of("nylon", friction=friction), 3, scatter=Scatter())
        rig = replace(stated("nylon"), effects=effects)
        found = fit(rig, runs, free=("k", "c", *effects), priors=priors)
        told[friction, bool(effects)] = [note for note in found.notes if "disagree" in note]
    assert told[0.0, False] == told[0.01, True] == []
    assert any("mass.factor" in note for note in told[0.01, False])
    assert all(note.endswith("the model lacks something for which this input stands in") for note in told[0.01, False])


def test_limit_budget_that_ends_a_search_is_told_and_repeats(monkeypatch):
    """A model without the friction of the runs: every start would be tried; the best so far is a result, no hang."""
    monkeypatch.setattr("metrology.estimation.search.BUDGET", 12)
    runs = runs_of(truth_of("nylon", friction=0.01), 3, scatter=Scatter())
    first, again = (fit(stated("nylon"), runs) for _ in range(2))
    assert first.status == "ok"
    assert "the iteration limit was reached before all starts were tried" in first.sentence
    assert np.array_equal(first.theta, again.theta)
    monkeypatch.setattr("metrology.estimation.search.BUDGET", 2)
    failed = fit(stated("nylon", on_k=0.5), runs)
    assert failed.status == "failed"
    assert failed.sentence.startswith("the fit is not converged within")


def test_planted_saturated_cell_is_masked_and_told():
    runs = runs_of(truth_of("nylon"), 6, scatter=Scatter(), instruments=Instruments(saturation=3.0))
    found = fit(stated("nylon"), runs)
    assert any("the load cell was saturated at 3 N" in note for note in found.notes)
    assert abs(found.value("k") - 167.64) < 4 * found.u("k")


def test_planted_gaps_carry_no_weight():
    runs = runs_of(truth_of("nylon"), 6, scatter=Scatter())
    holed = []
    for run in runs:
        x = run.x.copy()
        x[200:400] = np.nan
        holed.append(MeasuredRun(run.name, run.run, x=x, v=run.v, T=run.T))
    found = fit(stated("nylon"), holed)
    assert abs(found.value("k") - 167.64) < 3.5 * found.u("k")
    assert "step-a: 200 gaps in x" in found.notes


def test_twice_paper_way_agrees_where_its_assumptions_hold(nylon):
    runs = runs_of(truth_of("nylon"), 11, scatter=Scatter())
    simple = paper_way(stated("nylon"), runs)
    assert simple.status == "ok"
    assert simple.k == pytest.approx(167.64, rel=2e-3)
    assert simple.c == pytest.approx(8.0, rel=1e-2)


@pytest.mark.long
def test_twice_jackknife_of_paper_way_agrees_with_searches_without_each_run(nylon):
    """One straight step without a run leads where a search of its own does, but for the small minima of the sum."""
    runs = [replace(one, name=f"{one.name} {seed}") for seed in (11, 12, 13)
            for one in runs_of(truth_of("nylon"), seed, scatter=Scatter())]  # fmt: skip
    whole = paper_way(stated("nylon"), runs)
    left = [paper_way(stated("nylon"), [*runs[:at], *runs[at + 1 :]], start=(whole.k, whole.c))
            for at in range(len(runs))]  # fmt: skip
    for name, u in (("k", whole.k_u), ("c", whole.c_u)):
        values = np.array([getattr(one, name) for one in left])
        assert u == pytest.approx(math.sqrt((len(runs) - 1) * values.var()), rel=0.3)


def refusal(call):
    with pytest.raises(MetrologyError) as caught:
        call()
    return [str(fault) for fault in caught.value.faults]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"T": -1}, "step-a.T: got a tension that falls to -"),
        (
            {"x": -1, "v": -1},
            "step-a.x: got a position that moves against the thrust of 0.62 N; expected",
        ),
        (
            {"v": -1},
            "step-a.v: got a velocity against the change of position; expected v = dx/dt. Fix: change",
        ),
    ],
)
def test_refusal_wrong_sign(change, message):
    run = runs_of(truth_of("nylon"), 1, tests=SHORT[:1])[0]
    channels = {name: change.get(name, 1) * run.readings(name) for name in run.channels}
    told = refusal(lambda: fit(stated("nylon"), [MeasuredRun(run.name, run.run, **channels)]))
    assert len(told) == 1
    assert told[0].startswith(message)


@pytest.mark.parametrize("later", [0, 5])
def test_limit_one_reading_far_off_is_no_motion_against_the_thrust(later):
    """Nor the first one under thrust."""
    run = runs_of(truth_of("nylon"), 1, tests=SHORT[:1])[0]
    begins = max(run.run.force.t[np.flatnonzero(run.run.force.values)[0]], run.run.held_until or 0.0)
    x = run.x.copy()
    x[np.searchsorted(run.stamps("x"), begins) + later] -= 0.02
    assert faults(stated("nylon"), [MeasuredRun(run.name, run.run, x=x, v=run.v, T=run.T)]) == []


def test_refusal_impossible_start_state():
    run = runs_of(truth_of("nylon"), 1, tests=SHORT[:1])[0]
    off = MeasuredRun(run.name, replace(run.run, x0=-0.3), x=run.x, v=run.v, T=run.T)
    told = refusal(lambda: fit(stated("nylon"), [off]))
    assert told[0].startswith("step-a.run.x0: got -0.3 m, where the first readings say ")


def test_limit_a_start_from_which_the_first_readings_swing_away_is_possible():
    """Let go at 0.3 m and 4 Hz, sampled 20 times a second: the median of five readings is nowhere near the start."""
    t = np.arange(0.0, 4.0, 0.05)
    omega = 2 * np.pi * 4.0
    x = 0.3 * np.cos(omega * t) + 1e-4 * np.random.default_rng(8).standard_normal(t.size)
    rig = Rig(2.0, 2.0 * omega**2, 0.0, attachment="both ways")
    assert faults(rig, [MeasuredRun("a", Run(x0=0.3, t_x=t), x=x)]) == []
    (fault,) = faults(rig, [MeasuredRun("a", Run(x0=2.0, t_x=t), x=x)])
    assert "a start state that the readings can have begun from" in str(fault)


def test_refusal_readings_that_are_none():
    t = np.arange(100) / 100
    run = Run(x0=0.0, t_x=t, t_v=t)
    told = refusal(lambda: MeasuredRun("a", run, x=np.full(100, np.nan), v=np.full(100, np.inf)))
    assert told == [
        "a.x: got a channel that is all gaps; expected at least one reading. Fix: leave the channel out",
        "a.v[0]: got inf; expected a finite reading. Fix: leave a gap (NaN) instead",
    ]
    told = refusal(lambda: MeasuredRun("a", run, x=np.zeros(99)))
    assert told == [
        "a.x: got 99 readings; expected 100, one for each time stamp",
        "a.v: got time stamps without readings; expected readings at those stamps, or neither",
    ]


def test_refusal_stamps_out_of_order_stand_in_the_run():
    told = refusal(lambda: Run(x0=0.0, t_x=[0.0, 0.2, 0.2, 0.3]))
    assert told == ["run.t_x[2]: got 0.2 s after 0.2 s; expected times that increase"]


def test_refusal_run_without_motion():
    record = measure(truth_of("nylon"), Test("rest", (), 3.0), Instruments(), np.random.default_rng(1))
    told = refusal(lambda: fit(stated("nylon"), [measured(record)]))
    assert told == ["rest: got no motion beyond the noise in any channel; expected a run in which the module moves"]


def test_refusal_unknown_names():
    runs = runs_of(truth_of("nylon"), 1, tests=SHORT[:1])
    told = refusal(lambda: fit(stated("nylon"), runs, free=("k", "stiffness"), priors=[Prior("gain", 0.1)]))
    assert [line.split(":")[1].split(";")[0] for line in told] == [" got 'stiffness'", " got 'gain'"]


def test_refusal_fit_that_cannot_follow_is_a_value():
    """A model that cannot be followed gives a sentence and no number."""
    run = runs_of(truth_of("nylon"), 1, tests=SHORT[:1])[0]
    chatter = Rig(m=1e-9, k=1e12, c=0.0, taut=-10.0, effects={"hysteresis.stiffness": 1e9, "hysteresis.yield": 1e-9})
    found = fit(chatter, [run])
    assert found.status == "failed"
    assert found.sentence
    assert np.isnan(found.theta).all()
    assert found.parameters == ()


def test_limit_thrust_profile_longer_than_the_record_is_told():
    record = campaign(truth_of("nylon"), SHORT[:1], Instruments(), Scatter(), np.random.default_rng(1))[0]
    run = measured(record)
    longer = replace(run.run, force=Force([1.0, 60.0], [0.62, 0.0]))
    found = fit(stated("nylon"), [MeasuredRun(run.name, longer, x=run.x, v=run.v, T=run.T)])
    assert "step-a: the thrust profile goes on after the record ends at 14 s" in found.notes


def test_closed_form_of_a_run_that_differs_by_a_part_of_a_gain():
    """G·(1 + δ) of a factor, x_t + δ of a length; derivatives against differences."""
    layout = lay_out(stated("nylon"), ["a", "b"], ["k"], [*PRIORS, Prior("cell.gain", 0.0, 0.01)])
    rng = np.random.default_rng(3)
    local = np.array([160.0, 0.9, 1.2, 2e-3, *rng.normal(0.0, 0.1, len(layout.uses[1]) - 4)])
    values, of = (
        layout.values(1, local),
        dict(zip((layout.unknowns[at].name for at in layout.uses[1]), local, strict=True)),
    )
    assert values["thrust.gain"] == pytest.approx(1.2 * (1 + of["thrust.gain@b"]), rel=1e-14)
    assert values["cell.gain"] == pytest.approx(1 + of["cell.gain@b"], rel=1e-14)
    assert values["free_length.shift"] == pytest.approx(2e-3 + of["free_length.shift@b"], rel=1e-14)
    for column, target in enumerate(layout.targets[1]):
        ends = (layout.values(1, local + side * 1e-4 * np.eye(len(local))[column]) for side in (1, -1))
        high, low = (end[layout.names[target]] for end in ends)
        assert (high - low) / 2e-4 == pytest.approx(layout.moved(1, local)[column], rel=1e-9)


def test_planted_thrusts_of_two_runs_exchanged_leave_k():
    """Forces do not all shrink for what sets the runs apart, and k with them: no reading fixes their scale well."""
    tests = (*SHORT, Test("step-c", ((1.0, 0.38),), 14.0), Test("impulse-c", ((1.0, 0.38), (4.0, 0.0)), 9.0))
    runs = runs_of(truth_of("nylon"), 4, tests=tests)
    forces = [one.run.force for one in runs]
    swapped = [replace(one, run=replace(one.run, force=forces[at])) for one, at in zip(runs, (2, 1, 0, 3), strict=True)]
    found = fit(stated("nylon"), swapped, priors=[*PRIORS, Prior("cell.gain", 0.004)])
    assert found.status == "ok"
    assert found.value("k") == pytest.approx(MATERIALS["nylon"][0], rel=0.03)
