"""`metrology schema`: the JSON Schema of campaign files."""

from __future__ import annotations

import argparse
from typing import Any

from metrology.cli.campaigns import DONE


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("schema", help="print the JSON Schema of campaign files")
    parser.set_defaults(command=schema)


def schema(_options: argparse.Namespace) -> int:
    """Print the JSON Schema of campaign files."""
    from metrology.campaign.schema import schema_json

    print(schema_json(), end="")
    return DONE
