"""`ro-crate-metadata.json`: the report's folder as an RO-Crate 1.1, for archives and for other programs.

It says by which action (software, instruments, inputs) which results were made, for whom and by whom, with the hash of
every file that there is one of. The report itself carries this file and so cannot have its hash in it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from hashlib import sha256
from typing import TYPE_CHECKING, Any

from metrology.report.attachments import input_kind, media_type

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.identification import Party

NAME = "ro-crate-metadata.json"
CONTEXT = [
    "https://w3id.org/ro/crate/1.1/context",
    {"sha256": "https://schema.org/sha256", "measurementTechnique": "https://schema.org/measurementTechnique"},
]
_DESCRIPTIONS = {
    "results.json": "Every result with its uncertainty budget, in SI at full precision",
    "results.csv": "The results as a table",
}
Entity = dict[str, Any]


def metadata(findings: Findings, made: Mapping[str, bytes]) -> bytes:
    """Return the metadata of the crate; same findings and files give the same bytes.

    Parameters
    ----------
    findings : Findings
        What the report prints.
    made : mapping
        Data files of the report's folder by name.

    Notes
    -----
    RO-Crate Metadata Specification 1.1: root data entity, data entities, contextual entities, CreateAction.
    """
    files = [_file(name, content) for name, content in made.items()]
    inputs = [_input(i, file.path, file.sha256, file.bytes) for i, file in enumerate(findings.inputs, 1)]
    people = list(_people(findings))
    instruments = [*_software(findings), *_instruments(findings)]
    action = _action(findings, files, inputs, instruments)
    graph = [_descriptor(), _root(findings, files, action), *files, _report(findings), *inputs, action]
    graph += [*instruments, *_samples(findings), *people]
    return (json.dumps({"@context": CONTEXT, "@graph": graph}, indent=1, ensure_ascii=False) + "\n").encode()


def _descriptor() -> Entity:
    return {
        "@id": NAME,
        "@type": "CreativeWork",
        "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
        "about": {"@id": "./"},
    }


def _root(findings: Findings, files: list[Entity], action: Entity) -> Entity:
    campaign = findings.campaign
    return _filled(
        {
            "@id": "./",
            "@type": "Dataset",
            "identifier": campaign.report_number,
            "name": f"Test report {campaign.report_number}: {campaign.title}",
            "description": campaign.reconstructed or campaign.purpose or campaign.title,
            "datePublished": campaign.issued,
            "license": "All rights with the laboratory; not to be reproduced except in full without its approval",
            "hasPart": _links(files),
            "mentions": [_link(action), {"@id": "#report"}],
            "author": {"@id": "#laboratory"},
            "funder": {"@id": "#customer"} if campaign.customer.name else None,
        }
    )


def _file(name: str, content: bytes) -> Entity:
    return {
        "@id": name,
        "@type": "File",
        "name": _DESCRIPTIONS.get(name, name),
        "encodingFormat": media_type(name),
        "contentSize": str(len(content)),
        "sha256": sha256(content).hexdigest(),
    }


def _input(index: int, path: str, digest: str, size: int) -> Entity:
    return {
        "@id": f"#input-{index}",
        "@type": "MediaObject",
        "name": path,
        "description": input_kind(index - 1, path),
        "encodingFormat": media_type(path),
        "contentSize": str(size),
        "sha256": digest,
    }


def _report(findings: Findings) -> Entity:
    return _filled(
        {
            "@id": "#report",
            "@type": "Report",
            "name": findings.campaign.title,
            "reportNumber": findings.campaign.report_number,
            "datePublished": findings.campaign.issued,
            "description": "report.pdf and report.html; the PDF carries this file",
            "isBasedOn": {"@id": "results.json"},
            "sourceOrganization": {"@id": "#laboratory"},
        }
    )


def _action(findings: Findings, files: list[Entity], inputs: list[Entity], instruments: list[Entity]) -> Entity:
    dates = sorted(test.date for test in findings.tests if test.date)
    return _filled(
        {
            "@id": "#evaluation",
            "@type": "CreateAction",
            "name": f"Tests and evaluation of campaign {findings.campaign.id}",
            "description": f"Random numbers from the seed {findings.seed}",
            "startTime": dates[0] if dates else "",
            "endTime": findings.campaign.issued or (dates[-1] if dates else ""),
            "instrument": _links(instruments),
            "object": [*_links(inputs), *({"@id": f"#sample-{i}"} for i, _ in enumerate(findings.samples, 1))],
            "result": [*_links(files), {"@id": "#report"}],
            "agent": {"@id": "#laboratory"},
            "participant": [{"@id": f"#person-{i}"} for i, _ in enumerate(_names(findings), 1)],
            "measurementTechnique": sorted({test.standard for test in findings.tests if test.standard}),
        }
    )


def _software(findings: Findings) -> Iterator[Entity]:
    for name, version in sorted(findings.software.items()):
        yield {"@id": f"#software-{name}", "@type": "SoftwareApplication", "name": name, "softwareVersion": version}


def _instruments(findings: Findings) -> Iterator[Entity]:
    for i, item in enumerate(findings.instruments, 1):
        yield _filled(
            {
                "@id": f"#instrument-{i}",
                "@type": "IndividualProduct",
                "name": f"{item.kind} {item.id}",
                "model": item.model,
                "serialNumber": item.serial,
                "description": "; ".join(
                    filter(None, (item.certificate, item.calibrated, item.uncertainty, item.state))
                ),
            }
        )


def _samples(findings: Findings) -> Iterator[Entity]:
    for i, item in enumerate(findings.samples, 1):
        yield _filled(
            {
                "@id": f"#sample-{i}",
                "@type": "IndividualProduct",
                "identifier": item.id,
                "name": item.name,
                "material": item.material,
                "itemCondition": item.condition,
            }
        )


def _people(findings: Findings) -> Iterator[Entity]:
    yield _organization("#laboratory", findings.campaign.laboratory)
    if findings.campaign.customer.name:
        yield _organization("#customer", findings.campaign.customer)
    for i, (name, role) in enumerate(_names(findings).items(), 1):
        yield {
            "@id": f"#person-{i}",
            "@type": "Person",
            "name": name,
            "jobTitle": role,
            "affiliation": {"@id": "#laboratory"},
        }


def _names(findings: Findings) -> dict[str, str]:
    """Everybody who took part, each once, with what they did."""
    found: dict[str, str] = {}
    name, _, function = findings.campaign.authorised_by.partition(", ")
    if name:
        found[name] = function or "authorises the report"
    for person in findings.campaign.signatures:
        found.setdefault(person.name, person.function or person.role)
    for test in findings.tests:
        if test.operator:
            found.setdefault(test.operator, "operator")
    for opinion in findings.campaign.opinions:
        found.setdefault(opinion.by.partition(", ")[0], "holds an opinion")
    return found


def _organization(anchor: str, party: Party) -> Entity:
    return _filled(
        {
            "@id": anchor,
            "@type": "Organization",
            "name": party.name or "not stated",
            "address": party.address,
            "contactPoint": party.contact,
        }
    )


def _filled(entity: Entity) -> Entity:
    return {key: value for key, value in entity.items() if value not in ("", None, [])}


def _links(entities: list[Entity]) -> list[Entity]:
    return [_link(entity) for entity in entities]


def _link(entity: Entity) -> Entity:
    return {"@id": entity["@id"]}
