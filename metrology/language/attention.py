"""What a reader must know before he uses a number, in full, as the annex has it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from metrology.findings import Findings, InstrumentState
from metrology.language import done
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.notices import (
    ORDER,
    PROVIDED,
    Notice,
    accepted,
    basis,
    diagnosed,
    instrument,
    pair_name,
    poor,
    refuted,
    said_anyway,
)
from metrology.language.wording import by_name


def attention(findings: Findings, language: Language = ENGLISH) -> list[Notice]:
    """Every notice in full, the gravest first; the kinds are in English."""
    return sorted(_full(findings, language), key=lambda notice: ORDER.index(notice[0]))


def _full(findings: Findings, language: Language) -> Iterator[Notice]:
    spoken = language.spoken
    yield from (("Failure", spoken(sentence)) for sentence in findings.failures)
    for entry in findings.withheld:
        why = " ".join(map(spoken, entry.reasons))
        yield "Withheld", language.say("{requirement}: {why}", requirement=entry.requirement, why=why)
    called = done.called(findings, language)
    yield from _full_tests(findings, called, language)
    yield from _full_models(findings, called, language)
    for item in findings.instruments:
        if item.state != "valid":
            yield "Instrument", _state(item, called, language)
    campaign = findings.campaign
    yield from (("Diagnosis", sentence) for sentence in refuted(findings, called, language))
    text = "{number}, open: {text}"
    yield from (
        ("Anomaly", language.say(text, number=a.id, text=a.text)) for a in campaign.anomalies if a.state == "open"
    )
    for pair in (one for one in findings.comparisons if one.agrees is False):
        text = "{pair}: {sentence}"
        yield "Comparison", language.say(text, pair=pair_name(pair, findings, language), sentence=pair.sentence)
    for parted in findings.disagreements:
        text = "{symbol} by several methods: {verdict}. {sentence}"
        known = {"symbol": parted.quantity, "verdict": parted.verdict, "sentence": parted.sentence}
        yield "Comparison", language.say(text, **known)
    for row in (one for one in findings.audit if not one.agrees):
        yield "Audit", language.say("{figure}: {sentence}", figure=row.figure, sentence=row.sentence)
    yield from (("Accepted", sentence) for sentence in accepted(findings, called, language))
    for one in campaign.provided:
        yield PROVIDED[one.role], language.say("{what}, from {by}", what=one.what, by=one.by)
    yield from (("Deviation", text) for text in campaign.deviations)
    notes = [sentence for sentence in findings.warnings if not said_anyway(sentence, findings)]
    yield from (("Note", by_name(spoken(sentence), called)) for sentence in notes)


def _state(item: InstrumentState, called: Mapping[str, str], language: Language) -> str:
    """State of the calibration of an instrument, and the tests that it was used in."""
    name = instrument(item)
    why = language.spoken(item.sentence) if item.sentence else language.say(_STATES[item.state])
    used = tuple(called.get(test, test) for test in item.used_by)
    if not used:
        return language.say("{name}: {why}", name=name, why=why)
    return language.say("{name}: {why} (used in {tests:comma})", name=name, why=why, tests=used)


_STATES = {"overdue": "Overdue.", "not calibrated": "Not calibrated.", "not judged": "Not judged."}
"""State of a calibration → the same as a sentence."""


def _full_tests(findings: Findings, called: Mapping[str, str], language: Language) -> Iterator[Notice]:
    for test in findings.tests:
        name = called[test.id]
        for check in getattr(test.finding, "checks", ()):
            if check.passed is False:
                text = "{name}: {check} not passed. {sentence}"
                yield "Check", language.say(text, name=name, check=check.name, sentence=check.sentence)
        text = "{name}: {text}"
        yield from (("Excluded", language.say(text, name=name, text=one)) for one in test.exclusions)
        yield from (("Deviation", language.say(text, name=name, text=one)) for one in test.deviations)


def _full_models(findings: Findings, called: Mapping[str, str], language: Language) -> Iterator[Notice]:
    for one in findings.verification:
        if one["verdict"] == "not validated":
            test = called.get(one["test"], one["test"])
            text = "{test}, {model}: {sentence}"
            yield "Model", language.say(text, test=test, model=basis(one), sentence=one["sentence"])
    for found in findings.diagnosis:
        yield from (("Diagnosis", sentence) for sentence in diagnosed(found, called, language))
    for fit in findings.fits:
        if poor(fit.p_value):
            yield "Fit", language.say("{name}: {sentence}", name=fit.name, sentence=fit.sentence)
