"""What a reader must know before he uses a number, in full: the annex has it, in English."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from metrology.findings import Findings
from metrology.language import done
from metrology.language.notices import (
    ORDER,
    PROVIDED,
    Notice,
    basis,
    diagnosed,
    instrument,
    pair_name,
    poor,
    said_anyway,
)
from metrology.language.wording import by_name


def attention(findings: Findings) -> list[Notice]:
    """Every notice in full, the gravest first."""
    return sorted(_full(findings), key=lambda notice: ORDER.index(notice[0]))


def _full(findings: Findings) -> Iterator[Notice]:
    yield from (("Failure", sentence) for sentence in findings.failures)
    for entry in findings.withheld:
        yield "Withheld", f"{entry.requirement}: {' '.join(entry.reasons)}"
    called = done.called(findings)
    yield from _full_tests(findings, called)
    yield from _full_models(findings, called)
    for item in findings.instruments:
        if item.state != "valid":
            used = f" (used in {', '.join(called.get(test, test) for test in item.used_by)})" if item.used_by else ""
            yield "Instrument", f"{instrument(item)}: {item.sentence or f'{item.state.capitalize()}.'}{used}"
    campaign = findings.campaign
    yield from (("Anomaly", f"{a.id}, open: {a.text}") for a in campaign.anomalies if a.state == "open")
    yield from (
        ("Comparison", f"{pair_name(c, findings)}: {c.sentence}") for c in findings.comparisons if c.agrees is False
    )
    yield from (
        ("Comparison", f"{p.quantity} by several methods: {p.verdict}. {p.sentence}") for p in findings.disagreements
    )
    yield from (("Audit", f"{row.figure}: {row.sentence}") for row in findings.audit if not row.agrees)
    yield from ((PROVIDED[p.role], f"{p.what}, from {p.by}") for p in campaign.provided)
    yield from (("Deviation", text) for text in campaign.deviations)
    notes = [sentence for sentence in findings.warnings if not said_anyway(sentence, findings)]
    yield from (("Note", by_name(sentence, called)) for sentence in notes)


def _full_tests(findings: Findings, called: Mapping[str, str]) -> Iterator[Notice]:
    for test in findings.tests:
        for check in getattr(test.finding, "checks", ()):
            if check.passed is False:
                yield "Check", f"{called[test.id]}: {check.name} not passed. {check.sentence}"
        yield from (("Excluded", f"{called[test.id]}: {text}") for text in test.exclusions)
        yield from (("Deviation", f"{called[test.id]}: {text}") for text in test.deviations)


def _full_models(findings: Findings, called: Mapping[str, str]) -> Iterator[Notice]:
    for one in findings.verification:
        if one["verdict"] == "not validated":
            yield "Model", f"{called.get(one['test'], one['test'])}, {basis(one)}: {one['sentence']}"
    for found in findings.diagnosis:
        yield from (("Diagnosis", sentence) for sentence in diagnosed(found, called))
    yield from (("Fit", f"{fit.name}: {fit.sentence}") for fit in findings.fits if poor(fit.p_value))
