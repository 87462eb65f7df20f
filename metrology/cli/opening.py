"""`--open`: what a command made, shown by the program that the machine has for it."""

from __future__ import annotations

import argparse
import sys


def add(parser: argparse.ArgumentParser) -> None:
    """Declare that what was made is to be opened."""
    parser.add_argument("--open", action="store_true", help="open what was made in the browser")


def show(url: str) -> None:
    """Open an address in the browser; where there is none, say so: what was made is there all the same."""
    import webbrowser

    if not webbrowser.open(url):
        print(f"no browser was found to open {url}", file=sys.stderr)
