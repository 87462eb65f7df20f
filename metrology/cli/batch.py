"""`metrology batch`: make the reports of all campaigns below a folder, on this machine or on many."""

from __future__ import annotations

import argparse
import json
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli import campaigns, opening
from metrology.cli.campaigns import DONE, FAILED, show_progress
from metrology.errors import Fault, MetrologyError, printable

if TYPE_CHECKING:
    from metrology.batch import Outcome


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("batch", help="make the reports of all campaigns below a folder")
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="folder with campaign.yaml files at any depth")
    campaigns.add_output(parser)
    campaigns.add_code(parser)
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--workers", type=int, metavar="N", help="processes on this machine (default: one for each processor)"
    )
    where.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler, such as tls://10.0.0.1:8786")
    parser.add_argument("--tls-ca-file", type=Path, help="certificate of the authority behind scheduler and workers")
    parser.add_argument("--tls-cert", type=Path, help="certificate of this side (default: Dask's configuration)")
    parser.add_argument("--tls-key", type=Path, help="its key")
    parser.add_argument("--no-tls", action="store_true", help="reach a scheduler on another machine without TLS")
    campaigns.add_telling(parser)
    opening.add(parser)
    parser.set_defaults(command=batch)


def batch(options: argparse.Namespace) -> int:
    """Make what is not up to date, write the index page, and end with a table; status 1 where anything failed."""
    from metrology.batch import find, index, make, workers
    from metrology.report import staging

    count = (os.cpu_count() or 1) if options.workers is None else options.workers
    if count < 1:
        raise MetrologyError(Fault("--workers", str(count), "1 at least"))
    paths = find(options.folder)
    tls = workers.Tls(options.tls_ca_file, options.tls_cert, options.tls_key, plain=options.no_tls)
    with (
        show_progress(str(options.folder), options) as progress,
        workers.crew(count, options.scheduler, tls) as ready,
    ):
        outcomes = make(paths, options.output, ready, allow_code=options.allow_code, progress=progress)
    options.output.mkdir(parents=True, exist_ok=True)
    staging.replace_file(options.output / index.NAME, index.page(outcomes, options.output))
    if options.json:
        _print_json(outcomes)
    elif not options.quiet:
        _print_table(outcomes, options.output / index.NAME)
    if options.open:
        opening.show(options.output / index.NAME)
    return FAILED if any(one.failed for one in outcomes) else DONE


def _print_json(outcomes: Sequence[Outcome]) -> None:
    entries = [asdict(one) | {"path": one.path.as_posix()} for one in outcomes]
    print(json.dumps(entries, indent=1, ensure_ascii=False))


def _print_table(outcomes: Sequence[Outcome], index: Path) -> None:
    width = max(len(printable(str(one.path))) for one in outcomes)
    for one in outcomes:
        print(f"{one.state:10}  {printable(str(one.path)):{width}}  {printable(one.judged)}".rstrip())
        for reason in one.reasons:
            print(f"{'':10}  {printable(reason)}")
    counts = Counter(one.state for one in outcomes)
    stated = ", ".join(f"{counts[state]} {state}" for state in ("made", "up to date", "not made"))
    print(f"{len(outcomes)} campaigns: {stated}; index: {index}")
