"""Response tests of other rigs through the front door: a campaign folder goes in, k, c and a verdict come out."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from response_cases import HELD_OUT, SHORT
from rig_folder import assert_recovered, run, shown, sought, written
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from truth_response import Instruments, Test, Truth, measure

from metrology.cli import main
from metrology.findings import from_json
from metrology.rig import engines


@pytest.mark.long
def test_planted_spring_let_go_without_thrust_and_with_position_alone(tmp_path):
    """Free decay of a line attached both ways, x = A·e^(−δt)·(cos ωt + δ/ω·sin ωt), from an initial state."""
    rng, runs = np.random.default_rng(1), []
    m, k, c = 2.0, 50.0, 0.8
    delta, t = c / (2 * m), np.arange(1200) / 100
    omega = np.sqrt(k / m - delta**2)
    for number in range(4):
        size = 0.05 + 0.01 * number
        x = size * np.exp(-delta * t) * (np.cos(omega * t) + delta / omega * np.sin(omega * t))
        noisy = x + 1e-4 * rng.standard_normal(t.size)
        noisy[300:340] = np.nan
        runs.append(run(number, [("time / s,x / m", [t, noisy])], f"start: {{position: {size} m}}"))
    stated = """\
    rig: {mass: 2 kg, taut: 0 m, attachment: both ways}
    identification: {free: [k, c], start: {k: 40 N/m}}
"""
    finding, plan = shown(tmp_path, stated, runs)
    assert_recovered(finding, plan, k=k, c=c)
    assert finding.equations == ("m·x″ = F − T", "T = k·e + c·e′, with e = x − x_t")
    assert finding.failures == ()
    residual = plan.traces["response/pull/r0/x"]["residual"]
    assert np.flatnonzero(np.isnan(residual)).tolist() == list(range(300, 340))
    assert np.nanstd(residual) == pytest.approx(1e-4, rel=0.1)


def test_planted_coast_without_a_line_shows_friction(tmp_path):
    """v = v₀ − F_c/m·t up to the stop: k and c have no meaning, friction is sought."""
    rng, runs = np.random.default_rng(2), []
    m, friction, t = 25.0, 0.05, np.arange(1000) / 50
    for number in range(4):
        v0 = 0.03 + 0.003 * number
        s = np.minimum(t, v0 * m / friction)
        x = v0 * s - 0.5 * friction / m * s**2 + 1e-4 * rng.standard_normal(t.size)
        extra = f"start: {{position: 0 m, velocity: {v0} m/s}}"
        runs.append(run(number, [("time / s,x / m", [t, x])], extra))
    stated = """\
    rig: {mass: 25 kg, taut: 0 m, attachment: none}
    identification: {free: [friction.force]}
"""
    finding, plan = shown(tmp_path, stated, runs)
    assert_recovered(finding, plan, **{"friction.force": friction})
    assert sought(finding)["friction.force"].u < 0.01 * friction


@pytest.mark.long
@pytest.mark.parametrize("channels", ["xvT", "xT", "v", "T"])
def test_planted_tether_held_at_first_with_any_channels_on_stamps_of_their_own(channels, tmp_path):
    truth, rng, runs = Truth(m=25.0, k=167.64, c=8.0, taut=0.1), np.random.default_rng(4), []
    rates = tuple(rate if name in channels else 0.0 for name, rate in zip("xvT", (50.0, 80.0, 100.0), strict=True))
    units = {"x": "m", "v": "m/s", "T": "N"}
    for number, test in enumerate((*SHORT, *HELD_OUT)):
        record = measure(truth, test, Instruments(rates=rates), rng)
        files = [(f"time / s,{n} / {units[n]}", [record.t[n], record.readings[n]]) for n in record.t]
        (on, push), *rest = test.thrust
        to = f"to: {rest[0][0]} s, " if rest else ""
        extra = f"held_until: {on} s, start: {{position: 0 m}}, thrust: [{{from: {on} s, {to}force: {push} N}}]"
        runs.append(run(number, files, extra))
    stated = """\
    rig: {mass: 25 kg, taut: 0.1 m}
    identification: {free: [k, c], start: {k: 150 N/m, c: 6 N*s/m}}
"""
    finding, plan = shown(tmp_path, stated, runs)
    assert_recovered(finding, plan, k=167.64, c=8.0)


@pytest.mark.long
def test_planted_spring_driven_by_a_force_that_a_column_holds(tmp_path):
    """m·x″ = F(t) − k·x − c·x′ with F measured, integrated by SciPy."""
    rng, runs = np.random.default_rng(6), []
    m, k, c, t = 2.0, 50.0, 0.8, np.arange(500) / 50
    for number in range(4):
        drive = CubicSpline(t, (1 + 0.2 * number) * np.sin(0.9 * t) ** 2 * np.cos(3.0 * t + number))
        solved = solve_ivp(
            lambda s, y, drive=drive: [y[1], (drive(s) - k * y[0] - c * y[1]) / m],
            (0, t[-1]), [0.0, 0.0], "DOP853", t, rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        x = solved.y[0] + 2e-4 * rng.standard_normal(t.size)
        runs.append(run(number, [("time / s,x / m,F / N", [t, x, drive(t)])], "start: {position: 0 m}"))
    stated = """\
    rig: {mass: 2 kg, taut: 0 m, attachment: both ways}
    identification: {free: [k, c], start: {k: 40 N/m}}
"""
    finding, plan = shown(tmp_path, stated, runs)
    assert_recovered(finding, plan, k=k, c=c)
    assert sought(finding)["k"].u < 0.01 * k


def test_planted_given_values_need_no_fit_and_every_run_judges(tmp_path):
    """k and c from elsewhere: right ones are validated, a stiffness that is 10 % off is not."""
    truth, rng, runs = Truth(m=25.0, k=167.64, c=8.0, taut=0.1), np.random.default_rng(5), []
    for number in range(2):
        record = measure(truth, Test("step", ((1.0, 0.62),), 10.0), Instruments(rates=(50.0, 0, 100.0)), rng)
        files = [(f"time / s,{n} / {u}", [record.t[n], record.readings[n]]) for n, u in (("x", "m"), ("T", "N"))]
        runs.append(run(number, files, "start: {position: 0 m}, thrust: [{from: 1 s, force: 0.62 N}]"))
    verdicts = {}
    for k in (167.64, 185.0):
        stated = f"""\
    rig: {{mass: 25 kg, taut: 0.1 m}}
    known: {{thrust_gain: {{per_run: 0.2 %}}}}
    stiffness: {{value: {k} ± 0.10 N/m, source: elsewhere}}
    damping: {{value: 8.00 ± 0.01 N*s/m, source: elsewhere}}
"""
        finding, plan = shown(tmp_path, stated, runs)
        verdicts[k] = plan.verification[0]["verdict"]
        assert (finding.status, finding.runs, len(plan.verification[0]["runs"])) == ("given", (), 2)
        assert finding.notes[-1].startswith("nothing is sought, so the runs for identification judge the model")
    assert verdicts == {167.64: "validated within u_val", 185.0: "not validated"}


LET_GO = "start: {position: 0.05 m}"


@pytest.mark.long
def test_limit_everything_exact_is_a_campaign_like_any_other(tmp_path):
    """k and c without an uncertainty and no `known:`: the prediction has a band of noise alone."""
    t = np.arange(300) / 50
    x = 0.05 * np.exp(-0.2 * t) * (np.cos(4.996 * t) + 0.2 / 4.996 * np.sin(4.996 * t))
    x += 1e-4 * np.random.default_rng(3).standard_normal(t.size)
    stated = """\
    rig: {mass: 2 kg, taut: 0 m, attachment: both ways}
    stiffness: {value: 50 N/m, source: elsewhere}
    damping: {value: 0.8 N*s/m, source: elsewhere}
"""
    runs = [run(0, [("time / s,x / m", [t, x])], LET_GO)]
    path = written(tmp_path, stated, runs)
    assert main(["report", str(path), "--output", str(tmp_path)]) == 0
    findings = from_json(tmp_path / "rig" / "results.json")
    assert findings.verification[0]["verdict"] == "validated within u_val"
    assert {result.quantity: result.u for result in findings.results} == {"omega_n": 0.0, "zeta": 0.0}


def test_law_results_do_not_depend_on_what_the_process_simulated_before(tmp_path, monkeypatch):
    """NumPy and the compiled forms differ in the last digits: which of them serves is not left to chance."""
    stated = """\
    rig: {mass: 2 kg, taut: 0 m, attachment: both ways}
    stiffness: {value: 50.00 ± 0.01 N/m, source: elsewhere}
    damping: {value: 0.800 ± 0.001 N*s/m, source: elsewhere}
"""
    t = np.arange(300) / 50
    noise = 1e-4 * np.random.default_rng(3).standard_normal(t.size)
    runs = [run(0, [("time / s,x / m", [t, 0.05 * np.exp(-0.2 * t) * np.cos(4.996 * t) + noise])], LET_GO)]
    found = []
    for loaded in ({base: engines.compiled(base) for base in (False, True)}, {}):
        monkeypatch.setattr(engines, "_ready", loaded)
        found.append(shown(tmp_path, stated, runs)[1].verification)
    assert found[0] == found[1]


FOLLOWING = """\
    rig: {mass: 25 kg, taut: 0.1 m}
    identification: {free: [k, c], start: {k: 150 N/m, c: 6 N*s/m}}
"""


def no_response_of_a_line(count):
    """Runs in which something else moved the module: it creeps on, and the cell wanders, whatever the thrust does."""
    rng, t = np.random.default_rng(1), np.arange(count) / 50
    heading, extra = "time / s,x / m,T / N", "start: {position: 0 m}, thrust: [{from: 1 s, force: 0.5 N}]"
    for number in range(4):
        x = 1e-4 * (np.abs(rng.standard_normal(t.size)).cumsum() + rng.standard_normal(t.size))
        T = 0.05 * np.abs(rng.standard_normal(t.size).cumsum()) + 1e-3 * rng.standard_normal(t.size)
        yield run(number, [(heading, [t, x, T])], extra)


def never_taut():
    """Runs in which the module only drifts: x = ½·F/m·(t − 1 s)² while it is pushed for a second."""
    rng, t = np.random.default_rng(2), np.arange(300) / 50
    extra = "start: {position: 0 m}, thrust: [{from: 1 s, to: 2 s, force: 0.5 N}]"
    for number in range(4):
        pushed, coasted = np.clip(t - 1, 0, 1), np.maximum(t - 2, 0)
        x = 0.5 * 0.02 * pushed**2 + 0.02 * coasted + 2e-4 * rng.standard_normal(t.size)
        yield run(number, [("time / s,x / m", [t, x])], extra)


SPENT = "the fit is not converged within 25 steps; "
FAILED = {
    "steps used up": (partial(no_response_of_a_line, 1000), (SPENT,)),
    "a search that ran away": (partial(no_response_of_a_line, 620), ("these runs say nothing about k (the search",)),
    "a line that never pulls": (never_taut, ("these runs say nothing about k; these runs say nothing about c (the",)),
}


@pytest.mark.long
@pytest.mark.parametrize("case", FAILED)
def test_refusal_a_fit_without_an_answer_is_a_sentence_in_the_report_and_status_1(case, tmp_path, capsys):
    runs, told = FAILED[case]
    path = written(tmp_path, FOLLOWING, list(runs()))
    command = "report" if case == "steps used up" else "run"
    assert main([command, str(path), "--output", str(tmp_path)]) == 1
    printed = capsys.readouterr()
    assert "Traceback" not in printed.err
    assert any(f"failed pull: {words}" in " ".join(printed.out.split()) for words in told)
    findings = from_json(tmp_path / "rig" / "results.json")
    (failure,) = findings.failures
    finding = findings.tests[0].response
    assert failure == f"pull: {finding.sentence}"
    assert finding.sentence.startswith(told)
    # No number of the line from anywhere: neither the search's last, nor those of the way of the paper.
    assert (finding.status, finding.sought, finding.paper) == ("failed", (), None)
    assert findings.results == findings.verification == ()
    assert not any("nothing to evaluate" in warning for warning in findings.warnings)
    if command == "report":
        page = (tmp_path / "rig" / "report.html").read_text(encoding="utf-8")
        assert page.count("the fit is not converged within 25 steps") >= 2


@pytest.mark.long
@pytest.mark.parametrize(
    ("u", "moved"),
    [
        ("0.1 mm", "free_length.shift"),
        ("5 mm", ""),
        ("0.1 mm, per_run: 0.05 mm", "free_length.shift, free_length.shift of r0, free_length.shift of r1"),
    ],
)
def test_planted_a_stated_input_that_the_runs_contradict_fails_a_check(u: str, moved: str, tmp_path) -> None:
    """A line that is taut 5 mm from where it is stated; no diagnosis takes it into the model."""
    rng, runs, t = np.random.default_rng(1), [], np.arange(600) / 100
    delta, omega = 0.2, np.sqrt(25 - 0.04)
    for number in range(4):
        size = 0.05 + 0.01 * number
        x = 0.005 + size * np.exp(-delta * t) * (np.cos(omega * t) + delta / omega * np.sin(omega * t))
        columns = [t, x + 1e-4 * rng.standard_normal(t.size)]
        runs.append(run(number, [("time / s,x / m", columns)], f"start: {{position: {size + 0.005} m}}"))
    stated = f"""\
    rig: {{mass: 2 kg, taut: 0 m, attachment: both ways}}
    known: {{free_length: {{common: {u}}}}}
    identification: {{free: [k, c], start: {{k: 40 N/m}}}}
"""
    finding, _ = shown(tmp_path, stated, runs)
    assert [one.name for one in finding.checks if one.passed is False] == (["stated inputs"] if moved else [])
    assert not moved or f"The fitted and the stated {moved} disagree by more than 4 u." in finding.checks[-1].sentence
