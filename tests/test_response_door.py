"""Response tests of other rigs through the front door: a campaign folder goes in, k, c and a verdict come out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from response_cases import HELD_OUT, SHORT
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from truth_response import Instruments, Test, Truth, measure

from metrology.campaign.load import load
from metrology.chain.plan import Plan
from metrology.chain.response import add_response
from metrology.errors import MetrologyError

HEAD = """\
format: metrology-campaign/1
id: rig
title: A rig
diagnosis: {off: true}
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
    assert finding.equations == ("m·x″ = F − T", "T = k·e + c·e′, with e = x − x_t")
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


def test_planted_spring_driven_by_a_force_that_a_column_holds(tmp_path):
    """m·x″ = F(t) − k·x − c·x′ with F measured, integrated by SciPy."""
    rng, runs = np.random.default_rng(6), []
    m, k, c, t = 2.0, 50.0, 0.8, np.arange(500) / 50
    for number, purpose in enumerate(purposes()):
        drive = CubicSpline(t, (1 + 0.2 * number) * np.sin(0.9 * t) ** 2 * np.cos(3.0 * t + number))
        solved = solve_ivp(
            lambda s, y, drive=drive: [y[1], (drive(s) - k * y[0] - c * y[1]) / m],
            (0, t[-1]), [0.0, 0.0], "DOP853", t, rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        x = solved.y[0] + 2e-4 * rng.standard_normal(t.size)
        columns = np.vstack([t, x, drive(t)])
        runs.append((f"r{number}", purpose, [("time / s,x / m,F / N", columns)], "start: {position: 0 m}"))
    stated = """\
    rig: {mass: 2 kg, taut: 0 m, attachment: both ways}
    identification: {free: [k, c], start: {k: 40 N/m}}
"""
    finding, plan = shown(tmp_path, stated, runs)
    for name, true in (("k", k), ("c", c)):
        assert abs(sought(finding)[name].value - true) < 4 * sought(finding)[name].u
    assert sought(finding)["k"].u < 0.01 * k
    assert plan.verification[0]["verdict"] == "validated within u_val"


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


PENDULUM = """\
    rig: {inertia: 0.0200 kg*m^2, taut: 0 rad, attachment: both ways}
    known: {inertia: {common: 0.2 %, source: dimensions}, start_position: {per_run: 1 mrad}}
    identification: {free: [k, c], start: {k: 0.3 N*m/rad, c: 0.001 N*m*s/rad}}
"""


def pendulum():
    """Runs of a torsion pendulum by SciPy: let go, or driven by a torque; angles in degrees, rates in rad/s."""
    from scipy.integrate import solve_ivp

    rng, runs, t = np.random.default_rng(6), [], np.arange(1000) / 50
    inertia, k, c = 0.02, 0.35, 0.0025
    for number, purpose in enumerate(purposes()):
        start, torque = (0.0, 0.02 + 0.005 * number) if number % 2 else (0.3 + 0.05 * number, 0.0)
        moved = solve_ivp(
            lambda t, y, torque=torque: [y[1], (torque * (t >= 1.0) - k * y[0] - c * y[1]) / inertia],
            (0.0, 20.0), [start, 0.0], "DOP853", t, rtol=1e-11, atol=1e-13, max_step=0.05,
        ).y  # fmt: skip
        angle = np.degrees(moved[0]) + 0.02 * rng.standard_normal(t.size)
        rate = moved[1] + 2e-3 * rng.standard_normal(t.size)
        twist = k * moved[0] + c * moved[1] + 2e-4 * rng.standard_normal(t.size)
        drive = f", thrust: [{{from: 1 s, torque: {torque} N*m}}]" if torque else ""
        files = [("time / s,angle / deg,rate / rad/s,torque / N*m", np.vstack([t, angle, rate, twist]))]
        runs.append((f"r{number}", purpose, files, f"start: {{position: {start} rad}}{drive}"))
    return runs


def test_planted_torsion_pendulum_in_angles_and_torques(tmp_path):
    """J·φ″ = M − k·φ − c·φ′ by SciPy: k and c come back in their units, no E, and held-out runs validate them."""
    finding, plan = shown(tmp_path, PENDULUM, pendulum())
    for name, true, unit in (("k", 0.35, "N·m/rad"), ("c", 0.0025, "N·m·s/rad")):
        found = sought(finding)[name]
        assert abs(found.value - true) < 4 * found.u
        assert (found.unit, finding.coordinate) == (unit, "angle")
    assert finding.equations == ("J·φ″ = M − T", "T = k·e + c·e′, with e = φ − φ_t")
    assert [one.unit for one in finding.runs[0].channels] == ["rad", "rad/s", "N·m"]
    assert finding.notes[-1].startswith("no modulus follows from k")
    units = {measurand.name: measurand.unit for measurand in plan.measurands}
    assert (units["pull.k"], units["pull.c"]) == ("N·m/rad", "N·m·s/rad")
    assert "pull.E" not in units
    (judged,) = plan.verification
    assert judged["verdict"] == "validated within u_val", judged["sentence"]


MIXED = {
    "mass": ("inertia: 0.0200 kg*m^2", "mass: 2 kg", "tests.pull.rig.taut: got '0 rad', an angle; expected a length"),
    "both": (
        "inertia: 0.0200",
        "mass: 2 kg, inertia: 0.0200",
        "rig: got 'mass' and 'inertia' together; expected a mass",
    ),
    "taut": ("taut: 0 rad", "taut: 0 m", "tests.pull.rig.taut: got '0 m', a length; expected an angle"),
    "k": ("k: 0.3 N*m/rad", "k: 0.3 N/m", "start.k: got '0.3 N/m', a stiffness; expected"),
    "known": (
        "known: {inertia: {common: 0.2 %",
        "known: {mass: {common: 0.2 %",
        "known.mass: got 'mass' with 'inertia'",
    ),
    "start": (
        "{per_run: 1 mrad}",
        "{per_run: 1 mm}",
        "known.start_position.per_run: got '1 mm', a length; expected an",
    ),
    "weight": ("both ways}", "both ways, line_weight: catenary}", "rig.line_weight: got 'catenary' with 'inertia'"),
}


@pytest.mark.parametrize("case", MIXED)
def test_refusal_units_of_a_straight_path_on_a_rig_that_turns(case, tmp_path):
    old, new, told = MIXED[case]
    assert old in PENDULUM
    with pytest.raises(MetrologyError) as caught:
        campaign(tmp_path, PENDULUM.replace(old, new), pendulum()[:1])
    assert any(told in str(fault) for fault in caught.value.faults), [str(fault) for fault in caught.value.faults]


def test_refusal_columns_and_thrust_of_a_straight_path_on_a_rig_that_turns(tmp_path):
    (_, _, ((_, columns),), _), *_ = runs = pendulum()[:2]
    told = []
    for heading in ("time / s,x / m,v / m/s,T / N", "time / s,angle / m,rate / m/s,torque / N"):
        with pytest.raises(MetrologyError) as caught:
            campaign(tmp_path, PENDULUM, [("a", "identification", [(heading, columns)], "start: {position: 0.3 rad}")])
        told += [str(fault).partition(": ")[2] for fault in caught.value.faults]
    assert "got 'x / m', an unknown column" in told[0]
    assert "got 'angle / m', a length; expected an angle, such as 'angle / rad'" in told[3]
    forced = [(*run[:3], run[3].replace("torque: 0.025 N*m", "force: 0.025 N")) for run in runs]
    with pytest.raises(MetrologyError, match=r"thrust\[0\].force: got '0.025 N'; expected a torque, such as"):
        campaign(tmp_path, PENDULUM, forced)
