"""What a reader must know before he uses a number, as one short sentence each for the certificate."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import accumulate
from typing import Any

from metrology.diagnosis import Diagnosis
from metrology.findings import Findings
from metrology.gum.points import REFUTED
from metrology.language import answers, done
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import symbol
from metrology.language.wording import by_name
from metrology.message import said

CELLS = 3 * 46
"""Characters that three lines of the items on page 1 hold."""
MOST = 2
"""Excluded readings of one test, or deviations of one campaign, that the certificate names one by one."""
ORDER = (
    "Failure", "Withheld", "Check", "Accepted", "Model", "Diagnosis", "Fit", "Instrument", "Anomaly", "Excluded",
    "Comparison", "Audit", "Customer", "External", "Deviation", "Note",
)  # fmt: skip
"""Kinds of notice, the gravest first."""
WARNS = ("Withheld", "Check", "Model", "Diagnosis", "Fit", "Comparison", "Audit")
"""Kinds of notice that are warnings too: what speaks against a number, or forbids a verdict on it."""
PROVIDED = {"customer": "Customer", "external provider": "External"}
Notice = tuple[str, str]
"""Kind and sentence."""


def items_tested(findings: Findings, language: Language = ENGLISH) -> str:
    """The items in at most three lines of page 1."""
    return few([f"{sample.name} ({sample.id})" for sample in findings.samples], language)


def few(names: list[str], language: Language = ENGLISH) -> str:
    """Names in at most three lines of page 1: beyond those, how many more stand in the section of the items.

    Examples
    --------
    >>> few(["Tape A (T-A)", "Tape B (T-B)"])
    'Tape A (T-A); Tape B (T-B)'
    >>> few(50 * ["Tape from the second roll of the third batch, cut lengthwise"])[-35:]
    'lengthwise; 48 more in Items tested'
    """
    joint = language.word("; ")
    if len(joint.join(names)) <= CELLS:
        return joint.join(names)
    kept = max(1, sum(end <= CELLS for end in accumulate(len(name) + 2 for name in names)))
    more = language.say("{count} more in Items tested", count=len(names) - kept)
    return joint.join([*names[:kept], *([more] if kept < len(names) else [])])


def brief(findings: Findings, language: Language = ENGLISH) -> list[Notice]:
    """Every notice as one short sentence, those that are alike in one; none is left out and none is cut.

    The kinds are in English, by which they are in order; `kind` has their words.
    """
    called = done.called(findings, language)
    found = [
        *_brief_tests(findings, called, language),
        *_brief_models(findings, called, language),
        *_brief_judgements(findings, called, language),
        *_brief_campaign(findings, called, language),
    ]
    return sorted(dict.fromkeys(found), key=lambda notice: ORDER.index(notice[0]))


Called = Mapping[str, str]
"""Name of every test as its reader knows it."""


def _brief_tests(findings: Findings, called: Called, language: Language) -> Iterator[Notice]:
    checks: dict[str, list[str]] = {}
    for test in findings.tests:
        for check in getattr(test.finding, "checks", ()):
            if check.passed is False:
                checks.setdefault(check.name, []).append(called[test.id])
        yield from _excluded(called[test.id], test.exclusions, language)
        yield from _deviations(called[test.id], test.deviations, language)
    for name, tests in checks.items():
        yield "Check", language.say("Not passed: {name} ({tests}).", name=name, tests=tuple(tests))


def _brief_models(findings: Findings, called: Called, language: Language) -> Iterator[Notice]:
    states: dict[str, list[str]] = {}
    refuted = set()
    for one in findings.verification:
        states.setdefault(one["test"], []).append(_judged(one, language))
        refuted |= {one["test"]} if one["verdict"] == "not validated" else set()
    for name, parts in states.items():
        if name in refuted:
            yield "Model", language.say("{name}: {what}.", name=called.get(name, name), what=tuple(parts))
    for found in findings.diagnosis:
        yield from (("Diagnosis", sentence) for sentence in diagnosed(found, called, language))


def _brief_judgements(findings: Findings, called: Called, language: Language) -> Iterator[Notice]:
    for entry in findings.withheld:
        why = _first(by_name(language.quoted(entry.reasons[0]), called)).removeprefix(f"{entry.requirement}: ")
        yield "Withheld", language.say("No verdict on {requirement}: {why}", requirement=entry.requirement, why=why)
    for name in findings.unjudged:
        if name not in {entry.requirement for entry in findings.withheld}:
            text = "No verdict on {requirement}: there is no result with an interval."
            yield "Withheld", language.say(text, requirement=name)
    for fit in findings.fits:
        if poor(fit.p_value):
            text = "{name}: the data scatter more than stated ({p})."
            yield "Fit", language.say(text, name=fit.name, p=language.figures(p_text(fit.p_value)))
    for pair in findings.comparisons:
        if pair.agrees is False:
            names, size = pair_name(pair, findings, language), abs(pair.en or 0.0)
            yield "Comparison", language.say("{pair}: they differ, |E_n| = {size:normalised}.", pair=names, size=size)
    for parted in findings.disagreements:
        yield (
            "Comparison",
            language.say(
                "{symbol} by several methods: {verdict}. {sentence}",
                symbol=symbol(parted.quantity),
                verdict=parted.verdict,
                sentence=by_name(language.quoted(parted.sentence), called),
            ),
        )
    differing = tuple(row.figure for row in findings.audit if not row.agrees)
    if differing:
        yield (
            "Audit",
            language.count(
                "one figure differs from the published or expected one: {figures}.",
                "{count} of {whole} figures differ from the published or expected one: {figures}.",
                len(differing),
                whole=len(findings.audit),
                figures=differing,
            ),
        )


def _brief_campaign(findings: Findings, called: Called, language: Language) -> Iterator[Notice]:
    campaign = findings.campaign
    yield from (("Diagnosis", sentence) for sentence in refuted(findings, called, language))
    for sentence in findings.failures:
        yield "Failure", _first(by_name(language.quoted(sentence), called))
    states: dict[str, list[str]] = {}
    for item in findings.instruments:
        if item.state != "valid":
            states.setdefault(_first(language.spoken(item.sentence or item.state)), []).append(instrument(item))
    for state, items in states.items():
        yield "Instrument", language.say("{items}: {state}", items=tuple(items), state=state)
    for anomaly in campaign.anomalies:
        if anomaly.state == "open":
            yield "Anomaly", language.say("{number}, open: {text}", number=anomaly.id, text=_first(anomaly.text))
    for role, kind in PROVIDED.items():
        given = [language.say("{what}, from {by}", what=p.what, by=p.by) for p in campaign.provided if p.role == role]
        if given:
            yield kind, f"{language.word('; ').join(given)}."
    yield from _deviations("", campaign.deviations, language)
    yield from (("Accepted", sentence) for sentence in accepted(findings, called, language))
    for sentence in (one for one in findings.warnings if not said_anyway(one, findings)):
        yield "Note", _first(by_name(language.quoted(sentence), called))


def accepted(findings: Findings, called: Called, language: Language = ENGLISH) -> Iterator[str]:
    """What the laboratory accepts, whole: person and reason are its last words."""
    for sentence in dict.fromkeys(sentence for one in findings.results for sentence in one.accepted):
        yield by_name(language.quoted(sentence), called)


def refuted(findings: Findings, called: Called, language: Language = ENGLISH) -> Iterator[str]:
    """Assumptions that a diagnosis refutes."""
    for one in findings.campaign.assumptions:
        if one.refuted:
            text = "The assumption “{text}” is refuted: {why}."
            yield language.say(text, text=one.text.rstrip("."), why=by_name(language.quoted(one.refuted), called))


def poor(p_value: float | None) -> bool:
    """Whether a fit scatters more than its stated uncertainties allow, at the 5 % level of its χ² test."""
    return p_value is not None and p_value < REFUTED


def p_text(p_value: float | None) -> str:
    """``p = 0.021`` or ``p < 10⁻⁶``."""
    from metrology.language.display import p_value as shown

    text = shown(p_value)
    return f"p {text}" if text.startswith("<") else f"p = {text}"


def _excluded(name: str, texts: tuple[str, ...], language: Language) -> Iterator[Notice]:
    """Each exclusion by itself, or where there are many, how many."""
    if len(texts) <= MOST:
        yield from (("Excluded", f"{name}{language.word(': ')}{_first(language.spoken(text))}") for text in texts)
        return
    many = "{name}: {count} readings or records are excluded; reasons in the annex."
    yield "Excluded", language.say(many, name=name, count=len(texts))


def _deviations(name: str, texts: tuple[str, ...], language: Language) -> Iterator[Notice]:
    """Each deviation by itself, or where there are many, how many."""
    head = f"{name}{language.word(': ')}" if name else ""
    if len(texts) <= MOST:
        yield from (("Deviation", f"{head}{_first(text)}") for text in texts)
        return
    yield "Deviation", head + language.say("{count} deviations; in full in the annex.", count=len(texts))


def diagnosed(found: Diagnosis, called: Called, language: Language = ENGLISH) -> Iterator[str]:
    """A model that lacks something; a result off its reference."""
    name = called.get(found.test, found.test)
    if found.verdict != "nothing missing":
        text = "{name}: {verdict}. {sentence}"
        yield language.say(text, name=name, verdict=found.verdict, sentence=answers.short(found, language))
    if found.discrepancy is not None:
        allowed = tuple(one.title for one in found.discrepancy.explanations if one.judgement == "allowed")
        causes = (
            language.say("Possible causes: {causes:lowered comma}.", causes=allowed)
            if allowed
            else language.say("No single listed cause is possible.")
        )
        below = "{name}: {symbol} is {size:percent} below its reference. {causes}"
        above = "{name}: {symbol} is {size:percent} above its reference. {causes}"
        yield language.say(
            below if found.discrepancy.ratio < 1 else above,
            name=name,
            symbol=symbol(found.discrepancy.quantity),
            size=abs(1 - found.discrepancy.ratio),
            causes=causes,
        )


def _judged(one: Mapping[str, Any], language: Language) -> str:
    runs = one["runs"]
    known = {"passed": sum(run["verdict"] != "not validated" for run in runs), "runs": len(runs)}
    refuted, extended = one["verdict"] == "not validated", one.get("basis") == "extended"
    return language.say(_JUDGED[refuted, extended], **known)


_JUDGED = {
    (True, True): "the extended model is not validated ({passed} of {runs} held-out runs)",
    (True, False): "the model as stated is not validated ({passed} of {runs} held-out runs)",
    (False, True): "the extended model is validated ({passed} of {runs} held-out runs)",
    (False, False): "the model as stated is validated ({passed} of {runs} held-out runs)",
}
"""Whether a model is refuted, whether it is the extended one → what page 1 says."""


def basis(one: Mapping[str, Any]) -> str:
    """Which model was held against the runs."""
    return said("extended model") if one.get("basis") == "extended" else said("model as stated")


def instrument(item: Any) -> str:
    """What an instrument is; its name too where that says more."""
    return str(item.kind) if item.id.lower() in item.kind.lower() else f"{item.kind} ({item.id})"


def pair_name(entry: Any, findings: Findings, language: Language = ENGLISH) -> str:
    """Title of a comparison; one that was made of internal names is put in words."""
    if entry.title != f"{entry.a} against {entry.b}":
        return language.spoken(entry.title)
    a, b = (done.result_name(side, findings, language) for side in (entry.a, entry.b))
    return language.say("{a} against {b}", a=a, b=b)


def _first(text: str) -> str:
    """The first sentence of a text."""
    head = re.split(_END, " ".join(text.split()), maxsplit=1)[0]
    return head if head.endswith((".", "!", "?")) else f"{head}."


_END = re.compile(r"(?<=[a-zß-ÿ\d)%»][.!?])\s+(?=[A-ZÀ-ÞΑ-Ω¿«])")
"""Between two sentences, in each language of the catalogue."""


def said_anyway(sentence: str, findings: Findings) -> bool:
    """Whether the page says it anyway: as a notice of another kind, or by the mark of Monte Carlo in its table."""
    if any(sentence == one.sentence for one in findings.notices if one.kind in WARNS):
        return True
    if any(sentence in one.accepted for one in findings.results):
        return True
    starts = [f"Instrument {item.id}: " for item in findings.instruments]
    return sentence.startswith(
        (*starts, "The GUM uncertainty framework is not confirmed for ", "The GUM uncertainty framework is")
    )
