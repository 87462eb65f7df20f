"""What is wrong with a text in an editor, by line and column: as `metrology check` tells it, before it is saved."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from metrology.errors import Edit, Fault

_FIRST = re.compile(r"\ufeff?(?:[ \t]*(?:#[^\n]*)?\r?\n)*format:[ ]*[\"']?metrology-campaign/")
_WHERE = re.compile(r":(?P<line>\d+)(?::(?P<column>\d+))?(?: |$)")


@dataclass(frozen=True)
class Marked:
    """A fault with the part of the text that it is about: row and both columns count from 0."""

    row: int
    column: int
    end: int
    text: str
    edit: Edit | None


def is_campaign(text: str) -> bool:
    """Whether the first key of a text says that it is a campaign file."""
    return _FIRST.match(text) is not None


def faults(path: Path, text: str) -> list[Marked]:
    """Every fault of a text that is to be saved as `path`; its readings are those beside that."""
    from metrology.campaign import load

    return [_marked(path, text.split("\n"), fault) for fault in load.faults(path, text)]


def _marked(path: Path, lines: list[str], fault: Fault) -> Marked:
    own = _WHERE.match(fault.where, len(str(path))) if fault.where.startswith(str(path)) else None
    if own is not None:
        row = min(int(own["line"]), len(lines)) - 1
        column = min(int(own["column"] or 1) - 1, len(lines[row]))
        place = fault.where[own.end() :]
        head = f"{place}: " if place else ""
    else:
        row, column = _named(lines, fault.where)
        head = f"{fault.where}: "
    end = column + max(len(re.split(r"[,}\]](?=\s|$)|\s#", lines[row][column:])[0].rstrip()), 1)
    fix = f". Fix: {fault.fix}" if fault.fix else ""
    return Marked(row, column, end, f"{head}got {fault.got}; expected {fault.expected}{fix}", fault.edit)


def _named(lines: list[str], where: str) -> tuple[int, int]:
    """Where the text names the file of readings that has a fault; its beginning, where it does not."""
    name = Path(re.split(r":\d", where)[0]).name
    return next(((row, line.index(name)) for row, line in enumerate(lines) if name and name in line), (0, 0))
