"""`metrology report`: evaluate campaigns and write their reports."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli import campaigns, opening
from metrology.cli.campaigns import Evaluated, Progress, each_campaign

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.identification import Part

PARTS: tuple[Part, ...] = ("certificate", "annex", "quality")


def add(commands: Any) -> None:
    """Declare the command."""
    parser = campaigns.add(commands, "report", report, "evaluate campaigns and write their reports")
    campaigns.add_output(parser)
    campaigns.add_code(parser)
    campaigns.add_coverage(parser)
    opening.add(parser)
    parser.add_argument(
        "--templates",
        type=Path,
        help="folder with templates of the laboratory's own; they run in a sandbox unless --allow-code",
    )
    parser.add_argument(
        "--part",
        choices=PARTS,
        action="append",
        help="part of the report to print, in place of what the campaign says; may be given several times, and the "
        "certificate is always among them",
    )


def report(options: argparse.Namespace) -> int:
    """Evaluate every file and write its report: PDF, HTML, JSON, CSV."""

    def write(evaluated: Evaluated, folder: Path, progress: Progress) -> None:
        from metrology.campaign.sources import read_sources
        from metrology.chain.diagnosis import extended
        from metrology.report import make, place
        from metrology.report.pango import UnprintedError

        campaign, findings = evaluated.campaign, _released(evaluated.findings, options.part)
        sources = read_sources(campaign)
        further = extended(campaign, findings, folder)
        try:
            files = make(
                findings,
                sources=sources,
                templates=options.templates,
                allow_code=options.allow_code,
                progress=progress,
                traces=evaluated.traces,
            )
        except UnprintedError as error:
            place({**error.files, **further}, folder, campaign=evaluated.campaign.path)
            raise
        progress("writing")
        place({**files, **further}, folder, campaign=evaluated.campaign.path)
        if options.open:
            opening.show(folder / "report.html")

    return each_campaign(options, write)


def _released(findings: Findings, parts: list[Part] | None) -> Findings:
    """Findings with the parts of the report that are wanted; as the campaign says without any."""
    if not parts:
        return findings
    wanted = tuple(part for part in PARTS if part == "certificate" or part in parts)
    return replace(findings, campaign=replace(findings.campaign, parts=wanted))
