"""`metrology check`: every fault of campaign files; with ``--for``, what they lack for a standard."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
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
    campaigns.add_output(parser)
    parser.add_argument(
        "--for",
        dest="standards",
        action="append",
        choices=STANDARDS,
        default=[],
        help="list what the report would lack: ISO/IEC 17025 (7.8) or ECSS-E-ST-10-02 (Annex C); may be repeated",
    )
    parser.add_argument(
        "--fix",
        action="store_true",
        help="fix mechanical faults in the files first, and show what was changed; no number changes its value",
    )


def check(options: argparse.Namespace) -> int:
    """Load every file and tell all faults of all of them, then what each lacks for the standards asked for."""
    changes = [_fixed(path) for path in options.files] if options.fix else []
    outcome = [_checked(path, options.standards, options.output) for path in options.files]
    for entry, change in zip(outcome, changes, strict=False):
        entry["changed"] = change
    if options.json:
        print(json.dumps(outcome, indent=1, ensure_ascii=False))
    else:
        for entry in outcome:
            _tell(entry, quiet=options.quiet)
    if any(entry["faults"] for entry in outcome):
        return UNUSABLE
    return FAILED if any(entry.get("missing") for entry in outcome) else DONE


def _fixed(path: Path) -> str:
    from metrology.cli import fixing

    try:
        return fixing.fix(campaign_file(path))
    except MetrologyError as error:
        print(error, file=sys.stderr)
        return ""


def _checked(path: Path, standards: list[str], output: Path) -> dict[str, Any]:
    from metrology.campaign.days import ahead
    from metrology.campaign.load import load

    faults: tuple[Fault, ...] = ()
    campaign = None
    try:
        campaign = load(campaign_file(path))
    except MetrologyError as error:
        faults = error.faults
    entry: dict[str, Any] = {"file": str(path), "faults": [asdict(fault) for fault in faults]}
    entry["notices"] = [*campaign.notices, *ahead(campaign)] if campaign is not None else []
    if standards and campaign is not None:
        entry["checklists"] = {standard: [vars(row) for row in _rows(campaign, standard)] for standard in standards}
        entry["missing"] = sum(row["state"] == "missing" for rows in entry["checklists"].values() for row in rows)
    if campaign is not None:
        _record(campaign, output, entry.get("missing", 0))
    return entry


def _record(campaign: Campaign, output: Path, missing: int) -> None:
    """Add a line to the trail by the campaign's report, where there is one; a folder that is closed stays as it is."""
    from metrology.campaign.sources import read_sources
    from metrology.report import recorded

    try:
        files = read_sources(campaign)
        detail = f"no fault found{f', {missing} items missing' if missing else ''}"
        recorded.add(output / campaign.id, "check", files, detail=detail)
    except MetrologyError as error:
        print(error, file=sys.stderr)


def _rows(campaign: Campaign, standard: str) -> tuple[Row, ...]:
    from metrology import checklist
    from metrology.chain import items

    return checklist.rows(items.record(campaign), standard)


def _tell(entry: dict[str, Any], *, quiet: bool) -> None:
    if entry.get("changed") and not quiet:
        print(entry["changed"])
    for fault in entry["faults"]:
        print(Fault(fault["where"], fault["got"], fault["expected"], fault["fix"]), file=sys.stderr)
    if quiet:
        return
    for notice in entry["notices"]:
        print(printable(f"note: {notice}"))
    count = len(entry["faults"])
    print(f"{entry['file']}: {f'{count} fault(s)' if count else 'no fault found'}")
    for standard, rows in entry.get("checklists", {}).items():
        missing = [row for row in rows if row["state"] == "missing"]
        print(f"{entry['file']}: {standard}: {f'lacks {len(missing)} item(s)' if missing else 'complete'}")
        for row in missing:
            print(printable(f"  {row['clause']}  {row['asks']}: {row['reason']}"))
