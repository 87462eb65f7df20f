"""`metrology check`: every fault of campaign files; with ``--for``, what they lack for a standard."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli import campaigns
from metrology.cli.campaigns import DONE, FAILED, UNUSABLE, campaign_file
from metrology.errors import Fault, MetrologyError, printable

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.checklist import Row

STANDARDS = ("17025", "ecss")
"""Words for the checklists: ISO/IEC 17025:2017, 7.8, and ECSS-E-ST-10-02, Annex C."""


def add(commands: Any) -> None:
    """Declare the command."""
    parser = campaigns.add(commands, "check", check, "report every fault of campaign files, and what a standard misses")
    parser.add_argument(
        "--for",
        dest="standards",
        action="append",
        choices=STANDARDS,
        default=[],
        help="list what the report would lack: ISO/IEC 17025 (7.8) or ECSS-E-ST-10-02 (Annex C); may be repeated",
    )


def check(options: argparse.Namespace) -> int:
    """Load every file and tell all faults of all of them, then what each lacks for the standards asked for."""
    outcome = [_checked(path, options.standards) for path in options.files]
    if options.json:
        print(json.dumps(outcome, indent=1, ensure_ascii=False))
    else:
        for entry in outcome:
            _tell(entry)
    if any(entry["faults"] for entry in outcome):
        return UNUSABLE
    return FAILED if any(entry.get("missing") for entry in outcome) else DONE


def _checked(path: Path, standards: list[str]) -> dict[str, Any]:
    from metrology.campaign.load import load

    faults: tuple[Fault, ...] = ()
    campaign = None
    try:
        campaign = load(campaign_file(path))
    except MetrologyError as error:
        faults = error.faults
    entry: dict[str, Any] = {"file": str(path), "faults": [vars(fault) for fault in faults]}
    if standards and campaign is not None:
        entry["checklists"] = {standard: [vars(row) for row in _rows(campaign, standard)] for standard in standards}
        entry["missing"] = sum(row["state"] == "missing" for rows in entry["checklists"].values() for row in rows)
    return entry


def _rows(campaign: Campaign, standard: str) -> tuple[Row, ...]:
    from metrology import checklist
    from metrology.chain import items

    return checklist.rows(items.record(campaign), standard)


def _tell(entry: dict[str, Any]) -> None:
    for fault in entry["faults"]:
        print(Fault(**fault), file=sys.stderr)
    count = len(entry["faults"])
    print(f"{entry['file']}: {f'{count} fault(s)' if count else 'no fault found'}")
    for standard, rows in entry.get("checklists", {}).items():
        missing = [row for row in rows if row["state"] == "missing"]
        print(f"{entry['file']}: {standard}: {f'lacks {len(missing)} item(s)' if missing else 'complete'}")
        for row in missing:
            print(printable(f"  {row['clause']}  {row['asks']}: {row['reason']}"))
