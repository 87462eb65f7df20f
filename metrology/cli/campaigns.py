"""What commands that take campaign files share: their arguments, evaluation file by file, progress."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError, printable
from metrology.summary import print_summary

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.findings import Findings
    from metrology.timeseries import Trace

DONE, FAILED, UNUSABLE = 0, 1, 2
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Evaluated:
    """A campaign, what its readings say, and every sample of its plots over time."""

    campaign: Campaign
    findings: Findings
    traces: Mapping[str, Trace]


def add(commands: Any, name: str, command: Callable[..., int], help_text: str) -> argparse.ArgumentParser:
    """Declare a command that takes campaign files."""
    parser: argparse.ArgumentParser = commands.add_parser(name, help=help_text)
    parser.add_argument(
        "files", type=Path, nargs="+", metavar="FILE", help="campaign.yaml, or the folder that holds it"
    )
    add_telling(parser)
    parser.set_defaults(command=command)
    return parser


def add_telling(parser: argparse.ArgumentParser) -> None:
    """Declare how much is said, and for whom."""
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--json", action="store_true", help="machine-readable output on stdout, alone")
    how.add_argument("--quiet", action="store_true", help="say nothing but what is wrong")
    how.add_argument("--verbose", action="store_true", help="say on stderr what is being done, with the time it took")


def add_output(parser: argparse.ArgumentParser) -> None:
    """Declare where reports go."""
    parser.add_argument("--output", type=Path, default=Path("reports"), help="where reports go (default: reports)")


def add_code(parser: argparse.ArgumentParser) -> None:
    """Declare that code which a campaign names may be run."""
    parser.add_argument(
        "--allow-code", action="store_true", help="run the Python files that campaigns name under diagnosis: effects"
    )


def add_coverage(parser: argparse.ArgumentParser) -> None:
    """Declare that tests need not be repeated by simulation."""
    parser.add_argument(
        "--no-coverage",
        action="store_true",
        help="do not repeat the tests by simulation to see how often the intervals hold what they should",
    )


PRINTED = ("Check", "Model", "Diagnosis", "Fit", "Comparison")
"""Kinds of notice of page 1 that the summary has no line of its own for."""


def show_summary(findings: Findings, folder: Path) -> None:
    """Print results, verdicts, and what page 1 of the report says of checks, models and comparisons."""
    from metrology.language.notices import brief

    print_summary(findings, folder, [notice for notice in brief(findings) if notice[0] in PRINTED])


def each_campaign(
    options: argparse.Namespace,
    write: Callable[[Evaluated, Path, Progress], None],
    show: Callable[[Findings, Path], None] = show_summary,
) -> int:
    """Evaluate every file, write what is made of it and show it; one that is unusable does not stop the others."""
    from metrology.campaign.days import ahead

    status, made, homes = DONE, [], dict[str, Path]()
    for path in options.files:
        try:
            with show_progress(str(path), options) as progress:
                evaluated = _evaluate(path, options, homes, progress)
                findings = evaluated.findings
                write(evaluated, options.output / findings.campaign.id, progress)
        except MetrologyError as error:
            print(error, file=sys.stderr)
            status = UNUSABLE
            continue
        made.append(findings)
        failed = any(entry.verdict == "fail" for entry in findings.conformity)
        if failed or findings.withheld or findings.failures:
            status = max(status, FAILED)
        if not options.json and not options.quiet:
            show(findings, options.output / findings.campaign.id)
            # Not in the report: results are the same on every day on which they are checked.
            for sentence in ahead(evaluated.campaign):
                print(printable(f"note {sentence}"))
    if options.json:
        _print_json(made)
    return status


def _refuse_same(homes: dict[str, Path], identity: str, path: Path) -> None:
    """Refuse a second campaign of one id, whose report would take the place of the first's."""
    if identity in homes:
        got = f"{identity!r}, the id of {homes[identity]} too"
        raise MetrologyError(
            Fault(f"{path} id", got, "an id of its own for each campaign, as reports go to its folder")
        )
    homes[identity] = path


def _evaluate(path: Path, options: argparse.Namespace, homes: dict[str, Path], progress: Progress) -> Evaluated:
    """Evaluate a file; what would be refused once its results are written is refused before."""
    from metrology.campaign.load import load

    progress("reading")
    campaign = load(campaign_file(path), allow_code=options.allow_code)
    _refuse_same(homes, campaign.id, path)
    from metrology import chain
    from metrology.report.recorded import refuse_other

    refuse_other(options.output / campaign.id, campaign.path)
    coverage = not getattr(options, "no_coverage", False)
    return Evaluated(campaign, *chain.traced(campaign, progress=progress, coverage=coverage))


def _print_json(made: Sequence[Findings]) -> None:
    from metrology.findings import to_json

    print("[" + ",".join(to_json(findings).decode() for findings in made) + "]")


def campaign_file(path: Path) -> Path:
    """The file itself, or the one in a folder."""
    return path / "campaign.yaml" if path.is_dir() else path


@contextmanager
def show_progress(title: str, options: argparse.Namespace) -> Iterator[Progress]:
    """Show what is being done on a terminal; in a pipe say nothing, unless `--verbose` asks for a line a step."""
    if options.verbose:
        began = monotonic()
        yield lambda text: print(printable(f"{monotonic() - began:7.1f} s  {title}: {text}"), file=sys.stderr)
        return
    if options.json or options.quiet or not sys.stderr.isatty():
        yield lambda _text: None
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status(escape(title)) as status:
        yield lambda text: status.update(f"{escape(title)}: {escape(text)}")
