"""`metrology authority`: a test authority, for trying out signatures."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from metrology.cli.campaigns import DONE


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("authority", help="make a test authority, for trying out signatures; proves nothing")
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="new folder for its keys and certificates")
    parser.set_defaults(command=authority)


def authority(options: argparse.Namespace) -> int:
    """Write a test authority."""
    from metrology import signoff

    root, *_ = signoff.create_authority(options.folder)
    folder = options.folder
    print(f"{root} is a TEST AUTHORITY: its signatures prove nothing. Try them out:")
    print(f"metrology sign REPORT --role author --key {folder}/author.p12 --password-file {folder}/password.txt")
    print(f"metrology verify REPORT --trust {root}")
    return DONE
