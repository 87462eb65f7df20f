"""`metrology schema`: the JSON Schemas of campaign files and of `results.json`."""

from __future__ import annotations

import argparse
from typing import Any

from metrology.cli.campaigns import DONE


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("schema", help="print the JSON Schema of campaign files, or of results.json")
    parser.add_argument(
        "what", nargs="?", choices=("campaign", "results"), default="campaign", help="default: campaign"
    )
    parser.set_defaults(command=schema)


def schema(options: argparse.Namespace) -> int:
    """Print a JSON Schema."""
    if options.what == "results":
        from metrology.published import schema_json as results_json

        print(results_json(), end="")
        return DONE
    from metrology.campaign.json_schema import schema_json

    print(schema_json(), end="")
    return DONE
