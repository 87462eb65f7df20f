"""The published schema of `results.json`: it is the one in docs, every field says what it is, and results obey it."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import findings_sample
import jsonschema
import pytest

from metrology import chain, published
from metrology.campaign.load import load
from metrology.cli import main
from metrology.findings import to_json

ROOT = Path(__file__).parents[1]
EXAMPLES = ("gum-h2-resistance-reactance", "jcgm106-9-5-ball-bearings", "iso28037-wls-1", "pearson-york-errors-in-both")


@cache
def validator() -> Any:
    schema = json.loads((ROOT / "docs" / "results.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def thinned(value: Any) -> Any:
    """The document with series of numbers cut short: one number is judged as the next."""
    if isinstance(value, dict):
        return {key: thinned(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [thinned(entry) for entry in (value if value and isinstance(value[0], dict) else value[:6])]
    return value


def faults(written: bytes) -> list[str]:
    return [
        f"{error.json_path}: {error.message[:200]}" for error in validator().iter_errors(thinned(json.loads(written)))
    ]


def test_twice_the_schema_is_the_one_in_docs(capsys):
    assert main(["schema", "results"]) == 0
    assert capsys.readouterr().out == (ROOT / "docs" / "results.schema.json").read_text(encoding="utf-8")


def test_law_every_field_says_what_it_is():
    schema = published.schema()
    bare = [
        f"{name}.{field}"
        for name, definition in {**schema["$defs"], "Findings": schema}.items()
        for field, body in definition.get("properties", {}).items()
        if not body.get("description")
    ]
    assert bare == []


@pytest.mark.long
@pytest.mark.parametrize("name", EXAMPLES)
def test_law_results_of_published_examples_obey(name):
    assert faults(to_json(chain.evaluate(load(ROOT / "tests" / "reference" / name / "campaign.yaml")))) == []


def test_law_results_of_a_full_report_obey():
    assert faults(to_json(findings_sample.build(1, records=1))) == []


@pytest.mark.study
@pytest.mark.parametrize("name", ["tapes", "nylon", "spectra", "peek", "al-1100", "summary"])
def test_law_results_of_every_shipped_campaign_obey(name):
    assert faults(to_json(chain.evaluate(load(ROOT / "campaigns" / name / "campaign.yaml")))) == []


def test_limit_a_number_that_does_not_exist_obeys():
    findings = findings_sample.build(1, records=1)
    nowhere = replace(findings.results[0], value=float("nan"), u=float("inf"))
    assert faults(to_json(replace(findings, results=(nowhere,)))) == []


@pytest.mark.parametrize(
    "change",
    [
        {"seed": "x"},
        {"schema": "metrology-results/2"},
        {"unheard": 1},
        {"conformity": [{"verdict": "maybe"}]},
        {"results": [{"value": "many"}]},
    ],
)
def test_refusal_what_is_not_a_result_file(change):
    document = json.loads(to_json(findings_sample.build(1, records=1)))
    assert faults(json.dumps(document | change).encode())
