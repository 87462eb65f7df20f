"""`metrology verify`: who signed a report, whether it changed, and whether its inputs give what it prints."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli.campaigns import DONE, FAILED, show_progress
from metrology.cli.sign import report_file
from metrology.errors import printable

if TYPE_CHECKING:
    from metrology.signoff import Verdict

MARKS = {"good": "✓", "failed": "✗", "not checked": "–"}


def add(commands: Any) -> None:
    """Declare the command."""
    # REPORT first: --trust takes all that follows it up to the next option.
    usage = "%(prog)s [-h] REPORT [--trust CERT [CERT ...]] [--signatures-only] [--templates TEMPLATES] [--json]"
    parser = commands.add_parser("verify", help="say who signed a report, and whether it is what it was", usage=usage)
    parser.add_argument("report", type=Path, metavar="REPORT", help="report.pdf, or the folder that holds it")
    parser.add_argument(
        "--trust",
        type=Path,
        nargs="+",
        action="extend",
        default=[],
        metavar="CERT",
        help="certificates of authorities that you trust",
    )
    parser.add_argument("--signatures-only", action="store_true", help="do not make the report again from its inputs")
    parser.add_argument("--templates", type=Path, help="folder with templates of the laboratory's own")
    parser.add_argument("--json", action="store_true", help="machine-readable output on stdout, alone")
    parser.set_defaults(command=verify)


def verify(options: argparse.Namespace) -> int:
    """Verify one report."""
    from metrology import signoff
    from metrology.signoff.keys import read_certificates

    trusted = [certificate for path in options.trust for certificate in read_certificates(path)]
    report = report_file(options.report)
    with show_progress(str(report), quiet=options.json) as progress:
        verdict = signoff.verify(
            report,
            trusted,
            rebuild=not options.signatures_only,
            templates=options.templates,
            progress=progress,
        )
    if options.json:
        print(json.dumps({**asdict(verdict), "good": verdict.good}, indent=1, ensure_ascii=False))
    else:
        _tell(verdict)
    return DONE if verdict.good else FAILED


def _tell(verdict: Verdict) -> None:
    encoding = sys.stdout.encoding or "ascii"
    lines = [f"{verdict.report}: report {verdict.number}, {verdict.title}"]
    width = max(len(check.subject) for check in verdict.checks)
    lines += [f" {MARKS[check.state]} {check.subject:<{width}}  {check.sentence}" for check in verdict.checks]
    bad = sum(check.state == "failed" for check in verdict.checks)
    lines.append("good" if verdict.good else f"FAILED: {bad} of {len(verdict.checks)} checks")
    for line in lines:
        print(printable(line).encode(encoding, "replace").decode(encoding))
