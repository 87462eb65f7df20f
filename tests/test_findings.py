"""`results.json` is enough: what is written comes back, also where a number does not exist."""

from __future__ import annotations

import json
from dataclasses import replace
from math import inf, isnan, nan

from metrology import chain
from metrology.campaign.load import load
from metrology.diagnosis import Cause, Detectable, Diagnosis, Gain, Missing, Part, Separation, Shift, Test, Value
from metrology.findings import from_json, to_json

CAMPAIGN = """\
format: metrology-campaign/1
id: three
title: Three readings
ensembles: {s: {readings: s.csv, columns: {z: z}}}
quantities: {p: -1.0(1)}
derived:
  - {quantity: q, expression: 2*z}
"""


def evaluated(folder, further=""):
    (folder / "s.csv").write_text("z\n1.0\n1.1\n1.3\n")
    (folder / "campaign.yaml").write_text(CAMPAIGN + further)
    return chain.evaluate(load(folder / "campaign.yaml"))


def test_twice_findings_come_back_as_they_were_written(tmp_path):
    findings = evaluated(tmp_path)
    assert {result.name: result for result in findings.results}["q"].monte_carlo.u == inf
    assert from_json(to_json(findings)) == findings


def test_twice_a_result_without_a_value_comes_back_and_the_file_is_json_for_others(tmp_path):
    written = to_json(evaluated(tmp_path, "  - {quantity: root, expression: sqrt(p)}\n"))
    assert isnan({result.name: result for result in from_json(written).results}["root"].value)

    def refuse(word):
        raise AssertionError(f"{word} is not JSON")

    json.loads(written, parse_constant=refuse)


def diagnosed():
    """A diagnosis with every kind of entry, open intervals, and sizes that do not exist."""
    gain = {"x": Gain(1.4, 1.0, 1.4, 1.3, inf)}
    sizes = (Value("friction.force", 1e-3, 1e-4, "N", 8e-4, None), Value("other.frequency", 7.1, nan, "Hz", None, None))
    words = ("k and c come out too large", "look at the bearings", "Named.")
    cause = Cause("friction", "Friction", "F = -f", "supported", 0.98, sizes, gain, 1e300, None, False, *words)
    return Diagnosis(
        "line", "response", "pulls", "ambiguous", "Two causes.", (Test("score", 8.1, 3.9, 0.0, 0.005, False, "…"),),
        (cause,), gain, (Part("pull-1", "x", "slack", 20, 1.4, 1.0),), (("friction", "drag"),),
        (Separation(("friction", "drag"), "a slow pull", "1 mN"),), {"friction.force": 1e-3},
        (Detectable("setup", "Set-up", "setup.k", None, "N/m", "Would not show at any size."),),
        (Shift("k", "N/m", 30.0, 0.1, 29.0, 0.2, -10.0),),
        Missing("force", "N", "velocity", "m/s", (0.1, 0.2), (1e-3, nan), (1e-4, inf), {"velocity": 0.8}, "…"),
        chi_squared=(1.9, inf), notes=("two outliers left out",), failures=("cubic: did not converge",),
    )  # fmt: skip


def test_twice_a_diagnosis_comes_back_typed_and_without_a_number_that_json_lacks(tmp_path):
    written = to_json(replace(evaluated(tmp_path), diagnosis=(diagnosed(),)))
    read = from_json(written)
    assert to_json(read) == written
    assert repr(read.diagnosis) == repr((diagnosed(),))
    (entry,) = json.loads(written)["diagnosis"]
    assert (entry["causes"][0]["gain"]["x"]["high"], entry["causes"][0]["parameters"][1]["u"]) == ("Infinity", "NaN")
    assert entry["extended_model"] == {"friction.force": 1e-3}
