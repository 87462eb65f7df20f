"""Diagnosis through the front door: campaign folders made by generators of their own, read, evaluated and told."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import test_decay as decays
from response_cases import HELD_OUT, MATERIALS, SCATTER, SHORT, truth_of
from truth_response import Instruments
from truth_response import campaign as measured

from metrology.campaign.load import load
from metrology.cli import main
from metrology.findings import from_json

HEAD = """\
format: metrology-campaign/1
id: {name}
title: Planted
seed: 3
instruments: {{reader: {{kind: reader, resolution: 0.001 mm}}}}
samples: {{line: {{length: 1.500(1) m}}}}
tests:
"""
RESPONSE = """\
  pull:
    method: response
    sample: line
    instruments: {{position: reader, velocity: reader, tension: reader}}
    rig: {{mass: 25 kg, taut: 0.1 m}}
    known:
      mass: {{common: 0.2 %}}
      thrust_gain: {{common: 0.5 %, per_run: 0.3 %}}
      free_length: {{common: 1 mm, per_run: 0.2 mm}}
      start_position: {{per_run: 0.2 mm}}
    identification: {{free: [k, c], start: {{k: {k:g} N/m, c: {c:g} N*s/m}}}}
    runs:
"""
RUN = """\
      {name}:
        purpose: {purpose}
        readings: [{name}-motion.csv, {name}-cell.csv]
        thrust: [{thrust}]
        start: {{position: 0 m}}
"""


def response_campaign(folder, seed, *, tests=(*SHORT, *HELD_OUT), further="", **planted):
    """A campaign of response tests on a nylon line in `folder`, with an effect planted."""
    rng = np.random.default_rng(seed)
    records = measured(truth_of("nylon", **planted), tests, Instruments(), SCATTER, rng)
    k, c = MATERIALS["nylon"]
    text = HEAD.format(name="pulls") + RESPONSE.format(k=1.1 * k, c=0.8 * c)
    for record in records:
        ends = [*(t for t, _ in record.test.thrust[1:]), None]
        thrust = ", ".join(
            f"{{from: {t:g} s, {'' if end is None else f'to: {end:g} s, '}force: {force:g} N}}"
            for (t, force), end in zip(record.test.thrust, ends, strict=True)
            if force
        )
        purpose = "verification" if record.test in HELD_OUT else "identification"
        text += RUN.format(name=record.test.name, purpose=purpose, thrust=thrust)
        motion = [record.t["x"], record.readings["x"], record.readings["v"]]
        write(folder / f"{record.test.name}-motion.csv", "time / s,x / m,v / m/s", motion)
        write(folder / f"{record.test.name}-cell.csv", "time / s,T / N", [record.t["T"], record.readings["T"]])
    (folder / "campaign.yaml").write_text(text + further)
    return folder / "campaign.yaml"


def write(path, heading, columns):
    np.savetxt(path, np.column_stack(columns), fmt="%.6g", delimiter=",", header=heading, comments="")


def diagnosed(out, name="pulls"):
    (found,) = from_json(out / name / "results.json").diagnosis
    return found


@pytest.mark.long
def test_planted_friction_is_named_and_the_extended_campaign_lacks_nothing(tmp_path, capsys):
    assumed = "assumptions: [{text: the table is smooth, excludes: [friction]}, the line is dry]\n"
    path = response_campaign(tmp_path, 5, friction=1e-3, further=assumed)
    out = tmp_path / "out"
    assert main(["diagnose", str(path), "--output", str(out)]) == 0
    told = capsys.readouterr().out
    assert "pull (line, response): explained" in told
    assert "friction.force = 0.00" in told
    found = diagnosed(out)
    assert found.named == ("friction",)
    (force,) = (value for value in found.causes[0].parameters if value.name == "friction.force")
    assert abs(force.value - 1e-3) < 3.5 * force.u
    # What it assumed is struck by what it found.
    smooth, dry = from_json(out / "pulls" / "results.json").campaign.assumptions
    assert smooth.refuted.startswith("Coulomb friction with stiction")
    assert smooth.refuted.endswith("in pull")
    assert dry.refuted == ""

    extended = out / "pulls" / "extended.yaml"
    model = load(extended).tests["pull"].model["friction.force"]
    assert (model.si, model.u) == (pytest.approx(force.value, rel=1e-6), pytest.approx(force.u, rel=1e-2))
    assert main(["diagnose", str(extended), "--output", str(out)]) == 0
    assert "pull (line, response): nothing missing" in capsys.readouterr().out
    before, after = (
        {one.quantity: one for one in from_json(out / name / "results.json").results}["c"]
        for name in ("pulls", "pulls-extended")
    )
    # Friction passes for damping in the model as stated; the result is the planted one, as by the extended campaign.
    for one in (before, after):
        assert abs(one.value - MATERIALS["nylon"][1]) < 3.5 * one.u
    assert abs(before.value - after.value) < after.u
    assert abs(before.stated.value - MATERIALS["nylon"][1]) > 5 * before.stated.u
    assert after.stated is None


@pytest.mark.long
def test_planted_nothing_finds_nothing_and_takes_an_older_extension_away(tmp_path, capsys):
    path = response_campaign(tmp_path, 1)
    stale = tmp_path / "out" / "pulls" / "extended.yaml"
    stale.parent.mkdir(parents=True)
    stale.write_text("of an older run\n")
    assert main(["diagnose", "--json", str(path), "--output", str(tmp_path / "out")]) == 0
    (document,) = json.loads(capsys.readouterr().out)
    (entry,) = document["diagnosis"]
    assert (entry["sample"], entry["method"], entry["test"]) == ("line", "response", "pull")
    assert entry["verdict"] == "nothing missing"
    assert entry["extended_model"] == {}
    assert not stale.exists()


@pytest.mark.long
def test_refusal_of_a_diagnosis_is_a_sentence_beside_whole_results(tmp_path, capsys):
    path = response_campaign(tmp_path, 1, tests=SHORT, further="diagnosis: {off: true}\n")
    assert main(["diagnose", str(path), "--output", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert "nothing was diagnosed" in told
    assert "No test was diagnosed, as the campaign says." in told
    assert {one.quantity for one in from_json(tmp_path / "pulls" / "results.json").results} >= {"k", "c"}


def test_a_bad_campaign_is_status_2_and_told_on_stderr(tmp_path, capsys):
    path = response_campaign(tmp_path, 1, tests=SHORT[:1], further="diagnosis: {off: maybe}\n")
    assert main(["diagnose", str(path), "--output", str(tmp_path / "out")]) == 2
    assert "diagnosis.off: got 'maybe'; expected true or false" in capsys.readouterr().err


CLEAN = replace(decays.AL, contaminated=False)
DECAY = """\
  swing:
    method: decay
    sample: line
    instruments: {displacement: reader}
    mass: 1.200(1) kg
    readings: [r0.csv, r1.csv, r2.csv]
"""


@pytest.mark.long
@pytest.mark.parametrize(("rig", "named"), [(CLEAN, ()), (replace(CLEAN, dry=2e-2), ("friction",))])
def test_planted_friction_of_a_decay_is_named(rig, named, tmp_path):
    rng = np.random.default_rng(3)
    for at in range(3):
        record = decays.record(rig, rng)
        write(tmp_path / f"r{at}.csv", "time / s,displacement / m", [record.time, record.value])
    (tmp_path / "campaign.yaml").write_text(HEAD.format(name="swings") + DECAY)
    assert main(["run", str(tmp_path), "--output", str(tmp_path / "out")]) == 0
    found = diagnosed(tmp_path / "out", "swings")
    assert (found.method, found.test, found.possible) == ("decay", "swing", named)
    assert not (tmp_path / "out" / "swings" / "extended.yaml").exists()


ELONGATION = """\
  stretch:
    method: elongation
    sample: line
    instruments: {extension: reader}
    readings: readings.csv
    loads:
"""


@pytest.mark.long
@pytest.mark.parametrize(("misread", "named"), [(0.0, ()), (0.04, ("misread",))])
def test_planted_misreading_of_an_elongation_is_named(misread, named, tmp_path):
    rng = np.random.default_rng(2)
    loads = {f"L{at}": 5.0 * at for at in range(1, 8)}
    text = HEAD.format(name="stretches") + ELONGATION
    text += "".join(f"      {name}: {{force: {force} N}}\n" for name, force in loads.items())
    (tmp_path / "campaign.yaml").write_text(text)
    rows = ["load,repeat,direction,reading / mm"]
    for repeat in range(3):
        for way, names in (("loading", list(loads)), ("unloading", list(loads)[::-1])):
            for name in names:
                wrong = misread if (repeat, name, way) == (1, "L3", "loading") else 0.0
                reading = loads[name] / 25.0 + 0.1 * repeat + wrong + 0.003 * rng.normal()
                rows.append(f"{name},{repeat},{way},{reading:.3f}")
    (tmp_path / "readings.csv").write_text("\n".join(rows) + "\n")
    assert main(["run", str(tmp_path), "--output", str(tmp_path / "out")]) == 0
    found = diagnosed(tmp_path / "out", "stretches")
    assert (found.method, found.test, found.possible) == ("elongation", "stretch", named)


@pytest.mark.long
def test_law_a_release_left_out_takes_no_part_and_is_told(tmp_path):
    rng = np.random.default_rng(3)
    for at in range(3):
        record = decays.record(CLEAN, rng)
        # The last release is of another sample, of a lower frequency.
        write(tmp_path / f"r{at}.csv", "time / s,displacement / m", [record.time * (1 + 0.3 * (at == 2)), record.value])
    given = {
        "all": DECAY,
        "two": DECAY.replace(", r2.csv]", "]"),
        "left-out": DECAY + "    exclusions: [{file: r2.csv, reason: other sample}]\n",
    }
    omegas = {}
    for name, text in given.items():
        (tmp_path / "campaign.yaml").write_text(HEAD.format(name="swings") + text + "diagnosis: {off: true}\n")
        assert main(["run", str(tmp_path), "--output", str(tmp_path / name)]) in (0, 1)
        findings = from_json(tmp_path / name / "swings" / "results.json")
        omegas[name] = next(one.value for one in findings.results if one.quantity == "omega_n")
    assert findings.tests[0].exclusions == ("r2.csv, the whole release: other sample",)
    assert omegas["left-out"] == omegas["two"] != omegas["all"]
