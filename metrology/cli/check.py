"""`metrology check`: every fault of campaign files."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from metrology.cli import campaigns
from metrology.cli.campaigns import DONE, UNUSABLE, campaign_file
from metrology.errors import Fault, MetrologyError


def add(commands: Any) -> None:
    """Declare the command."""
    campaigns.add(commands, "check", check, "report every fault of campaign files")


def check(options: argparse.Namespace) -> int:
    """Load every file and tell all faults of all of them."""
    from metrology.campaign.load import load

    outcome: list[dict[str, Any]] = []
    for path in options.files:
        faults: tuple[Fault, ...] = ()
        try:
            load(campaign_file(path))
        except MetrologyError as error:
            faults = error.faults
        outcome.append({"file": str(path), "faults": [vars(fault) for fault in faults]})
        if not options.json:
            for fault in faults:
                print(fault, file=sys.stderr)
            print(f"{path}: {'no fault found' if not faults else f'{len(faults)} fault(s)'}")
    if options.json:
        print(json.dumps(outcome, indent=1, ensure_ascii=False))
    return UNUSABLE if any(entry["faults"] for entry in outcome) else DONE
