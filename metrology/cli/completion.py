"""`metrology completion`: what a shell needs to complete commands, options and names of files."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from metrology.cli.campaigns import DONE
from metrology.errors import without

SHELLS = ("bash", "zsh", "fish")
CAMPAIGN = {
    "bash": "_metrology_campaign",
    "zsh": "_files -g '*.yaml'",
    "fish": "(__fish_complete_suffix .yaml)",
}
"""How each shell completes a campaign file, or a folder."""
REPORT = {
    "bash": "_metrology_report",
    "zsh": "_files -g '*.pdf'",
    "fish": "(__fish_complete_suffix .pdf)",
}
PREAMBLE = {
    "bash": """
_metrology_campaign() { compgen -f -X '!*.yaml' -- "$1"; compgen -d -S / -- "$1"; }
_metrology_report() { compgen -f -X '!*.pdf' -- "$1"; compgen -d -S / -- "$1"; }
"""
}
FOLDERS = ("folder", "output", "templates")
"""Arguments that are folders."""


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("completion", help="print what a shell needs to complete commands and file names")
    parser.add_argument("shell", choices=SHELLS)
    parser.set_defaults(command=completion)


def completion(options: argparse.Namespace) -> int:
    """Print the script for one shell."""
    try:
        import shtab
    except ImportError:
        raise without("shtab", "editor", "metrology completion") from None
    from metrology.cli import parser

    root = parser()
    for command, action in _arguments(root):
        if action.type is Path:
            action.complete = _names(command, action)  # type: ignore[attr-defined]
    print(shtab.complete(root, options.shell, preamble=PREAMBLE), end="")  # type: ignore[arg-type]
    return DONE


def _arguments(parser: argparse.ArgumentParser, command: str = "") -> Iterator[tuple[str, argparse.Action]]:
    """Every argument of every command, with the name of its command."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                yield from _arguments(below, command or name)
        else:
            yield command, action


def _names(command: str, action: argparse.Action) -> dict[str, str]:
    import shtab

    if action.dest in {"file", "files"} and command != "import":
        return CAMPAIGN
    if action.dest == "report":
        return REPORT
    found: dict[str, str] = shtab.DIRECTORY if action.dest in FOLDERS and action.metavar != "FILE" else shtab.FILE  # type: ignore[assignment]
    return found
