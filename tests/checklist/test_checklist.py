"""The checklists: their items are those of the standards, and every key that they ask for is in the schema."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from metrology import chain, checklist
from metrology.campaign.load import load
from metrology.chain import items
from metrology.checklist import CHECKLISTS
from metrology.cli import main

ROOT = Path(__file__).parents[2]
SHIPPED = sorted((ROOT / "campaigns").glob("*/campaign.yaml"))
CLAUSES = {
    "17025": [f"7.8.2.1 {letter}" for letter in "abcdefghijklmnop"]
    + ["7.8.2.2", *(f"7.8.3.1 {letter}" for letter in "abcde"), "7.8.4", "7.8.6.1", "7.8.6.2", "7.8.7", "7.8.8"],
    "ecss": ["C.1.2", *(f"C.2.1 <{n}>" for n in range(1, 7))],
}
COMPLETE = """\
format: metrology-campaign/1
id: whole
title: A whole campaign
report: {number: TR-1, issued: 2026-11-20, authorised_by: J. Doe, checklists: [17025, ecss]}
laboratory: {name: Lab, address: Street 1}
customer: {name: Customer, contact: A. Customer}
purpose: to see
place: laboratory
sampling: none
provided: none
deviations: none
opinions: none
anomalies: none
assumptions: none
documents: none
samples: {wire: {material: steel, condition: as received, configuration: bare, received: 2026-10-01}}
quantities: {p: 1.00(1)}
derived:
  - {quantity: q, expression: 2*p}
requirements:
  - id: R1
    source: S 1, 3.1
    close_out: closed
    quantity: q
    limits: {lower: 1}
    decision: {rule: simple acceptance, agreed: 2026-09-01}
"""


@pytest.fixture
def whole(tmp_path):
    path = tmp_path / "campaign.yaml"
    path.write_text(COMPLETE)
    return path


@pytest.mark.parametrize("standard", CHECKLISTS)
def test_reference_every_clause_of_the_standard_has_an_item(standard):
    clauses = [item.clause for item in CHECKLISTS[standard]]
    for clause in CLAUSES[standard]:
        assert any(clause in found for found in clauses), clause


@pytest.mark.parametrize("standard", CHECKLISTS)
def test_law_every_key_of_an_item_is_one_of_the_schema(standard):
    schema = json.loads((ROOT / "docs" / "campaign.schema.json").read_text(encoding="utf-8"))
    known = set(schema["properties"])
    for definition in schema["$defs"].values():
        known |= set(definition.get("properties", ()))
    words = {word for item in CHECKLISTS[standard] for word in re.findall(r"[a-z_]+", item.key)}
    assert words <= known


@pytest.mark.parametrize("standard", CHECKLISTS)
def test_law_every_item_is_shown_where_a_template_is(standard):
    places = {part.strip() for item in CHECKLISTS[standard] for part in item.section.split(",")}
    assert {place for place in places if not (ROOT / "templates" / f"{place}.html").exists()} <= {"cover", "page"}


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.parent.name)
def test_law_shipped_campaigns_lack_nothing(path):
    record = items.record(load(path))
    missing = [
        row for word in record.campaign.checklists for row in checklist.rows(record, word) if row.state == "missing"
    ]
    assert missing == []


def test_law_a_whole_campaign_is_complete_before_and_after_its_evaluation(whole):
    campaign = load(whole)
    findings = chain.evaluate(campaign)
    assert checklist.lacking(findings) == ()
    assert checklist.state(findings) == checklist.COMPLETE
    for standard in CHECKLISTS:
        assert checklist.rows(items.record(campaign), standard) == checklist.rows(
            checklist.of_findings(findings), standard
        )


@pytest.mark.parametrize(
    ("key", "clause"),
    [
        ("place", "7.8.2.1 c"),
        ("sampling", "7.8.2.1 k"),
        ("provided", "7.8.2.1 p"),
        ("opinions", "7.8.7"),
        ("report.number", "7.8.2.1 d"),
        ("report.issued", "7.8.2.1 j"),
        ("report.authorised_by", "7.8.2.1 o"),
        ("laboratory.address", "7.8.2.1 b"),
        ("customer.contact", "7.8.2.1 e"),
        ("samples.wire.condition", "7.8.2.1 g"),
        ("samples.wire.received", "7.8.2.1 h"),
        ("purpose", "C.2.1 <1> a"),
        ("assumptions", "C.2.1 <1> b"),
        ("documents", "C.2.1 <2> a"),
        ("anomalies", "C.2.1 <5> a"),
    ],
)
def test_planted_what_is_taken_out_is_missed_at_its_clause(key, clause, whole):
    data = yaml.load(COMPLETE, yaml.BaseLoader)
    *path, last = key.split(".")
    entry = data
    for part in path:
        entry = entry[part]
    del entry[last]
    whole.write_text(yaml.safe_dump(data))
    findings = chain.evaluate(load(whole))
    assert clause in {row.clause for row in checklist.lacking(findings)}
    assert checklist.state(findings) == checklist.DRAFT
    assert any(key in row.reason for row in checklist.lacking(findings))


@pytest.mark.parametrize(
    ("key", "clause"), [("source", "7.8.6.2"), ("agreed", "7.8.6.1"), ("close_out", "C.2.1 <6> a 3")]
)
def test_planted_a_requirement_without_rule_source_or_close_out_is_missed(key, clause, whole):
    findings = chain.evaluate(load(whole))
    (entry,) = findings.conformity
    bare = replace(findings, conformity=(replace(entry, **{key: ""}),))
    assert {row.clause for row in checklist.lacking(bare)} == {clause} | (
        {"C.2.1 <6> a 1 (a)"} if key == "source" else set()
    )


def test_limit_a_campaign_without_results_lacks_them(whole):
    findings = chain.evaluate(load(whole))
    assert "7.8.2.1 m" in {row.clause for row in checklist.lacking(replace(findings, results=()))}


def test_refusal_a_requirement_without_a_decision_rule_is_a_fault_at_its_line(whole, capsys):
    whole.write_text(COMPLETE.replace("    decision: {rule: simple acceptance, agreed: 2026-09-01}\n", ""))
    assert main(["check", str(whole)]) == 2
    assert f"{whole}:21:5 requirements[0]: got no 'decision'" in capsys.readouterr().err


def test_refusal_a_rule_agreed_after_the_test_and_a_report_that_replaces_itself(whole, capsys):
    later = COMPLETE.replace("authorised_by: J. Doe,", "replaces: {number: TR-1, date: 2026-12-01, reason: slip},")
    test = (
        "tests: {pull: {method: elongation, sample: wire, date: 2026-08-01, instruments: {extension: dial}, loads: {}, "
    )
    whole.write_text(later + test + "readings: none.csv}}\n")
    assert main(["check", str(whole)]) == 2
    told = capsys.readouterr().err
    assert "decision.agreed: got '2026-09-01', after the test of 2026-08-01" in told
    assert "report.replaces.number: got 'TR-1', this report's own number" in told
    assert "report.replaces.date: got '2026-12-01', after this report's issue on 2026-11-20" in told


def test_law_check_for_a_standard_tells_by_its_status(whole, capsys):
    assert main(["check", "--for", "17025", "--for", "ecss", str(whole)]) == 0
    assert f"{whole}: 17025: complete" in capsys.readouterr().out
    whole.write_text(COMPLETE.replace("place: laboratory\n", ""))
    assert main(["check", "--for", "17025", str(whole)]) == 1
    assert "  7.8.2.1 c  where the tests were made: not stated: place" in capsys.readouterr().out
    assert main(["check", "--json", "--for", "17025", str(whole)]) == 1
    (entry,) = json.loads(capsys.readouterr().out)
    assert entry["missing"] == 1
    assert [row["clause"] for row in entry["checklists"]["17025"] if row["state"] == "missing"] == ["7.8.2.1 c"]
    whole.write_text("id: x\n")
    assert main(["check", "--for", "17025", str(whole)]) == 2
