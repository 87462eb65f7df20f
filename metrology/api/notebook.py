"""What a notebook shows of the results of a campaign."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from metrology.api.quantity import causes, ends, shown, table

if TYPE_CHECKING:
    from metrology.api.results import Results


def html(results: Results) -> str:
    """Results, verdicts, diagnosis and notices as tables of HTML."""
    rows = [(one.name, *shown(one.result), ends(one.result)) for one in results.values()]
    campaign = results.findings.campaign
    text = table(campaign.title, ("result", "value", "u", "unit", f"{campaign.probability:.0%} interval"), rows)
    if results.verdicts:
        judged = [(one.requirement, one.verdict, one.sentence) for one in results.verdicts]
        text += table("Verdicts", ("requirement", "verdict", ""), judged)
    if results.diagnosis:
        found = [(one.test, one.verdict, one.sentence) for one in results.diagnosis]
        text += table("Diagnosis", ("test", "verdict", ""), found)
    if rows := [row for one in results.diagnosis for row in causes(one)]:
        text += table("Causes", ("test", "cause", "verdict", "probability", "size"), rows)
    return text + "".join(f"<p>{escape(sentence)}</p>" for sentence in results.notices)
