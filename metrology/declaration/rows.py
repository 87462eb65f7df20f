"""The lines of a CSV file to columns in SI; every fault with its line."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import nan
from operator import itemgetter, methodcaller
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from metrology import units
from metrology.declaration import lines
from metrology.declaration.columns import Column, Floats, Integers, SourceFile, Table
from metrology.declaration.entry import mean
from metrology.declaration.lines import refused
from metrology.errors import Fault, MetrologyError
from metrology.units.dimensions import TextError, quoted

MAX_ROWS = 4_000_000
MAX_TEXT_ROWS = 200_000
MAX_COLUMNS = 100
MAX_FAULTS = 20


@dataclass(frozen=True)
class _Held:
    """A column of the file that was asked for: its position, heading, and unit."""

    column: Column
    index: int
    heading: str
    unit: units.Unit | None


class Reader:
    """Reads one text; collects faults until there are too many to be of use."""

    def __init__(self, path: Path, columns: Sequence[Column], *, others: bool) -> None:
        self.path, self.columns, self.others = path, columns, others
        self.faults: list[tuple[int, Fault]] = []
        self.width = 0
        self.last = 0
        self.plain = True

    def read(self, text: str, source: SourceFile) -> Table:
        """Return the table that `text` holds."""
        self._check_end(text)
        stop = lines.end(text)
        start, first = lines.below_notes(self.path, text, stop)
        self.last, self.plain = text.count("\n", 0, stop) + 1, text.isascii() and "_" not in text
        heading = lines.one(self.path, text, start, first)
        held = self._headings(heading, first)
        self._refuse_long(self.last - first, held)
        blocks = lines.blocks(self.path, text, (start + len(heading) + 1, stop), first + 1)
        numbers, texts, rows = self._rows(blocks, held)
        if not self.faults and not len(rows):
            self._fault(first, "no readings below the heading", "a line a reading")
        self._raise()
        return self._table(held, (numbers, texts), rows, source)

    def _refuse_long(self, rows: int, held: Sequence[_Held]) -> None:
        limit = MAX_TEXT_ROWS if any(item.unit is None for item in held) else MAX_ROWS
        if rows > limit:
            mend = "lower the rate: keep every n-th sample of a record that was filtered before, or split the test"
            raise refused(self.path, f"{rows} lines of readings", f"at most {limit}", mend)

    def _fault(self, line: int, got: str, expected: str, mend: str = "", *, column: str = "") -> None:
        where = f"{self.path}:{line} {column}".rstrip()
        self.faults.append((line, Fault(where, got, expected, mend)))
        if len(self.faults) >= MAX_FAULTS:
            self._raise()

    def _raise(self) -> None:
        if self.faults:
            raise MetrologyError(*(fault for _, fault in sorted(self.faults, key=itemgetter(0))))

    def _check_end(self, text: str) -> None:
        last = text[text.rfind("\n") + 1 :]
        if last:
            mend = "if the file is whole, end its last line with a line feed"
            got = f"{quoted(last)} without a line end: the file may be cut short"
            self._fault(text.count("\n") + 1, got, "a whole last line", mend)

    # -- headings

    def _headings(self, line: str, number: int) -> list[_Held]:
        before = len(self.faults)
        headings = [_tidy(cell) for cell in self._cells(line, number)]
        self.width = len(headings)
        if self.width == 1 and ";" in line:
            raise refused(
                f"{self.path}:{number}", "cells separated by semicolons", "commas between cells, points in numbers"
            )
        if self.width > MAX_COLUMNS:
            raise refused(f"{self.path}:{number}", f"{self.width} columns", f"at most {MAX_COLUMNS}")
        for index, heading in enumerate(headings):
            if heading in headings[:index]:
                self._fault(number, f"the heading {quoted(heading)} a second time", "every heading once")
        held = [found for column in self.columns if (found := self._find(column, headings, number))]
        if not self.others:
            self._strangers(headings, {found.index for found in held}, number)
        if len(self.faults) > before:
            self._raise()
        return held

    def _find(self, column: Column, headings: list[str], number: int) -> _Held | None:
        wanted = _tidy(column.name)
        for index, heading in enumerate(headings):
            if wanted in (heading, heading.partition(" / ")[0]):
                return _Held(column, index, heading, self._unit(column, heading, number))
        if column.required:
            near = mean(wanted, headings) or mean(wanted, [heading.partition(" / ")[0] for heading in headings])
            self._fault(number, f"no column {quoted(wanted)}", f"the heading '{_heading(column)}'", near)
        return None

    def _unit(self, column: Column, heading: str, number: int) -> units.Unit | None:
        if column.kind == "text":
            return None
        text = heading.partition(" / ")[2] or "1"
        try:
            unit = units.unit(text)
        except TextError as error:
            self._fault(number, error.got, error.expected, error.mend, column=heading)
            return None
        if column.unit is not None and unit.dimension != units.dimension(column.unit):
            due = units.unit(column.unit).name
            self._fault(number, f"{quoted(heading)}, {unit.name}", f"{due}, such as '{_heading(column)}'")
        return unit

    def _strangers(self, headings: list[str], known: set[int], number: int) -> None:
        for index, heading in enumerate(headings):
            if index not in known and heading not in headings[:index]:
                expected = ", ".join(f"'{_heading(column)}'" for column in self.columns)
                near = mean(heading.partition(" / ")[0], [column.name for column in self.columns])
                self._fault(number, f"{quoted(heading)}, an unknown column", f"one of {expected}", near)

    # -- rows

    def _cells(self, line: str, number: int) -> list[str]:
        """Cells of one line; none where its quotation marks do not match."""
        try:
            return next(csv.reader([line], strict=True), [])
        except csv.Error:
            self._fault(number, f"{quoted(line)}, with an unmatched quotation mark", "cells separated by commas")
            return []

    def _rows(self, blocks: Iterator[tuple[list[str], int]], held: list[_Held]) -> tuple[_Numbers, _Texts, Integers]:
        numbers: _Numbers = {item.column.name: [] for item in held if item.unit is not None}
        texts: _Texts = {item.column.name: [] for item in held if item.unit is None}
        stood = []
        for block, number in blocks:
            cells, where = self._chunk(block, number)
            stood.append(where)
            for item in held:
                if item.unit is not None:
                    numbers[item.column.name].append(self._convert(item, cells[item.index], where))
                else:
                    texts[item.column.name].extend(self._words(item, cells[item.index], where))
        return numbers, texts, np.concatenate(stood) if stood else np.zeros(0, dtype=np.int64)

    def _chunk(self, block: list[str], number: int) -> tuple[list[Sequence[str]], Integers]:
        """Cells by column, of the lines that have as many as the heading, and the numbers of those lines."""
        joined = ",".join(block)
        commas = set(map(methodcaller("count", ","), block))
        if commas == {self.width - 1} and '"' not in joined and all(block):
            flat = joined.split(",")
            columns: list[Sequence[str]] = [flat[index :: self.width] for index in range(self.width)]
            return columns, np.arange(number, number + len(block), dtype=np.int64)
        kept = [(row, at) for at, line in enumerate(block, start=number) if (row := self._judged(line, at))]
        columns = list(zip(*(row for row, _ in kept), strict=True)) or [()] * self.width
        return columns, np.array([at for _, at in kept], dtype=np.int64)

    def _judged(self, line: str, number: int) -> list[str]:
        if not line.strip():
            self._fault(number, "an empty line", "a reading a line")
            return []
        cells = self._cells(line, number)
        if len(cells) == self.width or not cells:
            return cells
        mend = "the decimal mark is a point; commas separate cells" if len(cells) > self.width else ""
        mend = mend or ("the file may be cut short" if number == self.last else "")
        self._fault(number, f"{len(cells)} cells in {quoted(line)}", f"{self.width}, as in the heading", mend)
        return []

    def _convert(self, item: _Held, cells: Sequence[str], where: Integers) -> Floats:
        """Numbers of a column as written; the quick way where Python's own reading is as strict as ours."""
        if self.plain:
            try:
                values = np.array(list(map(float, cells)), dtype=np.float64)
            except ValueError:
                pass
            else:
                if (np.abs(values) <= LARGEST).all():
                    return values
        return np.array(
            [self._number(item, cell, int(at)) for cell, at in zip(cells, where, strict=True)], dtype=np.float64
        )

    def _number(self, item: _Held, cell: str, line: int) -> float:
        text = cell.strip()
        if not text and item.column.gaps:
            return nan
        if _NUMBER.fullmatch(text):
            if abs(value := float(text)) <= LARGEST:
                return value
            self._fault(line, quoted(text), f"a number up to {LARGEST:g}, as instruments read", column=item.heading)
            return nan
        got, mend = quoted(text), ""
        if not text:
            got = "an empty cell"
        elif "," in text:
            mend = "the decimal mark is a point"
        self._fault(line, got, "a number, such as '12.34'", mend, column=item.heading)
        return nan

    def _words(self, item: _Held, cells: Sequence[str], where: Integers) -> list[str]:
        words = [cell.strip() for cell in cells]
        allowed = item.column.choices
        for word, line in zip(words, where, strict=True):
            if not word:
                self._fault(int(line), "an empty cell", "a text", column=item.heading)
            elif allowed and word not in allowed:
                expected = f"one of {', '.join(allowed)}"
                self._fault(int(line), quoted(word), expected, mean(word, list(allowed)), column=item.heading)
        return words

    # -- the table

    def _table(self, held: list[_Held], cells: tuple[_Numbers, _Texts], rows: Integers, source: SourceFile) -> Table:
        numbers = {}
        for item in held:
            if item.unit is not None:
                values = np.concatenate(cells[0][item.column.name])
                self._judge_series(item, values, rows)
                numbers[item.column.name] = _frozen(_si(values, item.unit))
        self._raise()
        texts = {name: tuple(words) for name, words in cells[1].items()}
        written = {item.column.name: item.unit.text for item in held if item.unit is not None}
        return Table(
            self.path,
            MappingProxyType(numbers),
            MappingProxyType(texts),
            MappingProxyType(written),
            _frozen(rows),
            source,
        )

    def _judge_series(self, item: _Held, values: Floats, rows: Integers) -> None:
        if np.isnan(values).all():
            self._fault(int(rows[0]), "gaps alone", "at least one reading", column=item.heading)
        elif item.column.varies and len(values) > 1 and np.nanmin(values) == np.nanmax(values):
            got = f"the same reading, {np.nanmin(values):g}, on every line"
            self._fault(int(rows[0]), got, "readings that vary", "the channel may be dead", column=item.heading)
        if item.column.increasing:
            for row in np.flatnonzero(np.diff(values) <= 0)[:MAX_FAULTS] + 1:
                before, now = values[row - 1], values[row]
                got = f"the time stamp {now:.15g} a second time" if now == before else f"{now:.15g} after {before:.15g}"
                self._fault(int(rows[row]), got, "time stamps that increase", column=item.heading)


_Numbers = dict[str, list[Floats]]
_Texts = dict[str, list[str]]
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
LARGEST = 1e75
"""Largest reading: its fourth power, as in fits of the square, is a finite number still."""


def _tidy(heading: str) -> str:
    """A heading with one space around its first solidus: ``reading / mm``."""
    name, solidus, unit = heading.partition("/")
    return f"{name.strip()} / {unit.strip()}" if solidus else name.strip()


def _heading(column: Column) -> str:
    if column.kind == "text" or "/" in column.name or column.unit in (None, "1"):
        return column.name
    return f"{column.name} / {column.unit}"


def _si(values: Floats, unit: units.Unit) -> Floats:
    """Values in SI; divided where the factor is a fraction, so that 0.01 mm is 1e-05 m as a person writes it."""
    scaled = values * float(unit.factor.numerator) / float(unit.factor.denominator)
    return scaled + float(unit.offset) if unit.offset else scaled


def _frozen(values: Any) -> Any:
    values.flags.writeable = False
    return values
