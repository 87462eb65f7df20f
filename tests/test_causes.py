"""The benchmark of causes: generators that are independent, right and repeatable; a score card that counts."""

import ast
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from metrology import chain
from metrology.campaign.load import load
from metrology.effects import causes

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.causes import cases, decay, elongation, public, swing, tether  # noqa: E402
from benchmarks.causes.alike import group  # noqa: E402
from benchmarks.causes.answers import Answer, read  # noqa: E402
from benchmarks.causes.closed import base_motion  # noqa: E402
from benchmarks.causes.judging import run  # noqa: E402
from benchmarks.causes.names import LATER, NAMES, STEPS  # noqa: E402
from benchmarks.causes.noise import KINDS, Sensor  # noqa: E402
from benchmarks.causes.plan import Plan  # noqa: E402
from benchmarks.causes.rig import Push, Rig, motion, toe  # noqa: E402
from benchmarks.causes.score import calibration_error, card, judge  # noqa: E402

HERE = ROOT / "benchmarks" / "causes"
NYLON = Rig(25.0, 168.0, 8.0, -0.05)
STAMPS = np.arange(0, 12.001, 0.005)


def test_generators_import_nothing_of_the_package():
    for file in [*HERE.glob("*.py"), *HERE.glob("entries/*.py")]:
        for node in ast.walk(ast.parse(file.read_text())):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) and node.level == 0 else []
            assert not [name for name in names if name.split(".")[0] == "metrology"], file


@pytest.mark.parametrize("method", NAMES)
def test_names_are_those_that_the_package_may_give(method):
    assert set(NAMES[method]) | LATER.get(method, set()) == {cause.name for _, cause in causes(method)}


@pytest.mark.parametrize(
    ("rig", "force", "until"),
    [
        (NYLON, 0.38, 3.0),
        (NYLON, 0.62, 30.0),
        (replace(NYLON, k=750.0, c=35.0), 0.62, 2.6),
        (replace(NYLON, m=15.0, c=4.0), 0.38, 30.0),
    ],
)
def test_closed_form_of_a_line_that_goes_slack_and_taut(rig, force, until):
    push = Push(force, 1.0, until)
    apart = np.abs(motion(rig, push, STAMPS) - base_motion(rig, push, STAMPS)).max(axis=1)
    assert (apart < [1e-9, 1e-9, 1e-7]).all()


def test_closed_form_of_a_coast_against_friction_and_drag():
    """Slack throughout: v = v₀ − F_c/m·t, and v₀·exp(−b·t/m), after the thrust ends."""
    rig = replace(NYLON, start=-50.0)
    t, push = np.arange(1.5, 11, 0.5), Push(0.5, 1.0, 1.5)
    v = motion(replace(rig, effects={"friction": 1e-4}), push, t)[1]
    assert v == pytest.approx((0.5 * 0.5 - 1e-4 * (t - 1.0)) / 25.0, abs=1e-12)
    v = motion(replace(rig, effects={"drag": 0.5}), push, t)[1]
    assert v == pytest.approx(v[0] * np.exp(-0.02 * (t - 1.5)), rel=1e-9)


def test_closed_form_of_a_lagged_thrust():
    """x″ = F/m·(1 − e^(−t/τ)): the speed lags by τ, once t is many τ."""
    rig = replace(NYLON, start=-50.0, effects={"thrust lag": 0.05})
    t = np.array([3.0, 5.0])
    v = motion(rig, Push(0.5, 1.0, 30.0), np.append(0.0, t))[1][1:]
    assert v == pytest.approx(0.5 / 25.0 * (t - 1.0 - 0.05), rel=1e-8)


def test_law_a_line_never_pushes_and_a_loss_takes_energy():
    for effects in ({}, {"hysteresis": 20.0}, {"zener": 20.0}, {"friction": 0.01}, {"damping": 100.0}):
        rig = replace(NYLON, c=1.0, effects=effects, shape={"hysteresis.yield": 2e-3, "zener.time": 0.3})
        x, v, T = motion(rig, Push(0.5, 1.0, 3.0), STAMPS)
        assert T.min() >= 0
        energy = 0.5 * 25 * v**2 + 0.5 * 168 * np.maximum(x, 0) ** 2
        slack = (x < -1e-3) & (STAMPS > 3.0)
        assert np.all(np.diff(energy[slack]) < 1e-9)


def test_limit_of_a_second_mode_is_a_compliance_in_series():
    """Far above the rig's own frequency, u = C·T: the line and the frame in series, k/(1 + C·k)."""
    C, omega = 1e-3, 400.0
    rig = replace(NYLON, c=1e-9, effects={"mode": omega**2 * C}, shape={"mode.frequency": omega, "mode.damping": 0.05})
    t = np.arange(0, 4.0, 0.01)
    found = motion(rig, Push(0.5, 1.0, 30.0), t)[0]
    assert found == pytest.approx(
        motion(replace(NYLON, c=1e-9, k=168 / (1 + C * 168)), Push(0.5, 1.0, 30.0), t)[0], abs=2e-5
    )


def test_closed_form_of_the_toe():
    assert toe(0.1, 0.02, 0.3) == pytest.approx(0.3 * 0.02)
    assert toe(0.01, 0.02, 0.3) == pytest.approx(0.3 * 0.01)


def test_closed_form_of_a_free_decay():
    body, t = swing.Body(0.2, 120.0, 0.03), np.arange(0, 10, 0.005)
    zero = replace(body, effects={"cubic": 1e-12})
    assert swing.swing(zero, 8e-3, t) == pytest.approx(swing.closed(body, 8e-3, t), abs=1e-10)


def test_closed_form_of_dry_friction():
    body, half = swing.Body(1.0, 100.0, 0.0, {"friction": 0.02}), np.pi / 10
    turns = swing.swing(body, 0.01, np.arange(0, 30) * half)
    for n in range(20):
        assert turns[n] == pytest.approx(swing.after_dry_friction(100.0, 0.02, 0.01, n), abs=1e-10)
    assert turns[-1] == pytest.approx(turns[26], abs=1e-12)  # at rest within F_c/k of zero


def test_closed_form_of_a_pendulums_period():
    """T = 4·K(sin(A/2))/ω (Landau & Lifshitz, Mechanics, 11)."""
    from scipy.special import ellipk

    body = swing.Body(1.0, 4.0, 0.0, {"pendulum": 1.0})
    period = 4 * ellipk(np.sin(0.5) ** 2) / 2.0
    assert swing.swing(body, 1.0, np.array([0.0, period / 2, 3 * period])) == pytest.approx([1.0, -1.0, 1.0], abs=1e-7)


def test_closed_form_of_an_elongation():
    b = elongation.bench("tape", np.random.default_rng(1))
    assert elongation.truth_of(b) == pytest.approx(b.force / b.k)
    slipped = elongation.truth_of(elongation.plant(b, "slip", 1e-4)) - elongation.truth_of(b)
    assert set(np.round(slipped, 12)) == {0.0, 1e-4}


@pytest.mark.parametrize("kind", KINDS)
def test_noise_has_the_stated_deviation(kind):
    found = KINDS[kind](200_000, np.random.default_rng(2))
    assert found.std() == pytest.approx(1.0, rel=0.05)
    assert abs(found.mean()) < 0.05


def test_quantised_readings_stand_on_steps():
    sensor = Sensor("bare", 1e-4, 1e-5, gaps=1)
    read_ = sensor.read(np.linspace(0, 0.01, 500), np.random.default_rng(3))
    assert np.isnan(read_).sum() >= 4
    steps = read_[np.isfinite(read_)] / 5e-4
    assert steps == pytest.approx(np.round(steps))


def test_a_planted_distance_is_what_a_refit_leaves():
    """Of a decay, fitted anew without the cause: χ² less what the noise has is d²."""
    plan = Plan("one", "decay", "spring", 5, ("friction",), (20.0,))
    specimen, rng = decay.SPECIMENS["spring"], plan.rng()
    body = swing.Body(0.2, 120.0, 0.03)
    sensor = Sensor("white", specimen.sigma, specimen.digit)
    rest = decay.Rest(body, specimen.amplitude, shape={"mains": 50.0, "other.frequency": 1.0, "other.rate": 1.0})
    size = decay.sized("friction", 20.0, rest, sensor, specimen, rng)
    t = np.arange(0, specimen.length, 1 / specimen.rate)
    x = decay.truth_of(decay.plant(rest, "friction", size), specimen.amplitude, t, 0.0)
    left = decay.refitted(t, x, body)
    assert np.linalg.norm(left) / sensor.u * np.sqrt(decay.RELEASES) == pytest.approx(20.0, rel=0.1)


def test_an_input_within_its_prior_has_the_distance_of_its_prior():
    """A cell gain of ten standard uncertainties costs at most ten, whatever else is refitted."""
    sensors = {channel: Sensor("white", tether.SIGMA[channel], tether.DIGIT[channel]) for channel in tether.SIGMA}
    refit = tether.Refit(tether.Rest(Rig(25.0, 168.0, 8.0, -tether.GAP)), sensors)
    found = refit.distance(tether.plant(refit.base, "cell gain", 10 * tether.KNOWN["cell gain"][0]))
    assert 5 < found <= 10


PLANS = [
    Plan("a", "decay", "tape", 1, ("other",), (30.0,), noise="ar1"),
    Plan("b", "elongation", "cord", 2, ("creep",), (10.0,), noise="heavy", traits=("wrong noise",)),
    Plan("c", "response", "nylon", 3, (), (), noise="bare", traits=("spikes", "gaps", "irregular", "wrong input")),
]


@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.method)
def test_a_seed_gives_the_same_files_twice(plan):
    assert cases.make(plan).files == cases.make(plan).files
    assert cases.make(plan).files != cases.make(replace(plan, seed=plan.seed + 1)).files


@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: plan.method)
def test_the_package_reads_every_kind_of_case(plan, tmp_path):
    cases.write(plan, tmp_path)
    assert load(tmp_path / plan.name / "campaign.yaml").tests
    expected = yaml.safe_load((tmp_path / plan.name / "expected.yaml").read_text())
    assert not set(expected["must_not"]) & {*expected["causes"], *(name for one in expected["group"] for name in one)}
    assert set(expected["verdict"]) <= set(STEPS)


def test_the_frozen_table_holds_each_kind_of_every_method():
    plans = list(cases.plans(cases.FROZEN_SEED, cases.FROZEN))
    assert len(plans) == len({plan.name for plan in plans}) == len({plan.seed for plan in plans}) == 61
    assert {(plan.method, plan.kind) for plan in plans} == {
        (method, kind) for method in cases.MAKERS for kind in ("nothing", "one", "pair", "unlisted", "remainder")
    }
    recorded = {line.split()[1] for line in cases.RECORD.read_text().splitlines()}
    assert recorded == {plan.name for plan in plans}


@pytest.mark.parametrize("name", ["elongation-one-large-1", "decay-nothing-1", "response-nothing-1"])
def test_the_frozen_table_is_still_what_it_was(name, tmp_path):
    recorded = dict(reversed(line.split()) for line in cases.RECORD.read_text().splitlines())
    plan = next(plan for plan in cases.plans(cases.FROZEN_SEED, cases.FROZEN) if plan.name == name)
    cases.write(plan, tmp_path)
    assert cases.digest(tmp_path / name) == recorded[name]


def test_names_that_look_alike_are_a_group_until_the_data_part_them():
    assert set(group("decay", "spring", "cubic", -1.0, 20.0)) == {"cubic", "pendulum"}
    assert group("decay", "spring", "cubic", 1.0, 20.0) == ()  # a pendulum never hardens
    assert set(group("response", "nylon", "frame", 1.0, 1e4)) == {"frame", "yaw"}


# ---- score card ------------------------------------------------------------------------------------------------------
EXPECTED = {
    "case": "x", "method": "decay", "kind": "one", "causes": ["cubic"], "group": [["cubic", "pendulum"]],
    "must_not": ["friction", "damping", "drift"], "verdict": ["explained"], "k": {"value": 2.0}, "c": {"value": 1.0},
}  # fmt: skip
NOTHING = {**EXPECTED, "kind": "nothing", "causes": [], "group": [], "verdict": ["nothing missing"]}


def test_judged_named_by_another_name_of_its_group():
    found = judge(
        EXPECTED, Answer("explained", ("pendulum",), (), {"pendulum": 0.9}, (2.0, 1.0, 3.0), (2.0, 1.5, 2.5)), 1.0
    )
    assert found.named
    assert found.exact
    assert not found.misnamed
    assert (found.k, found.c) == (True, False)
    assert (0.9, True) in found.events


def test_judged_a_false_name_beside_the_right_one():
    found = judge(EXPECTED, Answer("explained", ("cubic", "friction"), (), {"cubic": 0.6, "friction": 0.9}), 1.0)
    assert found.within
    assert found.misnamed
    assert not found.named  # the first name is the wrong one
    assert not found.exact


def test_judged_a_group_that_holds_the_right_name_is_no_false_one():
    found = judge(EXPECTED, Answer("ambiguous", (), (("cubic", "friction"),), {"cubic": 0.5, "friction": 0.45}), 1.0)
    assert found.named
    assert not found.misnamed
    assert not found.verdict


def test_judged_silence():
    assert judge(NOTHING, Answer("nothing missing"), 1.0).abstained
    assert not judge(NOTHING, Answer("unexplained"), 1.0).abstained
    assert not judge(NOTHING, Answer("not finished", failure="ran too long"), 1.0).answered
    assert judge(EXPECTED, Answer("nothing missing"), 1.0).abstained is None


def test_card_counts():
    right = judge(EXPECTED, Answer("explained", ("cubic",), (), {"cubic": 1.0}, held_out=(4.0, 1.0)), 1.0)
    wrong = judge(NOTHING, Answer("explained", ("friction",), (), {"friction": 0.8}, held_out=(1.0, 1.0)), 3.0)
    found = card([right, wrong])
    assert found["named (top-1)"] == [1, 1]
    assert found["abstained rightly"] == [0, 1]
    assert found["misnamed"] == [1, 2]
    assert found["Brier"] == pytest.approx((0.0 + 0.64) / 2)
    assert found["held-out gain"] == pytest.approx(2.0)


def test_calibration_error_by_hand():
    """Two bins: four at 0.95, three of them true; two at 0.55, one true."""
    every = [(0.95, True)] * 3 + [(0.95, False), (0.55, True), (0.55, False), (0.0, False)]
    assert calibration_error(every) == pytest.approx((abs(3 - 3.8) + abs(1 - 1.1)) / 6)


@pytest.mark.parametrize(
    ("found", "why"),
    [
        ({"verdict": "perhaps"}, "verdict: got 'perhaps'"),
        ({"verdict": "explained", "named": ["ghost"]}, "names that decay has not: ghost"),
        ({"verdict": "explained", "probabilities": {"cubic": 1.2}}, "a probability outside"),
    ],
)
def test_refusal_of_what_is_no_answer(found, why):
    with pytest.raises(ValueError, match=why):
        read(json.dumps(found), "decay")


def test_an_entry_is_a_command_that_does_not_see_the_answer(tmp_path, capsys):
    cases.write(Plan("seen", "elongation", "tape", 4), tmp_path)
    program = tmp_path / "entry.py"
    program.write_text(
        "import os, sys, json\n"
        "seen = 'expected.yaml' in os.listdir(sys.argv[1])\n"
        "print(json.dumps({'verdict': 'unexplained' if seen else 'nothing missing'}))\n"
    )
    ((judged, _),) = run(f"{sys.executable} {program}", [tmp_path / "seen"], 10, 1)
    assert judged.abstained
    program.write_text("while True: pass\n")
    ((judged, answer),) = run(f"{sys.executable} {program}", [tmp_path / "seen"], 1, 1)
    assert not judged.answered
    assert "within 1 s" in answer.failure
    capsys.readouterr()


def test_a_public_record_becomes_a_case(tmp_path):
    t = np.arange(0, 20, 0.02)
    rows = "\n".join(f"{a:.2f},{b:.5f}" for a, b in zip(t, np.exp(-0.05 * t) * np.cos(2 * t), strict=True))
    (tmp_path / "release.csv").write_text(f"time / s,angle / rad\n{rows}\n")
    folder = public.convert("torsion-pendulum", [tmp_path / "release.csv"], tmp_path)
    assert load(folder / "campaign.yaml").tests
    assert yaml.safe_load((folder / "expected.yaml").read_text())["group"] == [["cubic", "pendulum"]]


@pytest.mark.long
def test_planted_two_effects_of_which_the_first_was_found_in_another_kind(tmp_path):
    """A bow and a backlash: beside the wrong bow a drift made up for it, and k was 14 % and 8 u off."""
    plans = cases.plans(119, {"elongation": {"pair": 14}})
    plan = next(one for one in plans if one.name == "elongation-s119-pair-14")
    cases.write(plan, tmp_path)
    folder = tmp_path / plan.name
    found = chain.evaluate(load(folder / "campaign.yaml"), coverage=False)
    assert set(found.diagnosis[0].named) == {"backlash", "curvature"}
    (k,) = [one for one in found.results if one.quantity == "k"]
    true = yaml.safe_load((folder / "expected.yaml").read_text())["k"]["value"]
    assert abs(k.value - true) < 3 * k.u < 0.05 * true
