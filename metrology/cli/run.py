"""`metrology run`: evaluate campaigns and write their `results.json`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli import campaigns
from metrology.cli.campaigns import Progress, each_campaign

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.findings import Findings


def add(commands: Any) -> None:
    """Declare the command."""
    parser = campaigns.add(commands, "run", run, "evaluate campaigns and write results.json")
    campaigns.add_output(parser)
    campaigns.add_code(parser)


def run(options: argparse.Namespace) -> int:
    """Evaluate every file and write its `results.json`."""
    return each_campaign(options, write)


def write(campaign: Campaign, findings: Findings, folder: Path, _progress: Progress) -> None:
    """Write `results.json`, `results.csv` and, where a diagnosis extends a model, `extended.yaml`."""
    from metrology.chain.diagnosis import extended
    from metrology.report import write_results

    write_results(findings, folder, further=extended(campaign, findings, folder))
