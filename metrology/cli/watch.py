"""`metrology watch`: a campaign's report in the browser, computed again on every save."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from metrology.cli import campaigns, opening
from metrology.cli.campaigns import DONE
from metrology.errors import without


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("watch", help="show a report in the browser, and compute it again on every save")
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="campaign.yaml, the folder that holds it, or a folder of such folders"
    )
    parser.add_argument("--port", type=int, default=0, help="port of 127.0.0.1 (default: a free one)")
    parser.add_argument("--output", type=Path, help="write the reports there too (default: nothing is written)")
    campaigns.add_code(parser)
    opening.add(parser)
    parser.set_defaults(command=watch)


def watch(options: argparse.Namespace) -> int:
    """Serve the pages until Ctrl-C."""
    try:
        import watchfiles  # noqa: F401
    except ImportError:
        raise without("watchfiles", "editor", "metrology watch") from None
    from metrology.watch import watch as serve

    def ready(url: str) -> None:
        print(f"{options.file}: {url} (Ctrl-C ends it)", flush=True)
        if options.open:
            opening.show(url)

    serve(options.file, port=options.port, output=options.output, allow_code=options.allow_code, ready=ready)
    return DONE
