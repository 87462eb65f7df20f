"""What a standard asks of a test report, item by item, and whether a campaign gives it.

A checklist is a table of `Item`, one a clause: what it asks, which key of the campaign file gives it, in which section
the report shows it. `lacking` is what keeps a report a draft; `state` says so in words.
"""

from __future__ import annotations

from metrology.checklist.item import Item, Row
from metrology.checklist.record import Record, of_findings
from metrology.checklist.tables import CHECKLISTS, TITLES
from metrology.findings import Findings

__all__ = [
    "CHECKLISTS",
    "COMPLETE",
    "DRAFT",
    "TITLES",
    "Item",
    "Record",
    "Row",
    "lacking",
    "of_findings",
    "rows",
    "state",
]

DRAFT, COMPLETE = "draft", "complete, to be signed"


def rows(record: Record, standard: str) -> tuple[Row, ...]:
    """Return the checklist of a standard, filled in.

    Parameters
    ----------
    record : Record
        Of findings, or of a campaign that was not evaluated.
    standard : str
        A key of `CHECKLISTS`: ``17025`` or ``ecss``.

    Raises
    ------
    KeyError
        For a standard without a checklist.
    """
    return tuple(item.fill(record) for item in CHECKLISTS[standard])


def lacking(findings: Findings) -> tuple[Row, ...]:
    """Return what the report still lacks by the checklists that the campaign names; nothing where it can be signed."""
    record = of_findings(findings)
    filled = [row for standard in findings.campaign.checklists for row in rows(record, standard)]
    return tuple(row for row in filled if row.state == "missing")


def state(findings: Findings) -> str:
    """Return the state of a report that nobody signed: `DRAFT` while anything is lacking, else `COMPLETE`.

    It is issued by its signatures alone, which stand in the signed file and not in the findings.
    """
    return DRAFT if lacking(findings) else COMPLETE
