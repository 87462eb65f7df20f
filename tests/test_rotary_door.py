"""Response tests of a rig that turns through the front door: inertia, angles and torques go in, k and c come out."""

from __future__ import annotations

import re

import numpy as np
import pytest
import yaml
from rig_folder import HEAD, assert_recovered, run, shown, written
from scipy.integrate import solve_ivp

from metrology.campaign.extension import extended
from metrology.campaign.load import load
from metrology.cli import main
from metrology.diagnostics.force import missing_force
from metrology.diagnostics.runs import Response
from metrology.errors import MetrologyError
from metrology.estimation import MeasuredRun
from metrology.findings import from_json
from metrology.language.answers import answers
from metrology.rig import EFFECTS, Rig, Run, simulate
from metrology.rig.model import STRAIGHT

PENDULUM = """\
    rig: {inertia: 0.0200 kg*m^2, taut: 0 rad, attachment: both ways}
    known: {inertia: {common: 0.2 %, source: dimensions}, start_position: {per_run: 1 mrad}}
    identification: {free: [k, c], start: {k: 0.3 N*m/rad, c: 0.001 N*m*s/rad}}
"""


HEADING = "time / s,angle / deg,rate / rad/s,torque / N*m"


def pendulum(drag=0.0, most=np.inf, signs=(1, 1, 1)):
    """Runs of a torsion pendulum by SciPy: let go, or driven by a torque; angles in degrees, rates in rad/s.

    `drag` / (N·m·s²/rad²) of the air; a cell that reads no more than `most` / (N·m); signs of the three channels.
    """
    rng, runs, t = np.random.default_rng(6), [], np.arange(1000) / 50
    inertia, k, c = 0.02, 0.35, 0.0025
    for number in range(4):
        start, torque = (0.0, 0.02 + 0.005 * number) if number % 2 else (0.3 + 0.05 * number, 0.0)
        moved = solve_ivp(
            lambda t, y, torque=torque: [
                y[1], (torque * (t >= 1.0) - k * y[0] - c * y[1] - drag * y[1] * abs(y[1])) / inertia
            ],
            (0.0, 20.0), [start, 0.0], "DOP853", t, rtol=1e-11, atol=1e-13, max_step=0.05,
        ).y  # fmt: skip
        angle = np.degrees(moved[0]) + 0.02 * rng.standard_normal(t.size)
        rate = moved[1] + 2e-3 * rng.standard_normal(t.size)
        twist = k * moved[0] + c * moved[1] + 2e-4 * rng.standard_normal(t.size)
        twist = np.clip(twist, -most, most)
        drive = f", thrust: [{{from: 1 s, torque: {torque} N*m}}]" if torque else ""
        files = [(HEADING, [t, *(sign * part for sign, part in zip(signs, (angle, rate, twist), strict=True))])]
        runs.append(run(number, files, f"start: {{position: {start} rad}}{drive}"))
    return runs


@pytest.mark.long
def test_planted_torsion_pendulum_in_angles_and_torques(tmp_path):
    """J·φ″ = M − k·φ − c·φ′ by SciPy: k and c come back in their units, no E, and held-out runs validate them."""
    finding, plan = shown(tmp_path, PENDULUM, pendulum())
    assert_recovered(finding, plan, k=0.35, c=0.0025)
    assert [entry.unit for entry in finding.sought] == ["N·m/rad", "N·m·s/rad"]
    assert finding.coordinate == "angle"
    assert finding.equations == ("J·φ″ = M − T", "T = k·e + c·e′, with e = φ − φ_t")
    assert [one.unit for one in finding.runs[0].channels] == ["rad", "rad/s", "N·m"]
    assert finding.notes[-1].startswith("no modulus follows from k")
    units = {measurand.name: measurand.unit for measurand in plan.measurands}
    assert (units["pull.k"], units["pull.c"]) == ("N·m/rad", "N·m·s/rad")
    assert "pull.E" not in units


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


@pytest.mark.long
@pytest.mark.parametrize("case", MIXED)
def test_refusal_units_of_a_straight_path_on_a_rig_that_turns(case, tmp_path):
    old, new, told = MIXED[case]
    assert old in PENDULUM
    with pytest.raises(MetrologyError) as caught:
        load(written(tmp_path, PENDULUM.replace(old, new), pendulum()[:1]))
    assert any(told in str(fault) for fault in caught.value.faults), [str(fault) for fault in caught.value.faults]


def test_refusal_columns_and_thrust_of_a_straight_path_on_a_rig_that_turns(tmp_path):
    (_, _, ((_, columns),), _), *_ = runs = pendulum()[:2]
    told = []
    for heading in ("time / s,x / m,v / m/s,T / N", "time / s,angle / m,rate / m/s,torque / N"):
        with pytest.raises(MetrologyError) as caught:
            load(written(tmp_path, PENDULUM, [run(0, [(heading, columns)], "start: {position: 0.3 rad}")]))
        told += [str(fault).partition(": ")[2] for fault in caught.value.faults]
    assert "got 'x / m', an unknown column" in told[0]
    assert "got 'angle / m', a length; expected an angle, such as 'angle / rad'" in told[3]
    forced = [(*one[:3], one[3].replace("torque: 0.025 N*m", "force: 0.025 N")) for one in runs]
    with pytest.raises(MetrologyError, match=r"thrust\[0\].force: got '0.025 N'; expected a torque, such as"):
        load(written(tmp_path, PENDULUM, forced))


SIGNS = {
    "torque": ((1, 1, -1), "torque: got torque falls as angle grows; expected torque that grows with angle"),
    "rate": ((1, -1, 1), "rate: got a rate against the change of angle; expected rate = d angle/dt"),
    "angle": ((-1, -1, -1), "angle: got an angle that moves against the torque of 0.025 N·m; expected an angle that"),
}


@pytest.mark.long
@pytest.mark.parametrize("case", SIGNS)
def test_refusal_a_sign_that_does_not_fit_the_others(case, tmp_path, capsys):
    signs, told = SIGNS[case]
    path = written(tmp_path, PENDULUM, pendulum(signs=signs))
    assert main(["run", str(path), "--output", str(tmp_path)]) == 2
    assert f"tests.pull.runs.r1 {told}" in " ".join(capsys.readouterr().err.split())


@pytest.mark.long
def test_planted_saturated_torque_cell_is_told_at_both_ends_and_left_out(tmp_path):
    """Runs of either purpose swing beyond the cell: k, c and the verdict stay right."""
    finding, plan = shown(tmp_path, PENDULUM, pendulum(most=0.08))
    assert_recovered(finding, plan, k=0.35, c=0.0025)
    told = [note for note in finding.notes if "saturated" in note]
    assert [note.partition(";")[0] for note in told] == [
        f"{name}: the torque cell was saturated at {end} N·m" for name in ("r0", "r2") for end in ("0.08", "-0.08")
    ]


GIVEN = """\
    rig: {inertia: 0.0200 kg*m^2, taut: 0 rad, attachment: both ways}
    known: {inertia: {common: 0.02 %, source: dimensions}, start_position: {per_run: 1 mrad}}
    stiffness: {value: VALUE ± 0.0001 N*m/rad, source: torsion test}
    damping: {value: 0.00250 ± 0.00001 N*m*s/rad, source: decay}
"""


@pytest.mark.long
@pytest.mark.parametrize(("k", "verdict"), [("0.3500", "validated within u_val"), ("0.3600", "not validated")])
def test_planted_given_values_are_simulated_and_judged_by_every_run(k, verdict, tmp_path):
    finding, plan = shown(tmp_path, GIVEN.replace("VALUE", k), pendulum())
    assert finding.status == "given"
    assert [(one.name, one.unit) for one in finding.given] == [("k", "N·m/rad"), ("c", "N·m·s/rad")]
    (judged,) = plan.verification
    assert (judged["verdict"], len(judged["runs"])) == (verdict, 4), judged["sentence"]


STRAIGHT_WORDS = re.compile(r"\b(position|velocity|tension|elongation|force|module|E)\b|\bm/s\b|\bN\b(?!·m)")


def assert_tells_of_angles(found):
    """The chapter is in words and units of a rig that turns, in its pictures as well."""
    titles = {picture.key: picture.title for picture in found.pictures}
    axes = {picture.key: (picture.x, picture.x_unit, picture.y, picture.y_unit) for picture in found.pictures}
    assert axes["force-velocity"] == ("rate", "rad/s", "torque", "N·m")
    assert axes["force-elongation"] == ("twist", "rad", "torque", "N·m")
    assert axes["loop"] == ("angle", "rad", "torque", "N·m")
    assert titles["loop"].startswith("Torque against angle, r")
    assert [titles[f"spectrum-{name}"].rpartition(" ")[2] for name in "xvT"] == ["angle", "rate", "torque"]
    told = [
        *titles.values(),
        *(one.sentence for one in (*found.pictures, *found.tests)),
        *dict(answers(found)).values(),
    ]
    told += [text for one in found.causes for text in (one.title, one.consequence, one.advice)]
    told += [one.title for one in found.detectable]
    assert [text for text in told if STRAIGHT_WORDS.search(text)] == []
    assert "Held-out residuals over noise, as stated → extended: angle " in dict(answers(found))["What does it change?"]


def lacking(coordinate):
    """What a model without drag lacks in runs with it: by smooth forces of any form, and by the balance alone."""
    rig, t = Rig(0.02, 0.35, 0.0025, attachment="both ways", coordinate=coordinate), np.arange(600) / 30
    rng, noise, runs = np.random.default_rng(3), {"x": 3e-4, "v": 2e-3, "T": 2e-4}, []
    for start in (0.3, 0.4):
        run = Run(start, t_x=t, t_v=t, t_T=t)
        moved = simulate(rig.with_values({"drag.quadratic": 1e-3}), run)
        readings = {name: getattr(moved, name) + u * rng.standard_normal(t.size) for name, u in noise.items()}
        runs.append(MeasuredRun(f"r{start}", run, **readings, noise=noise, coordinate=coordinate))
    subject = Response(rig, tuple(runs), ("k", "c"), ())
    return subject.missing(subject.fit((), [{}])), missing_force(rig, runs, [{}, {}])


def test_law_what_is_missing_is_the_same_number_in_words_of_either_rig():
    for straight, turns in zip(lacking("position"), lacking("angle"), strict=True):
        for name in ("at", "value", "u"):
            assert getattr(turns, name) == pytest.approx(getattr(straight, name), rel=1e-6)
        assert (straight.quantity, straight.unit) == ("missing force", "N")
        assert (turns.quantity, turns.unit) == ("missing torque", "N·m")
        known = {
            "velocity": ("rate", "rad/s"), "position": ("angle", "rad"), "elongation": ("twist", "rad"),
            "rate of elongation": ("rate of twist", "rad/s"),
        }  # fmt: skip
        assert (turns.against, turns.against_unit) == known[straight.against]
        assert [{"time": ("time",), "tension": ("torque",), **known}[name][0] for name in straight.share] == [
            *turns.share
        ]
        assert not STRAIGHT_WORDS.search(turns.sentence)


@pytest.mark.long
def test_planted_drag_is_named_and_the_extended_campaign_runs_in_units_that_turn(tmp_path, capsys):
    drag = 1e-3
    path = written(tmp_path, PENDULUM, pendulum(drag=drag), HEAD.replace("diagnosis: {off: true}\n", ""))
    assert main(["diagnose", str(path), "--output", str(tmp_path)]) == 0
    (found,) = from_json(tmp_path / "rig" / "results.json").diagnosis
    assert found.named == ("quadratic drag",)
    assert_tells_of_angles(found)
    further = tmp_path / "rig" / "extended.yaml"
    carried = yaml.safe_load(further.read_text())["tests"]["pull"]["model"]
    assert carried["drag.quadratic"].endswith(" N·m·s²/rad²")
    assert main(["check", str(further)]) == 0
    further.write_text(further.read_text().replace("tests:\n", "diagnosis: {off: true}\ntests:\n", 1))
    assert main(["run", str(further), "--output", str(tmp_path)]) == 0
    results = {one.quantity: one for one in from_json(tmp_path / "rig-extended" / "results.json").results}
    assert abs(results["c"].value - 0.0025) < 4 * results["c"].u
    assert results["c"].unit == "N·m·s/rad"


def test_law_an_extension_states_every_effect_in_a_unit_that_its_rig_reads(tmp_path):
    models = {
        one.name: (min(max(2 * one.scale, one.low), one.high), 0.1 * one.scale)
        for effect in EFFECTS
        for one in effect.parameters
        if effect.name not in STRAIGHT
    }
    given = load(written(tmp_path, PENDULUM, pendulum()[:2]))
    (tmp_path / "extended.yaml").write_bytes(extended(given, {"pull": models}, tmp_path))
    read = load(tmp_path / "extended.yaml").tests["pull"].model
    assert read.keys() == models.keys()
    for name, (value, u) in models.items():
        assert (read[name].si, read[name].u) == (pytest.approx(value), pytest.approx(u)), name
