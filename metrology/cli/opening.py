"""`--open`: what a command made, shown in the browser of the machine."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def add(parser: argparse.ArgumentParser) -> None:
    """Declare that what was made is to be opened."""
    parser.add_argument("--open", action="store_true", help="open what was made in the browser")


def show(what: Path | str) -> None:
    """Open a file or an address in the browser; where there is none, say so: what was made is there all the same."""
    import webbrowser

    url = what.resolve().as_uri() if isinstance(what, Path) else what
    if not webbrowser.open(url):
        print(f"no browser was found to open {url}", file=sys.stderr)
