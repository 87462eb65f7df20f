"""`metrology new`: a starter campaign."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from metrology.cli.campaigns import DONE


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("new", help="write a commented starter campaign that runs at once")
    parser.add_argument("name", help="name of the campaign: letters, digits and dashes")
    parser.add_argument("--folder", type=Path, default=Path("campaigns"), help="where to put it (default: campaigns)")
    parser.add_argument(
        "--method", choices=("elongation", "relaxation"), default="elongation",
        help="method of its test (default: elongation)",
    )  # fmt: skip
    parser.set_defaults(command=new)


def new(options: argparse.Namespace) -> int:
    """Write a starter campaign."""
    from metrology.campaign.starter import create

    path = create(options.name, options.folder, options.method)
    print(f"{path} is ready. Make its report: metrology report {path}")
    return DONE
