"""What a reader must know before he uses a number: in full, and short enough for page 1."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from metrology.findings import Findings
from metrology.report import diagnosis, wording

LINE = 104
"""Characters of a sentence that one line of page 1 holds."""
LINES, FEWEST = 24, 4
"""Lines of page 1 that results, verdicts (two lines each) and notices share; of notices, so many at least."""
_PROVIDED = {"customer": "Customer", "external provider": "External"}
_STOPS = ("; ", ". ", ": ", ", ", " (")


@dataclass(frozen=True)
class Noted:
    """Notices of page 1, kind and short sentence; `rest` counts those without a line; `whole` has all in full.

    `whole` is empty where page 1 has them all in full.
    """

    short: tuple[tuple[str, str], ...]
    rest: str
    whole: tuple[tuple[str, str], ...]


def noted(findings: Findings) -> Noted:
    """What page 1 tells, in as many lines as its results and verdicts leave it."""
    found = attention(findings)
    headlines = sum(result.headline for result in findings.results)
    room = max(FEWEST, LINES - headlines - 2 * len(findings.conformity))
    if sum(-(-len(sentence) // LINE) for _, sentence in found) <= room:
        return Noted(tuple(found), "", ())
    room -= len(found) > room
    short = tuple((kind, shortened(sentence)) for kind, sentence in found[:room])
    return Noted(short, _counted(found[room:]), tuple(found))


def attention(findings: Findings) -> list[tuple[str, str]]:
    """Every notice in full, the gravest first: kind and sentence."""
    seen = [("Failure", sentence) for sentence in findings.failures]
    seen += [("Verdict", f"{c.requirement}: {doubt}") for c in findings.conformity if (doubt := wording.caution(c))]
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
        ("Model", f"{v['test']}: {v['sentence']}") for v in findings.verification if v["verdict"] == "not validated"
    ]
    seen += [(_PROVIDED[p.role], f"{p.what}, from {p.by}") for p in findings.campaign.provided]
    seen += [("Verdict", f"{c.requirement}: {apart}") for c in findings.conformity if (apart := wording.apart(c))]
    seen += diagnosis.notices(findings)
    seen += [("Deviation", text) for text in findings.campaign.deviations]
    seen += [("Deviation", f"{test.id}: {text}") for test in findings.tests for text in test.deviations]
    return seen + [("Note", sentence) for sentence in findings.warnings if not _told(sentence, findings)]


def shortened(sentence: str) -> str:
    """A sentence on one line of page 1: cut where a clause ends, or else a word.

    Examples
    --------
    >>> shortened("Overdue by 35 days.")
    'Overdue by 35 days.'
    >>> shortened("E of the tape: recomputed 59.36 GPa, published 59.16 GPa; " + 50 * "long ")
    'E of the tape: recomputed 59.36 GPa, published 59.16 GPa …'
    """
    if len(sentence) <= LINE:
        return sentence
    head = sentence[:LINE]
    end = max(head.rfind(stop) for stop in _STOPS)
    cut = head[: end if end > LINE // 2 else head.rfind(" ")] or head
    return f"{cut.rstrip(' ;.:,(')} …"


def _counted(rest: list[tuple[str, str]]) -> str:
    """``3 further: 2 deviation, 1 note``; empty for none."""
    kinds = Counter(kind.lower() for kind, _ in rest)
    return f"{len(rest)} further: {', '.join(f'{n} {kind}' for kind, n in kinds.items())}" if rest else ""


def _told(sentence: str, findings: Findings) -> bool:
    """Whether the page says it anyway: an instrument's state stands above, and MC marks where the law does not hold."""
    starts = [f"Instrument {item.id}: " for item in findings.instruments]
    return sentence.startswith((*starts, "The law of propagation is not confirmed for "))
