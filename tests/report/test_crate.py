"""The RO-Crate: its entities are whole, its hashes right, and hostile text stays text."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import findings_sample

from metrology.findings import Findings
from metrology.report import crate, results


def graph(findings: Findings) -> dict[str, dict[str, object]]:
    written = crate.metadata(findings, results.files(findings))
    return {entity["@id"]: entity for entity in json.loads(written)["@graph"]}


def links(value: object) -> list[str]:
    if isinstance(value, dict):
        return [value["@id"]] if set(value) == {"@id"} else []
    return [link for entry in value for link in links(entry)] if isinstance(value, list) else []


def test_law_every_link_leads_to_an_entity(findings: Findings) -> None:
    entities = graph(findings)
    asked = {
        link for entity in entities.values() for key, value in entity.items() if key != "@id" for link in links(value)
    }
    assert asked - entities.keys() == {"https://w3id.org/ro/crate/1.1"}
    assert all(entity["@type"] for entity in entities.values())


def test_reference_root_and_descriptor_are_those_of_the_specification(findings: Findings) -> None:
    entities = graph(findings)
    descriptor, root = entities["ro-crate-metadata.json"], entities["./"]
    assert descriptor["about"] == {"@id": "./"}
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert root["@type"] == "Dataset"
    assert root.keys() >= {"name", "description", "datePublished", "license", "hasPart"}


def test_twice_hashes_are_those_of_the_files_in_the_folder(report: Path) -> None:
    entities = {entity["@id"]: entity for entity in json.loads((report / crate.NAME).read_bytes())["@graph"]}
    for name in ("results.json", "results.csv"):
        assert entities[name]["sha256"] == hashlib.sha256((report / name).read_bytes()).hexdigest()
        assert entities[name]["contentSize"] == str((report / name).stat().st_size)


def test_law_the_action_names_software_instruments_inputs_results_and_people(findings: Findings) -> None:
    entities = graph(findings)
    action = entities["#evaluation"]
    assert action["@type"] == "CreateAction"
    named = {entities[link]["name"] for key in ("instrument", "object", "participant") for link in links(action[key])}
    assert named >= {"metrology", "dial indicator indicator", "campaign.yaml", "Al-1100 tape", "J. Doe", "A. Operator"}
    assert links(action["result"]) == ["results.json", "results.csv", "#report"]
    assert {entities["#input-1"]["sha256"]} == {findings.inputs[0].sha256}


def test_limit_findings_without_anything_make_a_whole_crate() -> None:
    bare = findings_sample.empty()
    bare = replace(bare, campaign=replace(bare.campaign, authorised_by="", opinions=()))
    assert links(graph(bare)["#evaluation"].get("participant", [])) == []
    assert graph(bare)["./"]["identifier"] == "TR-2026-001"


def test_refusal_hostile_text_is_quoted(findings: Findings) -> None:
    entities = graph(findings_sample.hostile(findings))
    assert findings_sample.HOSTILE in str(entities["./"]["name"])


def test_law_an_effect_of_the_laboratory_is_no_readings_file(findings: Findings) -> None:
    effect = replace(findings.inputs[0], path="magnet.py")
    entities = graph(replace(findings, inputs=(*findings.inputs, effect)))
    described = {entity["name"]: entity for key, entity in entities.items() if key.startswith("#input-")}
    assert described["magnet.py"]["description"] == "An effect of the laboratory's own, as it was run"
    assert described["magnet.py"]["encodingFormat"] == "text/x-python"
    assert described["campaign.yaml"]["description"] == "The campaign file"
