"""The command line: check, run, report, schema, new.

Exit status: 0 done; 1 a campaign was processed and something in it failed its requirement; 2 bad input or usage.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology import __version__
from metrology.errors import Fault, MetrologyError

if TYPE_CHECKING:
    from metrology.findings import Findings

DONE, FAILED, UNUSABLE = 0, 1, 2
Progress = Callable[[str], None]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    # Small matrices: threads of BLAS cost more than they give, and their number would show in the last bits.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    options = _parser().parse_args(arguments)
    try:
        status: int = options.command(options)
    except MetrologyError as error:
        print(error, file=sys.stderr)
        return UNUSABLE
    except KeyboardInterrupt:
        print("interrupted; reports made earlier are whole", file=sys.stderr)
        return UNUSABLE
    except BrokenPipeError:
        sys.stderr.close()
        return UNUSABLE
    except OSError as error:
        print(f"{error.filename or 'output'}: {error.strerror}; reports made earlier are whole", file=sys.stderr)
        return UNUSABLE
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="metrology", description="From a campaign file to a test report.")
    parser.add_argument("--version", action="version", version=f"metrology {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_campaign_command(commands, "check", check, "report every fault of campaign files")
    _add_campaign_command(commands, "run", run, "evaluate campaigns and write results.json")
    report_parser = _add_campaign_command(commands, "report", report, "evaluate campaigns and write their reports")
    report_parser.add_argument("--templates", type=Path, help="folder with templates of the laboratory's own")
    schema_parser = commands.add_parser("schema", help="print the JSON Schema of campaign files")
    schema_parser.set_defaults(command=schema)
    new_parser = commands.add_parser("new", help="write a commented starter campaign that runs at once")
    new_parser.add_argument("name", help="name of the campaign: letters, digits and dashes")
    new_parser.add_argument(
        "--folder", type=Path, default=Path("campaigns"), help="where to put it (default: campaigns)"
    )
    new_parser.set_defaults(command=new)
    return parser


def _add_campaign_command(
    commands: Any, name: str, command: Callable[..., int], help_text: str
) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(name, help=help_text)
    parser.add_argument(
        "files", type=Path, nargs="+", metavar="FILE", help="campaign.yaml, or the folder that holds it"
    )
    parser.add_argument("--json", action="store_true", help="machine-readable output on stdout, alone")
    if name != "check":
        parser.add_argument("--output", type=Path, default=Path("reports"), help="where reports go (default: reports)")
    parser.set_defaults(command=command)
    return parser


def check(options: argparse.Namespace) -> int:
    """Load every file and tell all faults of all of them."""
    from metrology.campaign.load import load

    outcome: list[dict[str, Any]] = []
    for path in options.files:
        faults: tuple[Fault, ...] = ()
        try:
            load(_campaign_file(path))
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


def run(options: argparse.Namespace) -> int:
    """Evaluate every file and write its `results.json`."""

    def write(findings: Findings, folder: Path, _progress: Progress) -> None:
        from metrology.report import write_results

        write_results(findings, folder)

    return _each_campaign(options, write)


def report(options: argparse.Namespace) -> int:
    """Evaluate every file and write its report: PDF, HTML, JSON, CSV."""

    def write(findings: Findings, folder: Path, progress: Progress) -> None:
        from metrology.report import write as write_report

        write_report(findings, folder, templates=options.templates, progress=progress)

    return _each_campaign(options, write)


def schema(_options: argparse.Namespace) -> int:
    """Print the JSON Schema of campaign files."""
    from metrology.campaign.schema import schema_json

    print(schema_json(), end="")
    return DONE


def new(options: argparse.Namespace) -> int:
    """Write a starter campaign."""
    from metrology.campaign.starter import create

    path = create(options.name, options.folder)
    print(f"{path} is ready. Make its report: metrology report {path}")
    return DONE


def _each_campaign(options: argparse.Namespace, write: Callable[[Findings, Path, Progress], None]) -> int:
    from metrology.summary import print_summary

    status, made, homes = DONE, [], dict[str, Path]()
    for path in options.files:
        try:
            with _progress(str(path), quiet=options.json) as progress:
                findings = _evaluate(path, progress)
                _refuse_same(homes, findings.campaign.id, path)
                write(findings, options.output / findings.campaign.id, progress)
        except MetrologyError as error:
            print(error, file=sys.stderr)
            status = UNUSABLE
            continue
        made.append(findings)
        if any(entry.verdict == "fail" for entry in findings.conformity) or findings.failures:
            status = max(status, FAILED)
        if not options.json:
            print_summary(findings, options.output / findings.campaign.id)
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


def _evaluate(path: Path, progress: Progress) -> Findings:
    from metrology import chain
    from metrology.campaign.load import load

    progress("reading")
    return chain.evaluate(load(_campaign_file(path)), progress=progress)


def _print_json(made: Sequence[Findings]) -> None:
    from metrology.findings import to_json

    print("[" + ",".join(to_json(findings).decode() for findings in made) + "]")


def _campaign_file(path: Path) -> Path:
    return path / "campaign.yaml" if path.is_dir() else path


@contextmanager
def _progress(title: str, *, quiet: bool) -> Iterator[Progress]:
    """Show what is being done on a terminal; say nothing in a pipe."""
    if quiet or not sys.stderr.isatty():
        yield lambda _text: None
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status(escape(title)) as status:
        yield lambda text: status.update(f"{escape(title)}: {escape(text)}")
