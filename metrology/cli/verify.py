"""`metrology verify`: who signed a report, whether it changed, and whether its inputs give what it prints."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli.campaigns import DONE, FAILED, add_telling, show_progress
from metrology.cli.sign import ROLES, report_file
from metrology.errors import Fault, MetrologyError, printable

if TYPE_CHECKING:
    from metrology.signoff import Policy, Verdict

MARKS = {"good": "✓", "failed": "✗", "not checked": "–", "note": " "}
INCOMPLETE = 3
"""Exit status where nothing failed, but something could not be checked."""
STATUS = {"good": DONE, "failed": FAILED, "incomplete": INCOMPLETE}


def add(commands: Any) -> None:
    """Declare the command."""
    # REPORT first: --trust takes all that follows it up to the next option.
    usage = (
        "%(prog)s [-h] REPORT [--policy FILE] [--trust CERT [CERT ...]] [--require ROLE,…] [--signatures-only]"
        " [--allow-code] [--templates TEMPLATES] [--json]"
    )
    parser = commands.add_parser(
        "verify",
        help="say who signed a report, and whether it is what it was",
        usage=usage,
        epilog="Exit status: 0 good, 1 failed, 2 bad usage or no report of ours, 3 something could not be checked.",
    )
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
    parser.add_argument("--policy", type=Path, metavar="FILE", help="the laboratory's trust policy, trust.yaml")
    parser.add_argument(
        "--require",
        action="append",
        default=[],
        metavar="ROLE,…",
        help="roles that must have signed, besides those that the campaign and the policy name",
    )
    parser.add_argument(
        "--signatures-only",
        action="store_true",
        help="do not make the report again from its inputs: the outcome is incomplete at best",
    )
    parser.add_argument(
        "--allow-code", action="store_true", help="run the Python files that the report attaches, with your rights"
    )
    parser.add_argument("--templates", type=Path, help="folder with templates of the laboratory's own")
    add_telling(parser)
    parser.set_defaults(command=verify)


def verify(options: argparse.Namespace) -> int:
    """Verify one report."""
    from metrology import signoff

    policy, require = _policy(options), _roles(options.require)
    again = None if options.signatures_only else signoff.Again(options.templates, options.allow_code)
    report = report_file(options.report)
    with show_progress(str(report), options) as progress:
        verdict = signoff.verify(report, policy, require=require, again=again, progress=progress)
    if options.json:
        stated = {**asdict(verdict), "outcome": verdict.outcome, "good": verdict.good}
        print(json.dumps(stated, indent=1, ensure_ascii=False))
    elif not options.quiet or not verdict.good:
        _tell(verdict)
    return STATUS[verdict.outcome]


def _policy(options: argparse.Namespace) -> Policy:
    """The trust policy, with further authorities where --trust names them."""
    from metrology import signoff
    from metrology.signoff.keys import read_certificates

    policy = signoff.load_policy(options.policy) if options.policy else signoff.Policy()
    trusted = (certificate for path in options.trust for certificate in read_certificates(path))
    return replace(policy, authorities=(*policy.authorities, *trusted))


def _roles(given: list[str]) -> list[str]:
    roles = [role for text in given for role in text.split(",")]
    for role in roles:
        if role not in ROLES:
            raise MetrologyError(Fault("--require", repr(role), f"some of {', '.join(ROLES)}, with commas"))
    return roles


def _tell(verdict: Verdict) -> None:
    lines = [f"{verdict.report}: report {verdict.number}, {verdict.title}"]
    width = max(len(check.subject) for check in verdict.checks)
    lines += [f" {MARKS[check.state]} {check.subject:<{width}}  {check.sentence}" for check in verdict.checks]
    lines.append(_bottom(verdict))
    for line in lines:
        print(printable(line))


def _bottom(verdict: Verdict) -> str:
    count = Counter(check.state for check in verdict.checks)
    if verdict.outcome == "failed":
        return f"FAILED: {count['failed']} of {len(verdict.checks)} checks"
    if verdict.outcome == "incomplete":
        return f"INCOMPLETE: {count['not checked']} of {len(verdict.checks)} checks could not be made"
    return "good"
