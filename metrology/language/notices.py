"""What a reader must know before he uses a number: in full, and as one short sentence each for the certificate."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import accumulate
from typing import Any

from metrology.diagnosis import Diagnosis
from metrology.findings import Findings
from metrology.gum.points import REFUTED
from metrology.language import answers, done
from metrology.language.display import normalised, percent, symbol
from metrology.language.wording import by_name, lowered

CELLS = 3 * 46
"""Characters that three lines of the items on page 1 hold."""
MOST = 2
"""Excluded readings of one test, or deviations of one campaign, that the certificate names one by one."""
ORDER = (
    "Failure", "Withheld", "Check", "Model", "Diagnosis", "Fit", "Instrument", "Anomaly", "Excluded", "Comparison",
    "Audit", "Customer", "External", "Deviation", "Note",
)  # fmt: skip
"""Kinds of notice, the gravest first."""
_PROVIDED = {"customer": "Customer", "external provider": "External"}
Notice = tuple[str, str]
"""Kind and sentence."""


def names(findings: Findings) -> dict[str, Any]:
    """Names that the templates use."""
    return {
        "notices": brief(findings),
        "attention": attention(findings),
        "found": [sentence for kind, sentence in brief(findings) if kind in ("Failure", "Check", "Fit")],
        "items_tested": few([f"{sample.name} ({sample.id})" for sample in findings.samples], "Items tested"),
    }


def few(names: list[str], title: str) -> str:
    """Names in at most three lines of page 1: beyond those, how many more stand in the section of a title.

    Examples
    --------
    >>> few(["Tape A (T-A)", "Tape B (T-B)"], "Items tested")
    'Tape A (T-A); Tape B (T-B)'
    >>> few(50 * ["Tape from the second roll of the third batch, cut lengthwise"], "Items tested")[-35:]
    'lengthwise; 48 more in Items tested'
    """
    if len("; ".join(names)) <= CELLS:
        return "; ".join(names)
    kept = max(1, sum(end <= CELLS for end in accumulate(len(name) + 2 for name in names)))
    more = f"; {len(names) - kept} more in {title}" if kept < len(names) else ""
    return "; ".join(names[:kept]) + more


# ---- in full ------------------------------------------------------------------------------------------------------
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
            yield "Instrument", f"{_instrument(item)}: {item.sentence or f'{item.state.capitalize()}.'}{used}"
    campaign = findings.campaign
    yield from (("Anomaly", f"{a.id}, open: {a.text}") for a in campaign.anomalies if a.state == "open")
    yield from (
        ("Comparison", f"{pair_name(c, findings)}: {c.sentence}") for c in findings.comparisons if c.agrees is False
    )
    yield from (
        ("Comparison", f"{p.quantity} by several methods: {p.verdict}. {p.sentence}") for p in findings.disagreements
    )
    yield from (("Audit", f"{row.figure}: {row.sentence}") for row in findings.audit if not row.agrees)
    yield from ((_PROVIDED[p.role], f"{p.what}, from {p.by}") for p in campaign.provided)
    yield from (("Deviation", text) for text in campaign.deviations)
    notes = [sentence for sentence in findings.warnings if not _said(sentence, findings)]
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
            yield "Model", f"{called.get(one['test'], one['test'])}, {_basis(one)}: {one['sentence']}"
    for told in findings.diagnosis:
        yield from (("Diagnosis", sentence) for sentence in _diagnosed(told, called))
    yield from (("Fit", f"{fit.name}: {fit.sentence}") for fit in findings.fits if poor(fit.p_value))


# ---- for the certificate ------------------------------------------------------------------------------------------
def brief(findings: Findings) -> list[Notice]:
    """Every notice as one short sentence, those that are alike in one; none is left out and none is cut."""
    found = [*_brief_tests(findings), *_brief_judgements(findings), *_brief_campaign(findings)]
    return sorted(dict.fromkeys(found), key=lambda notice: ORDER.index(notice[0]))


def _brief_tests(findings: Findings) -> Iterator[Notice]:
    called = done.called(findings)
    checks: dict[str, list[str]] = {}
    for test in findings.tests:
        for check in getattr(test.finding, "checks", ()):
            if check.passed is False:
                checks.setdefault(check.name, []).append(called[test.id])
        yield from _excluded(called[test.id], test.exclusions)
        yield from _counted("Deviation", called[test.id], test.deviations)
    yield from (("Check", f"Not passed: {name} ({'; '.join(tests)}).") for name, tests in checks.items())
    states: dict[str, list[str]] = {}
    for one in findings.verification:
        states.setdefault(one["test"], []).append(_judged(one))
    for name, parts in states.items():
        if any("not validated" in part for part in parts):
            yield "Model", f"{called.get(name, name)}: {'; '.join(parts)}."
    for told in findings.diagnosis:
        yield from (("Diagnosis", sentence) for sentence in _diagnosed(told, called))


def _brief_judgements(findings: Findings) -> Iterator[Notice]:
    called = done.called(findings)
    for entry in findings.withheld:
        yield "Withheld", f"No verdict on {entry.requirement}: {_first(by_name(entry.reasons[0], called))}"
    for name in findings.unjudged:
        if name not in {entry.requirement for entry in findings.withheld}:
            yield "Withheld", f"No verdict on {name}: there is no result."
    for fit in findings.fits:
        if poor(fit.p_value):
            yield "Fit", f"{fit.name}: the data scatter more than stated ({p_text(fit.p_value)})."
    for pair in findings.comparisons:
        if pair.agrees is False:
            yield "Comparison", f"{pair_name(pair, findings)}: they differ, |E_n| = {normalised(abs(pair.en or 0.0))}."
    for parted in findings.disagreements:
        yield "Comparison", f"{symbol(parted.quantity)} by several methods: {parted.verdict}. {parted.sentence}"
    differing = [row.figure for row in findings.audit if not row.agrees]
    if differing:
        count = (
            f"{len(differing)} of {len(findings.audit)} figures differ" if len(differing) > 1 else "one figure differs"
        )
        yield "Audit", f"{count} from the published or expected one: {'; '.join(differing)}."


def _brief_campaign(findings: Findings) -> Iterator[Notice]:
    campaign, called = findings.campaign, done.called(findings)
    yield from (("Failure", _first(by_name(sentence, called))) for sentence in findings.failures)
    states: dict[str, list[str]] = {}
    for item in findings.instruments:
        if item.state != "valid":
            states.setdefault(_first(item.sentence or item.state), []).append(_instrument(item))
    yield from (("Instrument", f"{'; '.join(items)}: {lowered(state)}") for state, items in states.items())
    yield from (("Anomaly", f"{a.id}, open: {_first(a.text)}") for a in campaign.anomalies if a.state == "open")
    for role, kind in _PROVIDED.items():
        given = [f"{p.what}, from {p.by}" for p in campaign.provided if p.role == role]
        if given:
            yield kind, f"{'; '.join(given)}."
    yield from _counted("Deviation", "", campaign.deviations)
    notes = [sentence for sentence in findings.warnings if not _said(sentence, findings)]
    yield from (("Note", _first(by_name(sentence, called))) for sentence in notes)


def poor(p_value: float | None) -> bool:
    """Whether a fit scatters more than its stated uncertainties allow, at the 5 % level of its χ² test."""
    return p_value is not None and p_value < REFUTED


def p_text(p_value: float | None) -> str:
    """``p = 0.021`` or ``p < 10⁻⁶``."""
    from metrology.language.display import p_value as shown

    text = shown(p_value)
    return f"p {text}" if text.startswith("<") else f"p = {text}"


def _excluded(name: str, texts: tuple[str, ...]) -> Iterator[Notice]:
    yield from _counted("Excluded", name, texts, "readings or records are excluded; reasons in the annex")


def _counted(
    kind: str, name: str, texts: Iterable[str], many: str = "deviations; in full in the annex"
) -> Iterator[Notice]:
    """Each text by itself, or where there are many, how many."""
    texts = list(texts)
    head = f"{name}: " if name else ""
    if len(texts) > MOST:
        yield kind, f"{head}{len(texts)} {many}."
    else:
        yield from ((kind, f"{head}{_first(text)}") for text in texts)


def _diagnosed(told: Diagnosis, called: Mapping[str, str]) -> Iterator[str]:
    """A model that lacks something; a result off its reference."""
    name = called.get(told.test, told.test)
    if told.verdict != "nothing missing":
        yield f"{name}: {told.verdict}. {answers.short(told)}"
    if told.discrepancy is not None:
        allowed = [lowered(one.title) for one in told.discrepancy.explanations if one.judgement == "allowed"]
        side = "below" if told.discrepancy.ratio < 1 else "above"
        causes = f"Possible causes: {', '.join(allowed)}" if allowed else "No single listed cause is possible"
        off = percent(abs(1 - told.discrepancy.ratio))
        yield f"{name}: {symbol(told.discrepancy.quantity)} is {off} {side} its reference. {causes}."


def _judged(one: Mapping[str, Any]) -> str:
    runs = one["runs"]
    passed = sum(run["verdict"] != "not validated" for run in runs)
    verdict = "not validated" if one["verdict"] == "not validated" else "validated"
    return f"the {_basis(one)} is {verdict} ({passed} of {len(runs)} held-out runs)"


def _basis(one: Mapping[str, Any]) -> str:
    return "extended model" if one.get("basis") == "extended" else "model as stated"


def _instrument(item: Any) -> str:
    """What an instrument is; its name too where that says more."""
    return str(item.kind) if item.id.lower() in item.kind.lower() else f"{item.kind} ({item.id})"


def pair_name(entry: Any, findings: Findings) -> str:
    """Title of a comparison; one that was made of internal names is put in words."""
    if entry.title != f"{entry.a} against {entry.b}":
        return str(entry.title)
    return f"{done.result_name(entry.a, findings)} against {done.result_name(entry.b, findings)}"


def _first(text: str) -> str:
    """The first sentence of a text."""
    head = re.split(r"(?<=[a-z\d)%][.!?])\s+(?=[A-ZΑ-Ω])", " ".join(text.split()), maxsplit=1)[0]
    return head if head.endswith((".", "!", "?")) else f"{head}."


def _said(sentence: str, findings: Findings) -> bool:
    """Whether the page says it anyway: an instrument's state, or the mark of Monte Carlo in the table of results."""
    starts = [f"Instrument {item.id}: " for item in findings.instruments]
    return sentence.startswith(
        (*starts, "The GUM uncertainty framework is not confirmed for ", "The GUM uncertainty framework is")
    )
