"""How the cells of a text stand: separator, headings, their units, decimal mark; found, or as stated."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

from metrology.declaration.readings import SEPARATORS
from metrology.message import said
from metrology.readings import lines
from metrology.readings.headings import are_units, is_unit, unit_text
from metrology.readings.sheet import MAX_COLUMNS, STATE, Heading, Job, refused
from metrology.units.dimensions import quoted

HEADER_LINES = 300
"""Lines in which headings are looked for: no instrument's header block that was seen is longer."""
NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?", re.ASCII)
COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_POINT = re.compile(r"[+-]?(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(?:(?:,\d{3})+|(?:\.\d{3})+)", re.ASCII)
_FIRST_NUMBER = re.compile(r"\s*[+-]?[\d.,]*\d[\d.,]*(?:[eE][+-]?\d+)?\s*[,;\t|]", re.ASCII)
NAMES = {value: key for key, value in SEPARATORS.items()}
_SEPARATED = {
    ",": "its cells are separated by commas", ";": "its cells are separated by semicolons",
    "\t": "its cells are separated by tabs", " ": "its cells are separated by spaces",
    "|": "its cells are separated by bars",
}  # fmt: skip
"""Separator → the remark on it."""


@dataclass(frozen=True)
class Layout:
    """How the cells of a text stand: separator, line of the headings, first line of readings, decimal mark.

    `doubtful`: a number whose mark may be the decimal mark or group the digits, where every one is so.
    """

    separator: str
    headings: tuple[Heading, ...]
    line: int
    first: int
    decimal: str = "."
    doubtful: str = ""


def find_layout(job: Job, text: str, stop: int) -> Layout:
    """Find separator, headings, units below them and the decimal mark; what is stated is taken as stated."""
    start, first = lines.below_notes(job.path, text, stop)
    top = [lines.one(job.path, text, start, first)]
    rest = lines.blocks(job.path, text, (min(start + len(top[0]) + 1, stop), min(stop, start + (1 << 16))), first + 1)
    top += list(islice((line for block, _ in rest for line in block), HEADER_LINES))
    stated = SEPARATORS[job.stated.separator] if job.stated.separator else None
    if job.stated.header is not None:
        at = job.stated.header + 1 - first
        if not 0 <= at < len(top):
            raise refused(
                job.log.where,
                f"'header: {job.stated.header}'",
                f"lines above the headings, {first - 1} to {first + len(top) - 2}",
            )
        separator = stated or max(_candidates(top[at], stated), key=lambda one: _score(job, top, at, one))
    else:
        at, separator = _best(job, top, stated)
        if first > 1 and not job.wanted(_headings(top, at, separator)):
            noted = _noted(job, text[:start].splitlines()[-2:], top[0], stated)
            if noted is not None:
                job.log.note(said("the headings stand behind '#', above line {line}", line=first))
                separator, headings = noted
                return Layout(separator, headings, 0, first, *_decimal(job, top, separator))
    cells = split(top[at], separator)
    _refuse_no_headings(job, top, at, first, separator, cells)
    return _layout(job, top[at:], separator, first + at, cells)


def _best(job: Job, top: Sequence[str], stated: str | None) -> tuple[int, str]:
    """The first line that has most of the columns that are due, and its separator."""
    best, found = (0, 0, 0, 0), (0, stated or ",")
    for at, line in enumerate(top):
        if _FIRST_NUMBER.match(line):
            continue
        for separator in _candidates(line, stated):
            score = _score(job, top, at, separator)
            if score[0] > best[0] or (at == found[0] and score > best):
                best, found = score, (at, separator)
        if best[0] >= max(job.due, 2) or (best[0] >= job.due and _is_numeric(top[min(found[0] + 1, len(top) - 1)])):
            break
    if not best[0] and not stated and _is_numbered(job):
        return 0, max(_candidates(top[0], None), key=lambda one: _score(job, top, 0, one))
    return found


def _is_numbered(job: Job) -> bool:
    """Whether the campaign names columns by their numbers."""
    return any(one.column.isdecimal() for one in (job.stated.columns or {}).values())


def _headings(top: Sequence[str], at: int, separator: str) -> list[Heading]:
    """Cells of a line as headings, with the units of the line below where that has nothing else."""
    cells = split(top[at], separator)
    below = [unit_text(cell) for cell in split(top[at + 1], separator)][: len(cells)] if at + 1 < len(top) else []
    if len(below) == len(cells) and are_units(below):
        return [Heading(cell, unit) for cell, unit in zip(cells, below, strict=True)]
    return [Heading(cell) for cell in cells]


def _noted(job: Job, notes: Sequence[str], row: str, stated: str | None) -> tuple[str, tuple[Heading, ...]] | None:
    """Separator and headings that stand behind '#', right above a row of numbers; a last line of units goes with them.

    None where the notes have no line with as many cells, or none of them is due.
    """
    for separator in _candidates(row, stated):
        cells = split(row, separator)
        if len(cells) < 2 or not all(NUMBER.fullmatch(cell.strip()) for cell in cells):
            continue
        above = [[cell.strip() for cell in split(note.lstrip("#").strip(), separator)] for note in notes]
        above = [line for line in above if len(line) == len(cells)]
        if not above:
            continue
        names, below = above[-1], [""] * len(cells)
        if len(above) > 1 and all(cell[:1] in "[(<" for cell in names):
            names, below = above[-2], [unit_text(cell) for cell in names]
        found = tuple(
            Heading(name, unit if unit and is_unit(unit) else "") for name, unit in zip(names, below, strict=True)
        )
        if job.wanted(found):
            return separator, found
    return None


def _candidates(line: str, stated: str | None) -> Sequence[str]:
    return [stated] if stated else [",", *(mark for mark in (";", "\t", "|") if mark in line)]


def _score(job: Job, top: Sequence[str], at: int, separator: str) -> tuple[int, int, int, int]:
    """Columns that are due among the cells; then whether there are several cells; then the usual separator."""
    cells = _headings(top, at, separator)
    return job.wanted(cells), int(len(cells) > 1), int(separator == ","), len(cells)


def _refuse_no_headings(
    job: Job, top: Sequence[str], at: int, first: int, separator: str, cells: Sequence[str]
) -> None:
    """Say what the file has in place of a line of headings, where no column that is due was found."""
    if _is_numbered(job):
        return
    if len(cells) > MAX_COLUMNS:
        raise refused(job.log.at(first + at), f"{len(cells)} columns", f"at most {MAX_COLUMNS}")
    if job.stated.header is not None or job.wanted(_headings(top, at, separator)):
        return
    fix = "write the headings above the readings, or number the columns: 'columns: {time: {column: 1, unit: s}}'"
    if len(spaced := top[at].split()) > 1 and all(NUMBER.fullmatch(cell) for cell in spaced) and len(cells) < 2:
        fix += ", and state 'separator: space'"
    if any(_first_alike(top, mark) <= at for mark in _candidates(top[at], None)):
        every = all(NUMBER.fullmatch(cell.strip()) for cell in cells)
        got = f"{quoted(top[at])}, {'numbers' if every else 'a reading'} where headings are due"
        raise refused(job.log.at(first + at), got, "a line of headings", fix)
    data = _first_row(top)
    if data > at + 1:
        got = f"{data} lines of text, such as an instrument's header block, with no heading that is due"
        fix = (
            "'metrology import' finds the columns; or state 'header' and 'columns' in the campaign file"
            if job.state == STATE
            else "write names and units that are known right above the readings, such as 'time / s' and 'force / N'"
        )
        raise refused(job.log.at(first), got, "a line with the headings that are due", fix)


def _numbers(line: str, separator: str) -> list[int]:
    """Which cells of a line are numbers."""
    return [at for at, cell in enumerate(split(line, separator)) if NUMBER.fullmatch(cell.strip())]


def _first_row(top: Sequence[str]) -> int:
    """Index of the first line from which on all have as many cells, and numbers in the same ones; 0 where none has."""
    found = [first for mark in _candidates(top[-1], None) if (first := _first_alike(top, mark)) < len(top) - 2]
    return min(found, default=0) or _first_numbers(top)


def _first_alike(top: Sequence[str], separator: str) -> int:
    """Index of the first line from which on all are as the last one is, cut into cells by a separator."""
    kinds = [(line.count(separator), _numbers(line, separator)) for line in top]
    if not kinds[-1][1]:
        return len(top)
    return len(top) - next((at for at, kind in enumerate(reversed(kinds)) if kind != kinds[-1]), len(top))


def _first_numbers(top: Sequence[str]) -> int:
    """Index of the first line of a run of lines of numbers; 0 where there is none."""
    numeric = [_is_numeric(line) for line in top]
    return next((at for at in range(len(top) - 2) if all(numeric[at : at + 3])), 0)


def _is_numeric(line: str) -> bool:
    cells = [cell.strip() for cell in re.split(r"[;\t|]|,(?=\s|\D|$)|\s+", line) if cell.strip()]
    return bool(cells) and all(NUMBER.fullmatch(cell) or re.fullmatch(r"[\d:.,+-]+", cell) for cell in cells)


def _layout(job: Job, top: Sequence[str], separator: str, line: int, cells: list[str]) -> Layout:
    """Headings with their units, first line of readings, decimal mark; `top` begins at the headings."""
    if job.stated.header is None and line > 1 and not all(one.startswith("#") for one in _above(job, line)):
        job.log.note(said("lines 1 to {last} above the headings were passed over", last=line - 1))
    if separator != "," and not job.stated.separator:
        job.log.note(said(_SEPARATED[separator]))
    if all(NUMBER.fullmatch(cell.strip()) for cell in cells):
        return Layout(separator, tuple(Heading("") for _ in cells), 0, line, *_decimal(job, top, separator))
    while len(cells) > 1 and not cells[-1].strip():
        cells.pop()
        job.log.note(said("empty columns on the right were left out"))
    headings, first = tuple(Heading(cell.strip()) for cell in cells), line + 1
    below = [unit_text(cell) for cell in split(top[1], separator)][: len(cells)] if len(top) > 1 else []
    if len(below) == len(cells) and are_units(below):
        headings = tuple(Heading(one.text, unit) for one, unit in zip(headings, below, strict=True))
        first += 1
        job.log.note(said("line {line} was read as the units of the headings", line=line + 1))
    return Layout(separator, headings, line, first, *_decimal(job, top[first - line :], separator))


def _above(job: Job, line: int) -> list[str]:
    """Lines above the headings, roughly: those of a file in another encoding are not notes either way."""
    return job.content[: 1 << 20].decode("latin-1").splitlines()[: line - 1]


def _decimal(job: Job, data: Sequence[str], separator: str) -> tuple[str, str]:
    """The decimal mark: as stated, or as the numbers show; and a number, where it may as well group the digits."""
    if job.stated.decimal:
        return ("," if job.stated.decimal == "comma" else "."), ""
    if separator == ",":
        return ".", ""
    cells = [cell.strip().strip('"') for line in data for cell in line.split(None if separator == " " else separator)]
    marked = [cell for cell in cells if COMMA.fullmatch(cell) or _POINT.fullmatch(cell)]
    plain = {"," in cell for cell in marked if not GROUPED.fullmatch(cell)}
    if marked and not plain:
        return ".", marked[0]
    if plain != {True}:
        return ".", ""
    job.log.note(said("its decimal mark is a comma"))
    return ",", ""


def split(line: str, separator: str) -> list[str]:
    """Cells of one line; the whole line where its quotation marks do not match."""
    if separator == " ":
        return [cell.strip('"') for cell in line.split()]
    try:
        return next(csv.reader([line], delimiter=separator, strict=True), [])
    except csv.Error:
        return line.split(separator)
