"""Text with cells: CSV of any dialect."""

from __future__ import annotations

import codecs
import csv
from collections.abc import Iterator, Sequence
from operator import methodcaller

import numpy as np

from metrology.errors import MetrologyError
from metrology.message import said
from metrology.readings import lines
from metrology.readings.layout import NAMES, Layout, find_layout, split
from metrology.readings.sheet import Chunk, Heading, Job, Sheet, refused
from metrology.units.dimensions import quoted

_MARKS = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
_WESTERN = frozenset("äöüÄÖÜßéèêëàâçñåøæÅØÆôîï°µ²³±·×–“”„’Øœ§€ÉÀ")
"""What a text in Windows-1252 of a laboratory may hold beyond ASCII; other bytes are another encoding, or no text."""


def read(job: Job) -> Sheet:
    """Return the table that a text holds."""
    text = decoded(job)
    stop = lines.end(text)
    last = text.count("\n", 0, stop) + 1
    if not text.endswith("\n"):
        job.log.note(said("the last line has no line end: the file may be cut short"))
    layout = find_layout(job, text, stop)
    start = _offset(text, layout.first, stop)
    blocks = lines.blocks(job.path, text, (start, stop), layout.first) if layout.first <= last else iter(())
    chunks = _Rows(job, layout, last).chunks(blocks)
    return Sheet(
        layout.headings, chunks, layout.line, layout.decimal, separator=layout.separator, doubtful=layout.doubtful
    )


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
    text = _characters(job, job.content).replace("\r\n", "\n")
    for character, name in (("\0", "a null character"), ("\r", "a carriage return without a line feed")):
        if character in text:
            raise refused(job.log.at(text.count("\n", 0, text.index(character)) + 1), name, "lines of plain text")
    if not text or text.isspace():
        raise refused(job.log.where, "an empty file", "a heading line and readings")
    return text


def _characters(job: Job, raw: bytes) -> str:
    mark = next((mark for mark in _MARKS if raw.startswith(mark)), b"")
    if mark:
        job.log.note(said("it begins with a byte order mark ({mark})", mark=_MARKS[mark].upper()))
    encoding = job.stated.encoding or _MARKS.get(mark, "utf-8")
    try:
        return raw[len(mark) :].decode(encoding)
    except LookupError:
        raise _strange(job, encoding) from None
    except UnicodeDecodeError as error:
        text = raw.decode("cp1252", "replace") if not job.stated.encoding and not mark else ""
        if text and {letter for letter in text if not letter.isascii()} <= _WESTERN:
            job.log.note(said("it was read as Windows-1252, as it is not UTF-8; state 'encoding: cp1252'"))
            return text
        where = job.log.at(raw.count(10, 0, error.start + len(mark)) + 1)
        expected = f"text in {encoding.upper()}"
        fix = "save the file as UTF-8, or state its 'encoding' in the campaign file"
        byte = raw[error.start + len(mark) :][:1].hex()
        raise refused(where, f"byte 0x{byte}", expected, fix) from None
    except UnicodeError:  # a codec that is no encoding of texts, such as 'undefined' or 'punycode'
        raise _strange(job, encoding) from None


def _strange(job: Job, encoding: str) -> MetrologyError:
    return refused(job.log.where, f"the encoding '{encoding}'", "one such as 'utf-8' or 'cp1252'")


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
        self.headings = [heading.text for heading in layout.headings]

    def chunks(self, blocks: Iterator[tuple[list[str], int]]) -> Iterator[Chunk]:
        """Columns of cells, and the lines on which they stand."""
        first, final = self.used
        for block, number in blocks:
            skipped = max(first - number, 0)
            if kept := block[skipped : max(final - number + 1, 0)]:
                yield self._chunk(kept, number + skipped)

    def _chunk(self, block: list[str], number: int) -> Chunk:
        """Cells by column, of the lines that have as many as the headings, and the numbers of those lines."""
        self._refuse_headings(block, number)
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

    def _refuse_headings(self, block: list[str], number: int) -> None:
        """Refuse headings that come again: below them stands another record."""
        first = self.headings[0]
        for at, line in enumerate(block, start=number) if first else ():
            if line.startswith(first) and [cell.strip() for cell in split(line, self.separator)] == self.headings:
                got, fix = "the headings again, of another block of readings", "state the lines: 'rows: [first, last]'"
                raise refused(self.log.at(at), got, "one block of readings", fix)

    def _judged(self, line: str, number: int) -> list[str]:
        if not line.strip():
            self.log.fault(number, "an empty line", "a reading a line", cause="empty")
            return []
        cells = self._cells(line, number)
        if len(cells) > self.width and not any(cell.strip() for cell in cells[self.width :]):
            self.log.note(said("empty columns on the right were left out"))
            cells = cells[: self.width]
        if len(cells) > 1 and not any(cell.strip() for cell in cells):
            self.log.note(said("lines of empty cells were left out"))
            return []
        if len(cells) == self.width or not cells:
            return cells
        fix = ""
        if len(cells) > self.width and self.separator == ",":
            fix = "the decimal mark is a point; commas separate cells"
            if self.width == 1:
                fix += ", unless 'separator: semicolon' and 'decimal: comma' are stated"
        fix = fix or ("the file may be cut short" if number == self.last else "")
        got = f"{len(cells)} cell{'' if len(cells) == 1 else 's'} in {quoted(line)}"
        expected = f"{self.width}, as in the heading"
        self.log.fault(number, got, expected, fix, cause=f"{len(cells)} cells{fix}")
        return []

    def _cells(self, line: str, number: int) -> list[str]:
        """Cells of one line; none where its quotation marks do not match."""
        if self.separator == " ":
            return split(line, " ")
        try:
            return next(csv.reader([line], delimiter=self.separator, strict=True), [])
        except csv.Error:
            got = f"{quoted(line)}, with an unmatched quotation mark"
            self.log.fault(number, got, f"cells separated by {NAMES[self.separator]}s")
            return []
