"""What a quality officer looks for: state and overall verdict on page 1, the filled checklists, what is open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

from metrology import checklist
from metrology.checklist import Row
from metrology.findings import Conformity, Findings
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import chance
from metrology.language.wording import prose
from metrology.units import unit_text

_CARE = ("pass", "conditional pass", "conditional fail", "fail")
NOT_JUDGED = "not judged"
STATES = {"given": "✓", "missing": "✗", "not applicable": "–"}
"""State of an item → its mark."""


@dataclass(frozen=True)
class Checklist:
    """A filled checklist under its title."""

    title: str
    rows: tuple[Row, ...]

    def count(self, language: Language = ENGLISH) -> str:
        """How many items are in which state, in words."""
        states = [row.state for row in self.rows]
        each = {"given": "{count} given", "missing": "{count} missing", "not applicable": "{count} not applicable"}
        counts = [language.say(each[one], count=states.count(one)) for one in STATES if one in states]
        return language.say("{whole} items: {counts:comma}.", whole=len(states), counts=tuple(counts))


def names(findings: Findings, language: Language = ENGLISH) -> dict[str, Any]:
    """Names that the templates use."""
    missing = checklist.lacking(findings)
    return {
        "draft": bool(missing),
        "overall": overall(findings),
        "ordered": gravest_first,
        "checklists": checklists(findings),
        "states": STATES,
        "band": band,
        "with_prior": any(entry.global_consumer_risk is not None for entry in findings.conformity),
        "risks": risks,
        "rule_risk": lambda entry: rule_risk(entry, language),
        "counted_states": lambda one: one.count(language),
        "shown_in": lambda row, parts: shown_in(row, parts, language),
    }


def stated(findings: Findings, language: Language = ENGLISH) -> str:
    """State of a report in words."""
    campaign = findings.campaign
    listed = "quality" in campaign.parts
    return state(checklist.lacking(findings), signed=bool(campaign.signatures), listed=listed, language=language)


def state(missing: Sequence[Row], *, signed: bool, listed: bool = True, language: Language = ENGLISH) -> str:
    """State of the report in words; it is issued by its signatures, which the signed file holds.

    Parameters
    ----------
    missing : sequence of Row
        What its checklists ask for and the campaign does not give.
    signed : bool
        Whether the campaign names who signs.
    listed : bool
        Whether the report says which they are.
    language : Language
        In which it is said.
    """
    if not missing and not signed:
        return language.say("Complete, but not to be issued: the campaign names nobody who signs")
    if not missing:
        return language.say("Complete, to be signed; it is issued once signed")
    if not listed:
        return language.count(
            "Draft: {count} item of the checklist is missing",
            "Draft: {count} items of the checklist are missing",
            len(missing),
        )
    return language.count(
        "Draft: {count} item of the checklist is missing (see the annex)",
        "Draft: {count} items of the checklist are missing (see the annex)",
        len(missing),
    )


def overall(findings: Findings) -> str:
    """The worst verdict of all requirements; `NOT_JUDGED` where one could not be judged, empty where there is none.

    A fail stays one: no requirement that could not be judged can fix it.
    """
    verdicts = [_CARE.index(entry.verdict) for entry in findings.conformity]
    worst = _CARE[max(verdicts)] if verdicts else ""
    return NOT_JUDGED if findings.unjudged and worst != "fail" else worst


def gravest_first(judged: Sequence[tuple[Conformity, str, str]]) -> list[tuple[Conformity, str, str]]:
    """Rows of a table of verdicts, those that fail at its head."""
    return sorted(judged, key=lambda row: -_CARE.index(row[0].verdict))


def checklists(findings: Findings) -> list[Checklist]:
    """The checklists that the campaign names, filled in."""
    record = checklist.of_findings(findings)
    return [Checklist(checklist.TITLES[word], checklist.rows(record, word)) for word in findings.campaign.checklists]


def shown_in(row: Row, sections: Sequence[tuple[str, str]], language: Language = ENGLISH) -> list[tuple[str, str]]:
    """Anchor and number of every section that shows an item; page 1 and every page have no number."""
    numbers: Mapping[str, str] = {name: str(i) for i, (name, _) in enumerate(sections, 1)}
    places = {"cover": ("summary", language.say("page 1")), "page": ("", language.say("every page"))}
    found = [
        places.get(name) or (name, language.say("section {number}", number=numbers[name]) if name in numbers else "")
        for name in _parts(row.section)
    ]
    return [(anchor, words) for anchor, words in found if words]


def _parts(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def band(entry: Conformity) -> str:
    """Guard band w in the display unit, to two digits; a dash where no width keeps the agreed risk.

    Of a skewed distribution it is one at the lower limit and another one at the upper.
    """
    from metrology.language.display import number
    from metrology.units import factor

    if not isfinite(entry.guard_band):
        return "–"
    ends = ((entry.lower, entry.acceptance_lower), (entry.acceptance_upper, entry.upper))
    widths = [high - low for low, high in ends if low is not None and high is not None]
    if len(widths) < len(ends):
        widths = [entry.guard_band]
    texts = dict.fromkeys(number(width / factor(entry.display_unit), 2) for width in widths)
    return f"{' / '.join(texts)} {unit_text(entry.display_unit)}".rstrip()


def risks(entry: Conformity) -> str:
    """Global risks of consumer and producer; a dash where no prior is stated."""
    pair = (entry.global_consumer_risk, entry.global_producer_risk)
    return "–" if pair == (None, None) else " / ".join("–" if risk is None else chance(risk) for risk in pair)


def rule_name(entry: Conformity, language: Language = ENGLISH) -> str:
    """The rule by its name in the campaign file, with the risk where one sets the guard band."""
    band, _, _ = entry.rule.partition(";")
    kind, _, width = band.partition(", ")
    if not width.startswith("w for a "):
        name, width, rest = kind.partition(" (w = ")
        return language.word(name) + width + rest
    risk, _, size = width.removeprefix("w for a ").partition(" of ")
    return language.say(_BY_RISK[risk], size=prose(size))


_BY_RISK = {
    "specific risk": "specific risk of {size:figures}",
    "global risk": "global risk of {size:figures}",
}
"""What bounds the guard band → the rule in words."""


def rule_risk(entry: Conformity, language: Language = ENGLISH) -> str:
    """The risk that comes with the decision rule, in words."""
    if entry.rule_risk is None:
        return language.say("a risk over all items, as the rule says")
    return language.say("at most {risk:percent} that a pass is wrong", risk=entry.rule_risk)
