"""Findings as a digital calibration certificate (DCC) in the structure of PTB's version 3, with quantities in D-SI."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, indent, register_namespace, tostring

from metrology.errors import Fault, MetrologyError
from metrology.export.markup import DCC, SI, consensus, contact, element, identifications, quantity, software, words
from metrology.judged import is_on
from metrology.language.attention import attention
from metrology.language.catalogue import english
from metrology.report.limits import limits
from metrology.summary import missing

if TYPE_CHECKING:
    from metrology.findings import Findings, InstrumentState, Result, TestItem

VERSION = "3.3.0"
ONLY = "The results relate only to the items tested."
_CONFORMITY = {
    "pass": "pass",
    "conditional pass": "conditionalPass",
    "conditional fail": "conditionalFail",
    "fail": "fail",
}


def certificate(findings: Findings, *, version: str = VERSION) -> bytes:
    """Return the certificate as XML in UTF-8; the same findings give the same bytes.

    Parameters
    ----------
    findings : Findings
    version : str
        Version of the structure, 3.2.0 or later: the elements written are those that all of them have.

    Raises
    ------
    MetrologyError
        Naming everything that the structure requires and the campaign does not say.
    """
    if faults := tuple(_lacking(findings)):
        raise MetrologyError(*faults)
    register_namespace("dcc", DCC)
    register_namespace("si", SI)
    root = Element(f"{{{DCC}}}digitalCalibrationCertificate", {"schemaVersion": version})
    _administration(element(root, "administrativeData"), findings)
    results = element(root, "measurementResults")
    for test in findings.tests:
        _test(results, findings, test)
    tests = {test.id for test in findings.tests}
    own = [result for result in findings.results if result.test not in tests]
    if own:
        _derived(results, findings, own)
    _agreed(results, findings)
    indent(root, " ")
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _lacking(findings: Findings) -> Iterator[Fault]:
    campaign = findings.campaign
    needed = (
        ("report.number", campaign.report_number, "the unique number of the report"),
        ("report.issued", campaign.issued, "the date of issue"),
        ("report.authorised_by", campaign.authorised_by, "the responsible person"),
        ("laboratory.name", campaign.laboratory.name, "the laboratory"),
        ("laboratory.country", campaign.laboratory.country, "its country, two letters such as 'IT'"),
        ("customer.name", campaign.customer.name, "the customer"),
        ("results", findings.results, "at least one result"),
    )
    for key, value, expected in needed:
        if not value:
            yield Fault(
                f"{campaign.id} {key}", "nothing", f"{expected}, which a digital calibration certificate requires"
            )


def _administration(parent: Element, findings: Findings) -> None:
    campaign = findings.campaign
    software(parent, "dccSoftware", [("metrology", findings.software.get("metrology", "unknown"))])
    _core(element(parent, "coreData"), findings)
    _items(element(parent, "items"), findings)
    contact(element(parent, "calibrationLaboratory"), "contact", campaign.laboratory)
    people = element(parent, "respPersons")
    main = _main_signer(findings)
    for name, role in _responsible(findings):
        person = element(people, "respPerson")
        words(element(person, "person"), "name", name)
        element(person, "role", role or "authorises the report")
        element(person, "mainSigner", "true" if name == main else "false")
    contact(parent, "customer", campaign.customer)
    _statements(element(parent, "statements"), findings)


def _responsible(findings: Findings) -> list[tuple[str, str]]:
    """Who authorises, then the others who sign."""
    name, _, function = findings.campaign.authorised_by.partition(", ")
    return [(name, function), *((p.name, p.role) for p in findings.campaign.signatures if p.name != name)]


def _main_signer(findings: Findings) -> str:
    """Who releases the certificate: the approver, who signs last; without one, who authorises."""
    approvers = [p.name for p in findings.campaign.signatures if p.role == "approver"]
    return approvers[0] if approvers else findings.campaign.authorised_by.partition(", ")[0]


def _core(parent: Element, findings: Findings) -> None:
    campaign = findings.campaign
    days = sorted(test.date for test in findings.tests if test.date) or [campaign.issued]
    received = sorted(sample.received for sample in findings.samples if sample.received)
    element(parent, "countryCodeISO3166_1", campaign.laboratory.country)
    element(parent, "usedLangCodeISO639_1", "en")
    element(parent, "mandatoryLangCodeISO639_1", "en")
    element(parent, "uniqueIdentifier", campaign.report_number)
    if received:
        element(parent, "receiptDate", received[-1])
    element(parent, "beginPerformanceDate", days[0])
    element(parent, "endPerformanceDate", days[-1])
    element(parent, "performanceLocation", "laboratory" if campaign.place.casefold() == "laboratory" else "other")
    element(parent, "issueDate", campaign.issued)


def _items(parent: Element, findings: Findings) -> None:
    samples = [(s.name, s.id, f"{s.material}; {s.condition}".strip("; ")) for s in findings.samples]
    for name, identity, about in samples or [(findings.campaign.title, findings.campaign.id, "no item was tested")]:
        item = element(parent, "item")
        words(item, "name", name)
        if about:
            words(item, "description", about)
        words(element(item, "manufacturer"), "name", "not stated")
        identifications(item, "calibrationLaboratory", identity)


def _statements(parent: Element, findings: Findings) -> None:
    campaign = findings.campaign
    texts = [ONLY, campaign.reconstructed, *(f"DRAFT: {text}." for text in missing(findings))]
    if not any(test.date for test in findings.tests):
        texts.append("No date of a test is stated: that of issue stands for begin and end.")
    if campaign.replaces:
        older = campaign.replaces
        texts.append(f"Amended report: it replaces {older.number} of {older.date}: {older.reason}")
    texts += [f"{kind}: {sentence}" for kind, sentence in attention(findings, english(findings))]
    texts += [f"Opinion of {opinion.by}: {opinion.text} (basis: {opinion.basis})" for opinion in campaign.opinions]
    for text in filter(None, texts):
        words(element(parent, "statement"), "declaration", text)


def _test(parent: Element, findings: Findings, test: TestItem) -> None:
    results = [result for result in findings.results if result.test == test.id]
    if not results:
        return
    made = element(parent, "measurementResult")
    words(made, "name", f"{test.title} ({test.id})")
    method = element(element(made, "usedMethods"), "usedMethod")
    words(method, "name", test.title)
    element(method, "norm", test.standard)
    software(made, "usedSoftware", sorted(findings.software.items()))
    used = [item for item in findings.instruments if item.id in test.instruments]
    if used:
        _equipment(element(made, "measuringEquipments"), used)
    if test.environment:
        _conditions(element(made, "influenceConditions"), test)
    _results(made, results, test.title)
    _verdicts(made, findings, results)


def _derived(parent: Element, findings: Findings, results: list[Result]) -> None:
    made = element(parent, "measurementResult")
    words(made, "name", "Derived quantities")
    software(made, "usedSoftware", sorted(findings.software.items()))
    _results(made, results, "Derived quantities")
    _verdicts(made, findings, results)


def _agreed(parent: Element, findings: Findings) -> None:
    """Consensus values, where the results of several tests are consistent."""
    if not (found := [entry for entry in findings.consensus if entry.consistent]):
        return
    made = element(parent, "measurementResult")
    words(made, "name", "Consensus of several tests")
    software(made, "usedSoftware", sorted(findings.software.items()))
    data = element(_result(made, "Consensus of several tests"), "data")
    for entry in found:
        consensus(data, entry)


def _equipment(parent: Element, used: list[InstrumentState]) -> None:
    for item in used:
        made = element(parent, "measuringEquipment")
        words(made, "name", f"{item.kind} {item.id}")
        state = item.sentence or item.state
        words(made, "description", "; ".join(filter(None, (item.certificate, item.uncertainty, state))))
        if item.model:
            element(made, "model", item.model)
        identifications(made, "manufacturer" if item.serial else "other", item.serial or "no serial number")


def _conditions(parent: Element, test: TestItem) -> None:
    for text in test.environment:
        made = element(parent, "influenceCondition")
        words(made, "name", text.partition(" ")[0])
        words(element(made, "data"), "text", text)


def _results(parent: Element, results: list[Result], title: str) -> None:
    data = element(_result(parent, title), "data")
    for result in results:
        quantity(data, result)


def _result(parent: Element, title: str) -> Element:
    made = element(element(parent, "results"), "result")
    words(made, "name", title)
    return made


def _verdicts(parent: Element, findings: Findings, results: list[Result]) -> None:
    verdicts = [entry for entry in findings.conformity if any(is_on(entry.result, result.name) for result in results)]
    if not verdicts:
        return
    made = element(parent, "measurementMetaData")
    for entry in verdicts:
        statement = element(made, "metaData")
        words(statement, "name", entry.requirement)
        words(statement, "description", f"{entry.text or entry.result}. Limits of {entry.result}: {limits(entry)}.")
        if entry.source:
            element(statement, "norm", entry.source)
        words(statement, "declaration", f"{entry.rule}. {entry.sentence}")
        element(statement, "conformity", _CONFORMITY[entry.verdict])
