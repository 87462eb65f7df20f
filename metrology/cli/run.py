"""`metrology run`: evaluate campaigns and write their `results.json`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from metrology.cli import campaigns
from metrology.cli.campaigns import Evaluated, Progress, each_campaign


def add(commands: Any) -> None:
    """Declare the command."""
    parser = campaigns.add(commands, "run", run, "evaluate campaigns and write results.json")
    campaigns.add_output(parser)
    campaigns.add_code(parser)
    campaigns.add_coverage(parser)


def run(options: argparse.Namespace) -> int:
    """Evaluate every file and write its `results.json`."""
    return each_campaign(options, write)


def write(evaluated: Evaluated, folder: Path, _progress: Progress) -> None:
    """Write `results.json`, `results.csv` and, where a diagnosis extends a model, `extended.yaml`."""
    from metrology.chain.diagnosis import extended
    from metrology.report import write_results

    further = extended(evaluated.campaign, evaluated.findings, folder)
    write_results(evaluated.findings, folder, further=further, campaign=evaluated.campaign.path)
