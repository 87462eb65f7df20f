"""Response tests of other rigs through the front door: a campaign folder goes in, k, c and a verdict come out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from response_cases import HELD_OUT, SHORT
from truth_response import Instruments, Test, Truth, measure

from metrology.campaign.load import load
from metrology.chain.plan import Plan
from metrology.chain.response import add_response

HEAD = """\
format: metrology-campaign/1
id: rig
title: A rig
samples: {line: {}}
instruments: {mocap: {kind: motion capture}}
tests:
  pull:
    method: response
    sample: line
    instruments: {position: mocap}
"""


def campaign(folder, stated, runs):
    """Write the campaign: `stated` below the test, and runs (name, purpose, columns by file, thrust, start)."""
    text = HEAD + stated + "    runs:\n"
    for name, purpose, files, extra in runs:
        listed = []
        for number, (heading, columns) in enumerate(files):
            listed.append(f"{name}-{number}.csv")
            rows = [",".join("" if np.isnan(value) else f"{value:.9g}" for value in row) for row in columns.T]
            (folder / listed[-1]).write_text("\n".join([heading, *rows]) + "\n")
        text += f"      {name}: {{purpose: {purpose}, readings: [{', '.join(listed)}], {extra}}}\n"
    (folder / "campaign.yaml").write_text(text)
    return load(folder / "campaign.yaml")


def shown(folder, stated, runs):
    loaded, plan = campaign(folder, stated, runs), Plan()
    return add_response(plan, loaded, "pull", loaded.tests["pull"], lambda _text: None), plan


def sought(finding):
    return {entry.name: entry for entry in finding.sought}


def purposes():
    return ("identification", "identification", "verification", "verification")


def test_planted_spring_let_go_without_thrust_and_with_position_alone(tmp_path):
    """Free decay of a line attached both ways, x = A·e^(−δt)·(cos ωt + δ/ω·sin ωt), from an initial state."""
    rng, runs = np.random.default_rng(1), []
    m, k, c = 2.0, 50.0, 0.8
    delta, t = c / (2 * m), np.arange(1200) / 100
    omega = np.sqrt(k / m - delta**2)
    for number, purpose in enumerate(purposes()):
        size = 0.05 + 0.01 * number
        x = size * np.exp(-delta * t) * (np.cos(omega * t) + delta / omega * np.sin(omega * t))
        noisy = x + 1e-4 * rng.standard_normal(t.size)
        noisy[300:340] = np.nan
        runs.append(
            (f"r{number}", purpose, [("time / s,x / m", np.vstack([t, noisy]))], f"start: {{position: {size} m}}")
        )
    stated = """\
    rig: {mass: 2 kg, taut: 0 m, attachment: both ways}
    identification: {free: [k, c], start: {k: 40 N/m}}
"""
    finding, plan = shown(tmp_path, stated, runs)
    for name, true in (("k", k), ("c", c)):
        assert abs(sought(finding)[name].value - true) < 4 * sought(finding)[name].u
    assert finding.equations == ("m·x″ = F − T, T = k·e + c·e′, e = x − x_t",)
    assert plan.verification[0]["verdict"] == "validated within u_val"
    assert finding.failures == ()


def test_planted_coast_without_a_line_shows_friction(tmp_path):
    """v = v₀ − F_c/m·t up to the stop: k and c have no meaning, friction is sought."""
    rng, runs = np.random.default_rng(2), []
    m, friction, t = 25.0, 0.05, np.arange(1000) / 50
    for number, purpose in enumerate(purposes()):
        v0 = 0.03 + 0.003 * number
        s = np.minimum(t, v0 * m / friction)
        x = v0 * s - 0.5 * friction / m * s**2 + 1e-4 * rng.standard_normal(t.size)
        extra = f"start: {{position: 0 m, velocity: {v0} m/s}}"
        runs.append((f"r{number}", purpose, [("time / s,x / m", np.vstack([t, x]))], extra))
    stated = """\
    rig: {mass: 25 kg, taut: 0 m, attachment: none}
    identification: {free: [friction.force]}
"""
    finding, plan = shown(tmp_path, stated, runs)
    found = sought(finding)["friction.force"]
    assert abs(found.value - friction) < 4 * found.u
    assert found.u < 0.01 * friction
    assert plan.verification[0]["verdict"] == "validated within u_val"


@pytest.mark.parametrize("channels", ["xvT", "xT", "v", "T"])
def test_planted_tether_held_at_first_with_any_channels_on_stamps_of_their_own(channels, tmp_path):
    truth, rng, runs = Truth(m=25.0, k=167.64, c=8.0, taut=0.1), np.random.default_rng(4), []
    rates = tuple(rate if name in channels else 0.0 for name, rate in zip("xvT", (50.0, 80.0, 100.0), strict=True))
    units = {"x": "m", "v": "m/s", "T": "N"}
    for test, purpose in zip((*SHORT, *HELD_OUT), purposes(), strict=True):
        record = measure(truth, replace(test, duration=test.duration), Instruments(rates=rates), rng)
        files = [(f"time / s,{n} / {units[n]}", np.vstack([record.t[n], record.readings[n]])) for n in record.t]
        (on, push), *rest = test.thrust
        to = f"to: {rest[0][0]} s, " if rest else ""
        extra = f"held_until: {on} s, start: {{position: 0 m}}, thrust: [{{from: {on} s, {to}force: {push} N}}]"
        runs.append((test.name, purpose, files, extra))
    stated = """\
    rig: {mass: 25 kg, taut: 0.1 m}
    identification: {free: [k, c], start: {k: 150 N/m, c: 6 N*s/m}}
"""
    finding, plan = shown(tmp_path, stated, runs)
    for name, true in (("k", 167.64), ("c", 8.0)):
        assert abs(sought(finding)[name].value - true) < 4 * sought(finding)[name].u
    assert plan.verification[0]["verdict"] == "validated within u_val", plan.verification[0]["sentence"]


def test_planted_given_values_need_no_fit_and_every_run_judges(tmp_path):
    """k and c from elsewhere: right ones are validated, a stiffness that is 10 % off is not."""
    truth, rng, runs = Truth(m=25.0, k=167.64, c=8.0, taut=0.1), np.random.default_rng(5), []
    for name in ("a", "b"):
        record = measure(truth, Test(name, ((1.0, 0.62),), 10.0), Instruments(rates=(50.0, 0, 100.0)), rng)
        files = [
            (f"time / s,{n} / {u}", np.vstack([record.t[n], record.readings[n]])) for n, u in (("x", "m"), ("T", "N"))
        ]
        runs.append((name, "identification", files, "start: {position: 0 m}, thrust: [{from: 1 s, force: 0.62 N}]"))
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
