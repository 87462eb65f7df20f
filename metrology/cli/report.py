"""`metrology report`: evaluate campaigns and write their reports."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from metrology.cli import campaigns
from metrology.cli.campaigns import Evaluated, Progress, each_campaign


def add(commands: Any) -> None:
    """Declare the command."""
    parser = campaigns.add(commands, "report", report, "evaluate campaigns and write their reports")
    campaigns.add_output(parser)
    campaigns.add_code(parser)
    parser.add_argument(
        "--templates",
        type=Path,
        help="folder with templates of the laboratory's own; they run in a sandbox unless --allow-code",
    )


def report(options: argparse.Namespace) -> int:
    """Evaluate every file and write its report: PDF, HTML, JSON, CSV."""

    def write(evaluated: Evaluated, folder: Path, progress: Progress) -> None:
        from metrology.campaign.sources import read_sources
        from metrology.chain.diagnosis import extended
        from metrology.report import make, place

        campaign, findings = evaluated.campaign, evaluated.findings
        sources = read_sources(campaign)
        further = extended(campaign, findings, folder)
        files = make(
            findings,
            sources=sources,
            templates=options.templates,
            allow_code=options.allow_code,
            progress=progress,
            traces=evaluated.traces,
        )
        progress("writing")
        place({**files, **further}, folder)

    return each_campaign(options, write)
