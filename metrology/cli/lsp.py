"""`metrology lsp`: faults, completion and hover in an editor, by the language server protocol on stdin and stdout."""

from __future__ import annotations

import argparse
from typing import Any

from metrology.cli.campaigns import DONE
from metrology.errors import without


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("lsp", help="serve an editor: faults, completion and hover (docs/editor.md)")
    parser.set_defaults(command=lsp)


def lsp(_options: argparse.Namespace) -> int:
    """Serve until the editor closes."""
    try:
        from metrology.lsp.server import server
    except ModuleNotFoundError as error:
        if not (error.name or "").startswith(("pygls", "lsprotocol")):
            raise
        raise without(str(error.name), "editor", "metrology lsp") from None
    server.start_io()
    return DONE
