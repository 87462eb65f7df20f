"""`metrology import`: a draft campaign from files of readings."""

from __future__ import annotations

import argparse
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from metrology.cli.campaigns import DONE, FAILED
from metrology.errors import Fault, MetrologyError, printable

PARTS = {
    "member": "file within a .zip that holds several",
    "sheet": "sheet of a workbook",
    "group": "group of a TDMS, HDF5 or MDF4 file",
    "dataset": "dataset of an HDF5 file, variable of a MAT file, array of an .npz file",
    "channel": "record of a UFF file, by its number from 1 or its name",
}
"""What of a file may be read in place of the whole: keys of an entry of readings."""


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("import", help="read files of readings and write a draft campaign for them")
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="readings of one test, of any format")
    parser.add_argument("--output", type=Path, help="the campaign file (default: in the folder of the first file)")
    parser.add_argument(
        "--set",
        dest="values",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a value that the files do not have, such as mass='1.196(1) kg'; may be repeated",
    )
    for key, what in PARTS.items():
        parser.add_argument(f"--{key}", metavar="NAME", help=what)
    parser.set_defaults(command=bring_in)


def bring_in(options: argparse.Namespace) -> int:
    """Write the draft, ask for what is missing where somebody can answer, and say what is left to do.

    It fails where the draft, read back as a campaign, has faults beside what is missing.
    """
    from metrology.declaration.document import GUESS
    from metrology.draft import Drafter, place
    from metrology.draft.trial import examples, faults
    from metrology.draft.writing import command

    given = dict(_pair(text) for text in options.values)
    parts = {key: name for key in PARTS if (name := getattr(options, key)) is not None}
    drafter = Drafter(options.files, options.output, parts)
    path, made = drafter.path, drafter.draft(given)
    if made.missing and sys.stdin.isatty():
        given |= _asked(made.missing)
        made = drafter.draft(given)
    place(path, made)
    filled = drafter.draft(given | examples(made.missing))
    wrong = faults(path, made, filled)
    guesses = made.text.count(GUESS)
    print(printable(f"{path} is written, with {guesses} guesses to confirm"))
    for remark in made.remarks:
        print(printable(f"  note: {remark}"))
    for name, what in made.missing.items():
        print(printable(f"  to fill in: {what} (--set {name}=…)"))
    for fault in wrong:
        print(f"  to correct: {fault}")
    print(printable(f"{'When that is corrected' if wrong else 'Its report'}: {command('report', path)}"))
    return FAILED if wrong else DONE


def _pair(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals or not value.strip():
        raise MetrologyError(Fault(f"--set {text}", "no value", "a name and a value, such as mass='1.196(1) kg'"))
    return name.strip(), value.strip()


def _asked(missing: dict[str, str]) -> dict[str, str]:
    """Answers to what is missing; an empty one leaves it open, and the end of the input all that follow."""
    answers: dict[str, str] = {}
    with suppress(EOFError):
        for name, what in missing.items():
            answers[name] = input(f"{what}: ").strip()
    return {name: answer for name, answer in answers.items() if answer}
