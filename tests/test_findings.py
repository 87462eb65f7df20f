"""`results.json` is enough: what is written comes back, also where a number does not exist."""

from __future__ import annotations

import json
from math import inf, isnan

from metrology import chain
from metrology.campaign.load import load
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
