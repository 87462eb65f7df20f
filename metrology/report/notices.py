"""What a reader must know before he uses a number: in full, and short enough for page 1."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

from metrology.findings import Findings
from metrology.report import diagnosis, quality

LINE, BRIEF = 104, 28
"""Characters of a sentence that one line of page 1 holds; of a requirement's text where its tables are crowded."""
LINES, FEWEST, MOST = 24, 4, 30
"""Lines of page 1 that results, verdicts and notices share; of notices, so many at least, and no more than fit."""
CELL, CELLS = 46, 3 * 46
"""Characters of a line of the items or tests on page 1, and of all their lines."""
GRAVE = ("Failure", "Instrument", "Anomaly", "Excluded")
"""Kinds that page 1 tells one by one, however long its tables are."""
_PROVIDED = {"customer": "Customer", "external provider": "External"}
_STOPS = ("; ", ". ", ": ", ", ", " (")


@dataclass(frozen=True)
class Noted:
    """Notices of page 1, kind and short sentence; `rest` counts those without a line; `whole` has all in full.

    `whole` is empty where page 1 has them all in full; `crowded` where its tables alone are too long for it.
    """

    short: tuple[tuple[str, str], ...]
    rest: str
    whole: tuple[tuple[str, str], ...]
    crowded: bool = False


def names(findings: Findings, methods: Sequence[str]) -> dict[str, Any]:
    """Names that the template of page 1 uses; `methods` are their titles."""
    told = noted(findings)
    return {
        "noted": told,
        "items_tested": few(_items(findings), "Items tested"),
        "tests_made": few(methods, "Methods"),
        "required": (lambda text: shortened(text, BRIEF)) if told.crowded else str,
        "ordered": quality.gravest_first if told.crowded else list,
    }


def noted(findings: Findings) -> Noted:
    """What page 1 tells, in as many lines as its results and verdicts leave it; what is grave in any case."""
    found = attention(findings)
    grave = sum(kind in GRAVE for kind, _ in found)
    left = LINES - _taken(findings)
    room = min(MOST, max(FEWEST, grave + (grave < len(found)), left))
    if sum(_wrapped(sentence, LINE) for _, sentence in found) <= room:
        return Noted(tuple(found), "", (), left < 0)
    room -= len(found) > room
    short = tuple((kind, shortened(sentence)) for kind, sentence in found[:room])
    return Noted(short, _counted(found[room:]), tuple(found), left < 0)


def few(names: Sequence[str], title: str) -> str:
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
    head = "; ".join(names[:kept])
    more = f"{len(names) - kept} more" if kept < len(names) else "in full"
    return f"{head if len(head) <= CELLS else f'{head[:CELLS]} …'}; {more} in {title}"


def attention(findings: Findings) -> list[tuple[str, str]]:
    """Every notice in full, the gravest first: kind and sentence."""
    seen = [("Failure", sentence) for sentence in findings.failures]
    for item in findings.instruments:
        if item.state != "valid":
            used = f" (used in {', '.join(item.used_by)})" if item.used_by else ""
            state = item.sentence or f"{item.state.capitalize()}."
            seen.append(("Instrument", f"{item.kind} {item.id}: {state}{used}"))
    seen += [("Anomaly", f"{a.id}, open: {a.text}") for a in findings.campaign.anomalies if a.state == "open"]
    seen += [("Excluded", f"{test.id}: {text}") for test in findings.tests for text in test.exclusions]
    seen += [("Audit", f"{row.figure}: {row.sentence}") for row in findings.audit if not row.agrees]
    seen += [("Comparison", f"{c.title}: {c.sentence}") for c in findings.comparisons if c.agrees is False]
    seen += [
        (
            "Model",
            f"{v['test']}, {'extended model' if v.get('basis') == 'extended' else 'model as stated'}: {v['sentence']}",
        )
        for v in findings.verification
        if v["verdict"] == "not validated"
    ]
    seen += [
        ("Check", f"{test.id}: {check.name} not passed. {check.sentence}")
        for test in findings.tests
        for check in getattr(test.finding, "checks", ())
        if check.passed is False
    ]
    seen += [(_PROVIDED[p.role], f"{p.what}, from {p.by}") for p in findings.campaign.provided]
    seen += diagnosis.notices(findings)
    seen += [("Deviation", text) for text in findings.campaign.deviations]
    seen += [("Deviation", f"{test.id}: {text}") for test in findings.tests for text in test.deviations]
    return seen + [("Note", sentence) for sentence in findings.warnings if not _told(sentence, findings)]


def shortened(sentence: str, line: int = LINE) -> str:
    """A sentence on one line of page 1: cut where a clause ends, or else a word.

    Examples
    --------
    >>> shortened("Overdue by 35 days.")
    'Overdue by 35 days.'
    >>> shortened("E of the tape: recomputed 59.36 GPa, published 59.16 GPa; " + 50 * "long ")
    'E of the tape: recomputed 59.36 GPa, published 59.16 GPa …'
    """
    if len(sentence) <= line:
        return sentence
    head = sentence[:line]
    end = max(head.rfind(stop) for stop in _STOPS)
    cut = head[: end if end > line // 2 else head.rfind(" ")] or head
    return f"{cut.rstrip(' ;.:,(')} …"


def _taken(findings: Findings) -> int:
    """Lines of page 1 that its results and verdicts take, with those that items and tests take beyond the first."""
    samples = {sample.id: sample.name for sample in findings.samples}
    prior = any(entry.global_consumer_risk is not None for entry in findings.conformity)
    results = [_wrapped(samples.get(r.sample, r.sample), 14) for r in findings.results if r.headline]
    verdicts = [max(2, _wrapped(f"{c.requirement} {c.text}", 23 if prior else 38)) for c in findings.conformity]
    items = len("; ".join(_items(findings)))
    replaced = sum(r.headline and r.stated is not None for r in findings.results)
    return sum(results) + sum(verdicts) + replaced + len(findings.unjudged) + min(2, items // CELL)


def _items(findings: Findings) -> list[str]:
    return [f"{sample.name} ({sample.id})" for sample in findings.samples]


def _wrapped(text: str, width: int) -> int:
    """Lines that a text takes."""
    return max(1, -(-len(text) // width))


def _counted(rest: list[tuple[str, str]]) -> str:
    """``3 further: 2 deviation, 1 note``; empty for none."""
    kinds = Counter(kind.lower() for kind, _ in rest)
    return f"{len(rest)} further: {', '.join(f'{n} {kind}' for kind, n in kinds.items())}" if rest else ""


def _told(sentence: str, findings: Findings) -> bool:
    """Whether the page says it anyway: an instrument's state stands above, and MC marks where the law does not hold."""
    starts = [f"Instrument {item.id}: " for item in findings.instruments]
    return sentence.startswith((*starts, "The law of propagation is not confirmed for "))
