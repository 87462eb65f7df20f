"""What a response test finds as Zener relaxation, and what a held elongation of the same line shows, are compared."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from rig_folder import run, written
from scipy.integrate import solve_ivp
from truth_relaxation import Held, record

from metrology import chain
from metrology.campaign.load import load
from metrology.chain import zener

pytestmark = pytest.mark.long

M, K, K_1, TAU, C = 20.0, 50.0, 10.0, 0.8, 1.0
HEAD = """\
format: metrology-campaign/1
id: rig
title: A line that swings and is held
diagnosis: {}
monte_carlo: {max_trials: 1000, digits: 1}
samples: {line: {}, other: {}}
instruments:
  mocap: {kind: motion capture}
  cell: {kind: load cell, class: "0.5"}
  machine: {kind: testing machine, class: "0.5"}
tests:
"""
HOLD = """\
  NAME:
    method: relaxation
    sample: SAMPLE
    instruments: {force: cell, crosshead: machine}
    setup_compliance: 0.00(1) um/N
    specimens: {a: {readings: NAME.csv}}
"""
PULL = """\
  pull:
    method: response
    sample: line
    instruments: {position: mocap}
"""
STATED = """\
    rig: {mass: 20 kg, taut: 0 m, attachment: both ways}
    identification: {free: [k, c], start: {k: 52 N/m, c: 1.2 N*s/m}}
"""


def swings() -> list:
    """Four runs under a measured force: m·x″ = F − k·x − k₁·(x − z) − c·x′, z′ = (x − z)/τ, by SciPy."""
    rng, t, found = np.random.default_rng(3), np.arange(1200) / 20, []
    for number in range(4):
        low, high = 0.2 + 0.05 * number, 3.0 + 0.2 * number

        def drive(s, low=low, high=high):
            # A sweep from far below to above the resonance: k, k + k₁ and the loss between them.
            return 2.0 * np.sin(low * s + (high - low) * s**2 / (2 * 60.0))

        def motion(s, y, drive=drive):
            x, v, z = y
            return [v, (drive(s) - K * x - K_1 * (x - z) - C * v) / M, (x - z) / TAU]

        x = solve_ivp(motion, (0, t[-1]), [0.0, 0.0, 0.0], "DOP853", t, rtol=1e-10, atol=1e-13).y[0]
        x = x + 1e-3 * rng.standard_normal(t.size)
        found.append(run(number, [("time / s,x / m,F / N", [t, x, drive(t)])], "start: {position: 0 m}"))
    return found


SAME = Held(
    stiff=K + K_1,
    parts=(K_1 / (K + K_1),),
    times=(TAU,),
    levels=(0.05,),
    holds=(20.0,),
    ramp=0.1,
    rate=100.0,
    read_noise=2e-3,
)
HELD = {
    "same": ("line", SAME),
    "unlike": ("line", replace(SAME, parts=(0.05,), times=(1.5,))),
    "slow": ("line", replace(SAME, ramp=20.0, holds=(200.0,), times=(30.0,), rate=10.0)),
    "elsewhere": ("other", SAME),
}
"""Holds by the name of their test: sample, and what the testing machine read."""


@pytest.fixture(scope="module")
def findings(tmp_path_factory):
    """Everything that one campaign says of the response and of all holds."""
    folder, head = tmp_path_factory.mktemp("zener"), HEAD
    for name, (sample, held) in HELD.items():
        one = record(held, np.random.default_rng(2 if name == "elsewhere" else 1))
        rows = np.column_stack([one["time"], one["force"], 1e3 * one["elongation"]])
        heading = "time / s,force / N,crosshead / mm"
        np.savetxt(folder / f"{name}.csv", rows, "%.9g", ",", header=heading, comments="")
        head += HOLD.replace("NAME", name).replace("SAMPLE", sample)
    return chain.evaluate(load(written(folder, STATED, swings(), head + PULL)))


def compared(findings, name):
    """Comparisons of the Zener element with a hold, by what is compared."""
    return {
        one.title.partition(":")[0]: one
        for one in findings.comparisons
        if "Zener" in one.title and f"of {name}" in one.title
    }


@pytest.mark.parametrize(("name", "agrees"), [("same", True), ("unlike", False)])
def test_planted_a_zener_element_agrees_with_a_hold_of_the_same_line_alone(name, agrees, findings):
    found, held = compared(findings, name), HELD[name][1]
    time, part = found["Relaxation time"], found["Part of the stiffness that relaxes"]
    assert (time.agrees, part.agrees) == (agrees, agrees)
    assert abs(time.value_a - TAU) < 4 * time.u_a
    assert abs(part.value_a - K_1 / (K + K_1)) < 4 * part.u_a
    assert time.value_b == pytest.approx(held.times[0], rel=0.05)
    assert part.value_b == pytest.approx(held.parts[0], rel=0.05)
    assert (time.unit, part.unit) == ("s", "1")
    assert time.en == pytest.approx((time.value_a - time.value_b) / np.hypot(2 * time.u_a, 2 * time.u_b), rel=1e-6)


def test_limit_a_time_that_the_hold_does_not_resolve_is_not_compared(findings):
    """A ramp of 20 s resolves branches from 1 s on."""
    assert not compared(findings, "slow")
    assert any("is not compared with slow" in one and "resolves" in one for one in findings.warnings)


def test_limit_another_sample_is_not_compared(findings):
    assert not compared(findings, "elsewhere")
    assert not [one for one in findings.warnings if "Zener" in one and "elsewhere" in one]


def test_closed_form_parts_of_two_branches(monkeypatch):
    """What is faster has relaxed: its stiffness is no part of what the slower branch takes its part of."""
    values = {"k": (50.0, 0.1), "zener.stiffness": (8.0, 0.2), "zener.time": (4.0, 0.05),
              "second_branch.stiffness": (12.0, 0.3), "second_branch.time": (0.25, 0.01)}  # fmt: skip
    estimates = {f"pull.{name}": SimpleNamespace(reported=pair) for name, pair in values.items()}
    monkeypatch.setattr(zener, "correlation", lambda *_: 0.0)
    slow, fast = zener._elements(SimpleNamespace(estimates=estimates), "pull")
    assert (slow.time, slow.part) == (4.0, pytest.approx(8 / 58))
    assert (fast.time, fast.part) == (0.25, pytest.approx(12 / 70))
    assert slow.part_u == pytest.approx(np.hypot(50 * 0.2, 8 * 0.1) / 58**2)
    assert fast.part_u == pytest.approx(np.linalg.norm([58 * 0.3, 12 * 0.1, 12 * 0.2]) / 70**2)
