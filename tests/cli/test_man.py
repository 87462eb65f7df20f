"""The man page is that of the command line as it is: `make docs` writes it."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from metrology import __version__
from metrology.cli import parser

PAGE = (Path(__file__).parents[2] / "docs" / "man" / "metrology.1").read_text(encoding="utf-8")


def plain(roff: str) -> str:
    """The text of roff without its spaces: a line may break at any of them, and at a hyphen."""
    return "".join(re.sub(r"\\f.|\\,|\\/|\\&", "", roff).replace("\\-", "-").replace("\\(aq", "'").split())


def commands(root: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for action in root._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield below.prog, below
                yield from commands(below)


COMMANDS = dict(commands(parser()))


def test_every_command_of_now_has_its_section_and_no_other_has():
    assert re.findall(r"^\.SS \\fB(.*?)\\fR", PAGE, re.MULTILINE) == list(COMMANDS)
    assert f'"metrology {__version__}"' in PAGE.splitlines()[0]


@pytest.mark.parametrize("name", COMMANDS)
def test_a_section_has_the_options_of_now_with_their_help(name: str):
    section = PAGE.split(f".SS \\fB{name}\\fR", 1)[1].split("\n.SS", 1)[0]
    actions = [one for one in COMMANDS[name]._actions if not isinstance(one, argparse._HelpAction)]
    written = {plain(one) for one in re.findall(r"^\.TP\n\\fB(.*?)\\fR", section, re.MULTILINE)}
    options = {", ".join(one.option_strings) for one in actions if one.option_strings}
    assert {re.split(r"[^-a-z0-9]", one)[0] for one in written if one.startswith("-")} == options
    for action in actions:
        if action.help and not isinstance(action, argparse._SubParsersAction):
            assert plain(action.help % vars(action) if "%(" in action.help else action.help) in plain(section)


def test_no_line_is_taken_for_a_request_that_roff_does_not_know():
    requests = set(re.findall(r"^\.([A-Za-z]+)", PAGE, re.MULTILINE))
    assert requests <= {"TH", "SH", "SS", "B", "TP", "RS", "RE", "PP", "br", "nf", "fi"}
