"""`metrology collect`: results of many campaigns in one table, and control charts of check standards."""

from __future__ import annotations

import argparse
import json
import re
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli.campaigns import DONE, FAILED, UNUSABLE
from metrology.errors import printable

if TYPE_CHECKING:
    from metrology.export.control import Chart


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("collect", help="put the results of many campaigns into one table")
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder below which the results.json lie")
    parser.add_argument("--out", type=Path, default=Path("results.csv"), metavar="FILE", help="a .csv or .parquet file")
    parser.add_argument(
        "--check-standard",
        action="append",
        default=[],
        metavar="RESULT",
        help="make a control chart of a result, such as check-wire.k; may be repeated",
    )
    parser.add_argument("--json", action="store_true", help="machine-readable output on stdout, alone")
    parser.set_defaults(command=collect)


def collect(options: argparse.Namespace) -> int:
    """Write the table and the charts; status 1 where a check standard is not in control, or cannot be judged."""
    from metrology.export import collect as collecting
    from metrology.export.control import chart

    found = collecting.collect(options.folder)
    for fault in found.unreadable:
        print(fault, file=sys.stderr)
    if not found.rows:
        return UNUSABLE
    collecting.write(found.rows, options.out)
    charts = [chart(found.rows, name) for name in options.check_standard]
    for each in charts:
        _write(each, options.out)
    if options.json:
        rows = [asdict(row) for row in found.rows]
        unreadable = [vars(fault) for fault in found.unreadable]
        document = {"rows": rows, "unreadable": unreadable, "charts": [asdict(each) for each in charts]}
        print(json.dumps(document, indent=1, ensure_ascii=False, default=str))
    else:
        print(f"{len(found.rows)} results, {len(found.unreadable)} file(s) not read, written to {options.out}")
        for each in charts:
            print(printable(each.sentence))
    return FAILED if any(not each.in_control for each in charts) else DONE


def _write(chart: Chart, table: Path) -> None:
    """Write a chart's files beside the table; one without enough points has none."""
    from metrology.export import picture
    from metrology.report import staging

    if chart.in_control is None:
        return
    stem = f"{table.stem}-{re.sub(r'[^A-Za-z0-9_.-]', '_', chart.name)}"
    for name, content in picture.files(chart, stem).items():
        staging.replace_file(table.with_name(name), content)
