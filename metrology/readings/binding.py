"""The columns that are due, out of a table as the file has it: found, in SI, and judged; every fault with its line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from metrology import units
from metrology.declaration.columns import Column, Floats, Integers, SourceFile, Table
from metrology.declaration.entry import mean
from metrology.declaration.readings import ColumnOf, Readings
from metrology.message import said
from metrology.readings.cells import Held, Reader
from metrology.readings.column_unit import unit_of
from metrology.readings.headings import find, matching, nearest, shown, take_apart, tidy
from metrology.readings.sheet import (
    Cells,
    Heading,
    Log,
    Sampled,
    Sheet,
    refuse_doubtful,
    refused,
    sampling,
)
from metrology.units.dimensions import quoted

MAX_ROWS = 4_000_000
MAX_TEXT_ROWS = 200_000


def count(columns: Sequence[Column], stated: Readings, headings: Sequence[Heading]) -> int:
    """How many of the columns are among headings."""
    return sum(find(column, _stated(column, stated), headings) is not None for column in columns)


def _stated(column: Column, stated: Readings) -> ColumnOf | None:
    return next((one for name, one in stated.stated.items() if tidy(name) == tidy(column.name)), None)


class Binder:
    """Finds the columns that are due in one table and reads them."""

    def __init__(self, columns: Sequence[Column], stated: Readings, log: Log, *, others: bool) -> None:
        self.columns, self.stated, self.log = columns, stated, log
        self.others = others or stated.columns is not None
        self.cells = Reader(log, ".")
        self.sampled: Sampled | None = None

    def read(self, sheet: Sheet, path: Path, source: SourceFile) -> Table:
        """Return the table in SI."""
        self.cells = Reader(self.log, sheet.decimal)
        refuse_doubtful(self.log, sheet)
        self._strange_keys()
        held, made = self._headings(sheet)
        self.log.stop()
        numbers, texts, rows = self._rows(sheet, held)
        if not self.log.faults and not len(rows):
            between = f" from line {self.stated.rows[0]} to {self.stated.rows[1]}" if self.stated.rows else ""
            self.log.fault(sheet.line, f"no readings below the heading{between}", "a line a reading")
        self.log.stop()
        if made is not None:
            numbers[made.column.name] = self._stamps(len(rows))
        held = sorted([*held, made] if made else held, key=lambda item: self.columns.index(item.column))
        return replace(self._table(held, (numbers, texts), rows, path, source), date=sheet.date)

    # -- headings

    def _strange_keys(self) -> None:
        known = [tidy(column.name) for column in self.columns]
        for name in self.stated.stated:
            if tidy(name) not in known:
                expected = f"one of {', '.join(known)}"
                self.log.fault(0, f"the column {quoted(name)} stated for it", expected, mean(name, known))

    def _headings(self, sheet: Sheet) -> tuple[list[Held], Held | None]:
        """Columns that were found, and the time stamps where they are to be made."""
        found = {column: find(column, _stated(column, self.stated), sheet.headings) for column in self.columns}
        self._refuse_twice(sheet, [place[0] for place in found.values() if place])
        self._refuse_rivals(sheet)
        missing = [column for column, place in found.items() if place is None and column.required]
        stamps = next((column for column in missing if column.increasing and column.unit == "s"), None)
        used = [sheet.headings[place[0]] for place in found.values() if place]
        made = self._made(stamps, used) if stamps else None
        if made:
            missing.remove(made.column)
        strangers = self._strangers(sheet, {place[0] for place in found.values() if place})
        self._tell_missing(sheet, missing, strangers)
        held = [self._hold(column, *place, sheet) for column, place in found.items() if place]
        if self.stated.time and not made:
            self.log.fault(sheet.line, "'time' stated, and a column with time stamps", "one of the two")
        return held, made

    def _refuse_twice(self, sheet: Sheet, used: Sequence[int]) -> None:
        headings = [tidy(heading.text) for heading in sheet.headings]
        for index, heading in enumerate(headings):
            if (
                heading
                and heading in headings[:index]
                and (not self.others or {index, headings.index(heading)} & set(used))
            ):
                if (stated := [one for one in self.stated.stated.values() if one.column.isdecimal()]) and len(stated):
                    continue
                fix = "number the columns: 'columns: {load: 1, …}'" if self.stated.columns else ""
                self.log.fault(sheet.line, f"the heading {quoted(heading)} a second time", "every heading once", fix)

    def _refuse_rivals(self, sheet: Sheet) -> None:
        """Refuse a column for which several headings stand, such as one in mm and one in um: either may be meant."""
        for column in self.columns:
            stated = _stated(column, self.stated)
            found = {tidy(sheet.headings[at].text): at for at in matching(column, stated, sheet.headings)}
            if self.others and len(found) > 1:
                named = " and ".join(quoted(heading) for heading in found)
                first, at = next(iter(found.items()))
                fix = f"state which: 'columns: {{{column.name}: \"{first}\", …}}', or its number, {at + 1}"
                self.log.fault(sheet.line, f"{named} for '{column.name}'", "one heading that fits", fix)

    def _made(self, column: Column, used: Sequence[Heading]) -> Held | None:
        """Time stamps that are to be made, for the columns that are used and no others."""
        self.sampled, other = sampling(used)
        if self.stated.time is None and self.sampled is None:
            return None
        if other is not None:
            first = next(one for one in used if one.sampled is not None)
            got = f"'{first.text}' with {first.sampled}, and '{other.text}' with {other.sampled}"
            fix = "read each by an entry of its own, or give the file a column of time stamps"
            self.log.fault(0, got, "columns that were sampled at the same times", fix)
        elif self.sampled and (silent := [one.text for one in used if one.sampled is None]):
            self.log.note(
                said(
                    "the file does not say when '{name}' was sampled: with the others, on the same rows", name=silent[0]
                )
            )
        self._compare_rates()
        return Held(column, -1, column.name, units.unit("s"), {})

    def _compare_rates(self) -> None:
        if self.stated.time is None or self.sampled is None:
            return
        step, of_file = _step(self.stated), self.sampled.step
        if abs(step - of_file) > of_file / 10**6:
            got = f"a step of {float(step):g} s stated, and {float(of_file):g} s in the file"
            self.log.fault(0, got, "the same time between two samples", "remove 'time', or find out which is right")

    def _strangers(self, sheet: Sheet, known: set[int]) -> list[str]:
        if self.others:
            return []
        headings = [tidy(heading.text) for heading in sheet.headings]
        return [one for index, one in enumerate(headings) if index not in known and one not in headings[:index]]

    def _tell_missing(self, sheet: Sheet, missing: Sequence[Column], strangers: Sequence[str]) -> None:
        """Tell each wrong heading once: one that is probably meant for a missing column is named with it."""
        left, listed = list(strangers), False
        for column in missing:
            stated = _stated(column, self.stated)
            near = nearest(stated.column if stated else column.name, left)
            if near is not None:
                left.remove(near)
                self.log.fault(sheet.line, f"{quoted(near)}, an unknown column", f"the heading '{shown(column)}'")
                continue
            listed = True
            had = ", ".join(f"'{heading.text}'" for heading in sheet.headings[:12])
            fix = f"the file has {had}; 'columns' in the campaign file says which is which" if had else ""
            name = stated.column if stated else tidy(column.name)
            self.log.fault(sheet.line, f"no column {quoted(name)}", f"the heading '{shown(column)}'", fix)
        for heading in [] if listed else left:
            expected = ", ".join(f"'{shown(column)}'" for column in self.columns)
            got = f"{quoted(heading)}, an unknown column" if heading else "a column without a heading"
            near = mean(take_apart(heading).name, [take_apart(tidy(column.name)).name for column in self.columns])
            self.log.fault(sheet.line, got, f"one of {expected}", near)

    def _hold(self, column: Column, index: int, exact: bool, sheet: Sheet) -> Held:
        heading, stated = sheet.headings[index], _stated(column, self.stated)
        words = dict(stated.words) if stated and stated.words else {}
        if column.kind == "text":
            if not exact:
                self.log.note(said("'{word}' was read as '{near}'", word=heading.text, near=shown(column)))
            return Held(column, index, heading.text, None, words)
        unit, clock = unit_of(self.log, column, heading, stated, sheet)
        if not exact or (not stated and not take_apart(heading.text).usual):
            self.log.note(said("'{word}' was read as '{near}'", word=heading.text, near=shown(column)))
        return Held(column, index, tidy(heading.text), unit, words, clock)

    # -- rows

    def _rows(
        self, sheet: Sheet, held: Sequence[Held]
    ) -> tuple[dict[str, Floats], dict[str, tuple[str, ...]], Integers]:
        numbers: dict[str, list[Floats]] = {item.column.name: [] for item in held if item.unit is not None}
        texts: dict[str, list[str]] = {item.column.name: [] for item in held if item.unit is None}
        limit = MAX_TEXT_ROWS if texts else MAX_ROWS
        stood: list[Integers] = []
        for cells, lines in sheet.chunks:
            kept, where = self._cut(cells, lines)
            stood.append(where)
            if sum(map(len, stood)) > limit:
                fix = "lower the rate: keep every n-th sample of a record that was filtered before, or split the test"
                raise refused(self.log.where, f"more than {limit} lines of readings", f"at most {limit}", fix)
            for item in held:
                if item.unit is not None:
                    numbers[item.column.name].append(self.cells.convert(item, kept[item.index], where))
                else:
                    texts[item.column.name].extend(self.cells.words(item, kept[item.index], where))
        rows = np.concatenate(stood) if stood else np.zeros(0, dtype=np.int64)
        joined = {name: np.concatenate(parts) if parts else np.zeros(0) for name, parts in numbers.items()}
        return joined, {name: tuple(words) for name, words in texts.items()}, rows

    def _cut(self, cells: Sequence[Cells], lines: Integers) -> tuple[Sequence[Cells], Integers]:
        """The rows from the first line to the last that are used."""
        if self.stated.rows is None:
            return cells, lines
        first, after = np.searchsorted(lines, (self.stated.rows[0], self.stated.rows[1] + 1))
        return [column[first:after] for column in cells], lines[first:after]

    def _stamps(self, count: int) -> Floats:
        """Time stamps of a file that has none: the quotient of whole numbers, as a person writes 0.015 s."""
        stated = self.stated.time
        if stated is not None:
            made = Sampled(_step(self.stated), Fraction(repr(stated.start.si)))
        else:
            assert self.sampled is not None
            made = self.sampled
        step, start = made.step, made.start
        scale = step.denominator * start.denominator
        first, more = int(start * scale), int(step * scale)
        return (first + more * np.arange(count, dtype=np.float64)) / scale

    # -- the table

    def _table(
        self,
        held: Sequence[Held],
        cells: tuple[dict[str, Floats], dict[str, tuple[str, ...]]],
        rows: Integers,
        path: Path,
        source: SourceFile,
    ) -> Table:
        numbers, written = {}, {}
        for item in held:
            if item.unit is not None:
                values = cells[0][item.column.name]
                if item.clock:
                    values = values - values[0]
                unit = units.unit("s") if item.clock else item.unit
                self.cells.judge(item, values, rows)
                numbers[item.column.name], written[item.column.name] = _frozen(_si(values, unit)), unit.text
        self.log.stop()
        return Table(
            path,
            MappingProxyType(numbers),
            MappingProxyType(cells[1]),
            MappingProxyType(written),
            _frozen(rows),
            source,
            self.stated.part,
            tuple(self.log.notices),
        )


def _step(stated: Readings) -> Fraction:
    """Time between two samples / s, exactly as it is written."""
    assert stated.time is not None
    quantity = stated.time.rate or stated.time.step
    assert quantity is not None
    exact = Fraction(repr(quantity.si))
    return 1 / exact if stated.time.rate else exact


def _si(values: Floats, unit: units.Unit) -> Floats:
    """Values in SI; divided where the factor is a fraction, so that 0.01 mm is 1e-05 m as a person writes it."""
    scaled = values * float(unit.factor.numerator) / float(unit.factor.denominator)
    return scaled + float(unit.offset) if unit.offset else scaled


def _frozen(values: Any) -> Any:
    values.flags.writeable = False
    return values
