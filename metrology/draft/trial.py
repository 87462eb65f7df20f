"""A draft read back as a campaign, with examples in the place of what only the laboratory knows."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from metrology.campaign.load import of_document
from metrology.declaration.document import parse
from metrology.draft.writing import Draft
from metrology.errors import Fault, MetrologyError

_EXAMPLE = re.compile(r"such as '?(?P<value>(?:(?! or )[^';,])+)")
_LINE = re.compile(r":(\d+)(?::|\b)")


def examples(missing: Mapping[str, str]) -> dict[str, str]:
    """A value for each that is missing, as its question has it; loads differ, as two alike would be a fault.

    Examples
    --------
    >>> examples({"mass": "mass that swings, such as 1.196(1) kg", "load.L2": "mass or force, such as '2.0 kg'"})
    {'mass': '1.196(1) kg', 'load.L2': '2 kg'}
    """
    found: dict[str, str] = {}
    for number, (name, what) in enumerate(missing.items(), start=1):
        match = _EXAMPLE.search(what)
        found[name] = f"{number} kg" if name.startswith("load.") else match["value"].strip() if match else "1"
    return found


def faults(path: Path, made: Draft, filled: Draft) -> list[Fault]:
    """What is wrong with a draft and its readings beside what is missing in it.

    Parameters
    ----------
    path : Path
        Where the draft stands; its readings lie below its folder.
    made : Draft
        As it was written.
    filled : Draft
        The same with `examples`.
    """
    try:
        of_document(parse(path, filled.text.encode()))
    except MetrologyError as error:
        lines = made.text.split("\n")
        missing = {
            number
            for number, (line, other) in enumerate(zip(lines, filled.text.split("\n"), strict=False), start=1)
            if line != other
        }
        return [fault for fault in error.faults if _line(path, fault) not in missing]
    return []


def _line(path: Path, fault: Fault) -> int:
    """Line of the campaign file at which a fault stands; 0 for one of the readings."""
    match = _LINE.match(fault.where.removeprefix(str(path)))
    return int(match[1]) if match and fault.where.startswith(str(path)) else 0
