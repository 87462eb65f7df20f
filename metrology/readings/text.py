"""Text with cells: CSV of any dialect. Separator, decimal mark, headings and their units are found, or stated."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from operator import methodcaller

import numpy as np

from metrology.declaration.readings import SEPARATORS
from metrology.readings import lines
from metrology.readings.headings import are_units, unit_text
from metrology.readings.sheet import MAX_COLUMNS, Chunk, Heading, Job, Sheet, refused
from metrology.units.dimensions import quoted

HEADER_LINES = 300
"""Lines in which headings are looked for: no instrument's header block that was seen is longer."""
NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?", re.ASCII)
_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?", re.ASCII)
_POINT = re.compile(r"[+-]?(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+", re.ASCII)
_FIRST_NUMBER = re.compile(r"\s*[+-]?[\d.,]*\d[\d.,]*(?:[eE][+-]?\d+)?\s*[,;\t|]", re.ASCII)
_MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
_WESTERN = frozenset("äöüÄÖÜßéèêëàâçñåøæÅØÆôîï°µ²³±·×–“”„’Øœ§€ÉÀ")
"""What a text in Windows-1252 of a laboratory may hold beyond ASCII; other bytes are another encoding, or no text."""
_NAMES = {value: key for key, value in SEPARATORS.items()}


@dataclass(frozen=True)
class Layout:
    """How the cells of a text stand: separator, line of the headings, first line of readings, decimal mark."""

    separator: str
    headings: tuple[Heading, ...]
    line: int
    first: int
    decimal: str = "."


def read(job: Job) -> Sheet:
    """Return the table that a text holds."""
    text = decoded(job)
    stop = lines.end(text)
    last = text.count("\n", 0, stop) + 1
    if not text.endswith("\n"):
        job.log.note("the last line has no line end: the file may be cut short")
    layout = find_layout(job, text, stop)
    start = _offset(text, layout.first, stop)
    blocks = lines.blocks(job.path, text, (start, stop), layout.first) if layout.first <= last else iter(())
    chunks = _Rows(job, layout, last).chunks(blocks)
    return Sheet(layout.headings, chunks, layout.line, layout.decimal, separator=layout.separator)


def laid_out(job: Job, text: str, separator: str, decimal: str) -> Sheet:
    """Return the table of a text whose first line has the headings, separated as a file of its format has it."""
    stop = lines.end(text)
    first = lines.one(job.path, text, 0, 1)
    headings = tuple(Heading(cell.strip()) for cell in split(first, separator))
    while headings and headings[-1].text in ("Comment", ""):
        headings = headings[:-1]
    layout = Layout(separator, headings, 1, 2, decimal)
    blocks = lines.blocks(job.path, text, (min(len(first) + 1, stop), stop), 2)
    return Sheet(headings, _Rows(job, layout, text.count("\n", 0, stop) + 1).chunks(blocks), 1, decimal)


# -- characters


def decoded(job: Job) -> str:
    """The text of a file, with line feeds between its lines.

    Raises
    ------
    MetrologyError
        Where it is not in the encoding that is stated, or in none that can be recognised.
    """
    text = _characters(job, job.content)
    if "\r\n" in text:
        job.log.note("its lines end in CR LF")
        text = text.replace("\r\n", "\n")
    for character, name in (("\0", "a null character"), ("\r", "a carriage return without a line feed")):
        if character in text:
            raise refused(job.log.at(text.count("\n", 0, text.index(character)) + 1), name, "lines of plain text")
    if not text or text.isspace():
        raise refused(job.log.where, "an empty file", "a heading line and readings")
    return text


def _characters(job: Job, raw: bytes) -> str:
    mark = next((mark for mark in _MARKS if raw.startswith(mark)), b"")
    if mark:
        job.log.note(f"it begins with a byte order mark ({_MARKS[mark].upper()})")
    encoding = job.stated.encoding or _MARKS.get(mark, "utf-8")
    try:
        return raw[len(mark) :].decode(encoding)
    except LookupError:
        raise refused(job.log.where, f"the encoding '{encoding}'", "one such as 'utf-8' or 'cp1252'") from None
    except UnicodeDecodeError as error:
        text = raw.decode("cp1252", "replace") if not job.stated.encoding and not mark else ""
        if text and {letter for letter in text if not letter.isascii()} <= _WESTERN:
            job.log.note("it was read as Windows-1252, as it is not UTF-8; state 'encoding: cp1252'")
            return text
        where = job.log.at(raw.count(10, 0, error.start + len(mark)) + 1)
        expected = f"text in {encoding.upper()}"
        fix = "save the file as UTF-8, or state its 'encoding' in the campaign file"
        raise refused(where, f"byte 0x{raw[error.start + len(mark)]:02x}", expected, fix) from None


# -- layout


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
        separator = stated or max(_candidates(top[at], stated), key=lambda one: _score(job, split(top[at], one), one))
    else:
        at, separator = _best(job, top, stated)
    cells = split(top[at], separator)
    _refuse_no_headings(job, top, at, first, cells)
    return _layout(job, top[at:], separator, first + at, cells)


def _best(job: Job, top: Sequence[str], stated: str | None) -> tuple[int, str]:
    """The first line that has most of the columns that are due, and its separator."""
    best, found = (0, 0, 0, 0), (0, stated or ",")
    for at, line in enumerate(top):
        if _FIRST_NUMBER.match(line):
            continue
        for separator in _candidates(line, stated):
            score = _score(job, split(line, separator), separator)
            if score[0] > best[0] or (at == found[0] and score > best):
                best, found = score, (at, separator)
        if best[0] >= max(job.due, 2) or (best[0] >= job.due and _is_numeric(top[min(found[0] + 1, len(top) - 1)])):
            break
    return found


def _candidates(line: str, stated: str | None) -> Sequence[str]:
    return [stated] if stated else [",", *(mark for mark in (";", "\t", "|") if mark in line)]


def _score(job: Job, cells: Sequence[str], separator: str) -> tuple[int, int, int, int]:
    """Columns that are due among the cells; then whether there are several cells; then the usual separator."""
    found = job.wanted([Heading(cell) for cell in cells])
    return found, int(len(cells) > 1), int(separator == ","), len(cells)


def _refuse_no_headings(job: Job, top: Sequence[str], at: int, first: int, cells: Sequence[str]) -> None:
    """Say what the file has in place of a line of headings, where no column that is due was found."""
    if job.stated.columns and any(one.column.isdecimal() for one in job.stated.columns.values()):
        return
    if len(cells) > MAX_COLUMNS:
        raise refused(job.log.at(first + at), f"{len(cells)} columns", f"at most {MAX_COLUMNS}")
    if job.stated.header is not None or job.wanted([Heading(cell) for cell in cells]):
        return
    fix = "write the headings above the readings, or number the columns: 'columns: {time: {column: 1, unit: s}}'"
    if all(NUMBER.fullmatch(cell.strip()) for cell in cells):
        raise refused(
            job.log.at(first + at), f"{quoted(top[at])}, numbers where headings are due", "a line of headings", fix
        )
    data = _first_numbers(top)
    if data > at + 1:
        got = f"{data} lines of text, such as an instrument's header block, with no heading that is due"
        fix = "'metrology import' finds the columns; or state 'header' and 'columns' in the campaign file"
        raise refused(job.log.at(first), got, "a line with the headings that are due", fix)


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
        job.log.note(f"lines 1 to {line - 1} above the headings were passed over")
    if separator != "," and not job.stated.separator:
        job.log.note(f"its cells are separated by {_NAMES[separator]}s")
    if all(NUMBER.fullmatch(cell.strip()) for cell in cells):
        return Layout(separator, tuple(Heading("") for _ in cells), 0, line, _decimal(job, top, separator))
    while len(cells) > 1 and not cells[-1].strip():
        cells.pop()
        job.log.note("empty columns on the right were left out")
    headings, first = tuple(Heading(cell.strip()) for cell in cells), line + 1
    below = [unit_text(cell) for cell in split(top[1], separator)][: len(cells)] if len(top) > 1 else []
    if len(below) == len(cells) and are_units(below):
        headings = tuple(Heading(one.text, unit) for one, unit in zip(headings, below, strict=True))
        first += 1
        job.log.note(f"line {line + 1} was read as the units of the headings")
    return Layout(separator, headings, line, first, _decimal(job, top[first - line :], separator))


def _above(job: Job, line: int) -> list[str]:
    """Lines above the headings, roughly: those of a file in another encoding are not notes either way."""
    return job.content[: 1 << 20].decode("latin-1").splitlines()[: line - 1]


def _decimal(job: Job, data: Sequence[str], separator: str) -> str:
    """The decimal mark: as stated, or a comma where numbers have one and none has a point."""
    if job.stated.decimal:
        return "," if job.stated.decimal == "comma" else "."
    if separator == ",":
        return "."
    cells = [cell.strip().strip('"') for line in data for cell in line.split(None if separator == " " else separator)]
    commas = [cell for cell in cells if _COMMA.fullmatch(cell)]
    if not commas or any(_POINT.fullmatch(cell) for cell in cells):
        return "."
    if all(_GROUPED.fullmatch(cell) for cell in commas):
        got = f"numbers such as {quoted(commas[0])}, whose comma may be a decimal mark or group the digits"
        raise refused(job.log.where, got, "one of the two", "state 'decimal: comma', or 'decimal: point' and no groups")
    job.log.note("its decimal mark is a comma")
    return ","


def split(line: str, separator: str) -> list[str]:
    """Cells of one line; the whole line where its quotation marks do not match."""
    if separator == " ":
        return [cell.strip('"') for cell in line.split()]
    try:
        return next(csv.reader([line], delimiter=separator, strict=True), [])
    except csv.Error:
        return line.split(separator)


def _offset(text: str, line: int, stop: int) -> int:
    at = 0
    for _ in range(line - 1):
        found = text.find("\n", at, stop)
        if found < 0:
            return stop + 1
        at = found + 1
    return at


# -- rows


class _Rows:
    """Cuts lines into columns, some at a time; a line with another number of cells than the headings is a fault."""

    def __init__(self, job: Job, layout: Layout, last: int) -> None:
        self.log, self.separator, self.last = job.log, layout.separator, last
        self.used = job.stated.rows or (0, last)
        self.width = len(layout.headings)

    def chunks(self, blocks: Iterator[tuple[list[str], int]]) -> Iterator[Chunk]:
        """Columns of cells, and the lines on which they stand."""
        first, final = self.used
        for block, number in blocks:
            skipped = max(first - number, 0)
            if kept := block[skipped : max(final - number + 1, 0)]:
                yield self._chunk(kept, number + skipped)

    def _chunk(self, block: list[str], number: int) -> Chunk:
        """Cells by column, of the lines that have as many as the headings, and the numbers of those lines."""
        joined = self.separator.join(block)
        counts = set(map(methodcaller("count", self.separator), block))
        whole = counts == {self.width - 1} and min(map(len, block)) >= self.width and self.separator != " "
        if whole and '"' not in joined:
            flat = joined.split(self.separator)
            columns: list[Sequence[str]] = [flat[index :: self.width] for index in range(self.width)]
            return columns, np.arange(number, number + len(block), dtype=np.int64)
        kept = [(row, at) for at, line in enumerate(block, start=number) if (row := self._judged(line, at))]
        columns = list(zip(*(row for row, _ in kept), strict=True)) or [()] * self.width
        return columns, np.array([at for _, at in kept], dtype=np.int64)

    def _judged(self, line: str, number: int) -> list[str]:
        if not line.strip():
            self.log.fault(number, "an empty line", "a reading a line")
            return []
        cells = self._cells(line, number)
        if len(cells) > self.width and not any(cell.strip() for cell in cells[self.width :]):
            self.log.note("empty columns on the right were left out")
            cells = cells[: self.width]
        if len(cells) > 1 and not any(cell.strip() for cell in cells):
            self.log.note("lines of empty cells were left out")
            return []
        if len(cells) == self.width or not cells:
            return cells
        fix = ""
        if len(cells) > self.width and self.separator == ",":
            fix = "the decimal mark is a point; commas separate cells"
        fix = fix or ("the file may be cut short" if number == self.last else "")
        self.log.fault(number, f"{len(cells)} cells in {quoted(line)}", f"{self.width}, as in the heading", fix)
        return []

    def _cells(self, line: str, number: int) -> list[str]:
        """Cells of one line; none where its quotation marks do not match."""
        if self.separator == " ":
            return split(line, " ")
        try:
            return next(csv.reader([line], delimiter=self.separator, strict=True), [])
        except csv.Error:
            got = f"{quoted(line)}, with an unmatched quotation mark"
            self.log.fault(number, got, f"cells separated by {_NAMES[self.separator]}s")
            return []
