"""The cells of one column to numbers or words: strict, quick where all are plain, every fault with its line."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from fractions import Fraction
from math import nan
from unicodedata import normalize

import numpy as np

from metrology import units
from metrology.declaration.columns import Column, Floats, Integers
from metrology.declaration.entry import mean
from metrology.message import said
from metrology.readings.headings import same, shown
from metrology.readings.sheet import Cells, Log
from metrology.units.dimensions import quoted

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_GROUPED = re.compile(r"[+-]?\d{1,3}(,\d{3})+(\.\d*)?", re.ASCII)
_CLOCK = re.compile(
    r"(?:(?P<day>\d{4}-\d\d-\d\d|\d\d?\.\d\d?\.\d{4})[T ])?(?P<h>\d\d?):(?P<m>[0-5]\d):(?P<s>[0-5]\d(?:[.,]\d{1,18})?)",
    re.ASCII,
)


@dataclass(frozen=True)
class Held:
    """A column of the file that was asked for: its position, heading, unit, and what its words stand for."""

    column: Column
    index: int
    heading: str
    unit: units.Unit | None
    words: Mapping[str, str]
    clock: bool = False


class Reader:
    """Reads cells of one table; `decimal` is the decimal mark of those that are texts."""

    def __init__(self, log: Log, decimal: str) -> None:
        self.log, self.decimal = log, decimal
        self.day: int | None = None

    def convert(self, item: Held, cells: Cells, where: Integers) -> Floats:
        """Numbers of a column as written; the quick way where Python's own reading is as strict as ours."""
        if isinstance(cells, np.ndarray):
            return self._judged(item, np.asarray(cells, dtype=np.float64), where)
        if item.clock:
            return self._clock(item, cells, where)
        together = "".join(cells)
        if together.isascii() and "_" not in together and not (self.decimal == "," and "." in together):
            try:
                values = np.array(
                    [float(one.replace(",", ".")) for one in cells] if self.decimal == "," else list(map(float, cells))
                )
            except ValueError:
                pass
            else:
                if (np.abs(values) <= units.LARGEST).all():
                    return values.astype(np.float64)
        return np.array(
            [self._number(item, cell, int(at)) for cell, at in zip(cells, where, strict=True)], dtype=np.float64
        )

    def _judged(self, item: Held, values: Floats, where: Integers) -> Floats:
        """Numbers of a file that has them as numbers: finite, or gaps where gaps are allowed."""
        allowed = np.abs(values) <= units.LARGEST
        if item.column.gaps:
            allowed |= np.isnan(values)
        for row in np.flatnonzero(~allowed):
            cause = "a gap" if np.isnan(values[row]) else "large"
            got, expected = f"'{values[row]:g}'", f"a number up to {units.LARGEST:g}"
            self.log.fault(int(where[row]), got, expected, column=item.heading, cause=cause)
        return values

    def _number(self, item: Held, cell: str, line: int) -> float:
        text = cell.strip()
        if item.column.gaps and (not text or text.casefold() == "nan"):
            if text:
                self.log.note(said("'{text}' under '{heading}' was read as a gap", text=text, heading=item.heading))
            return nan
        plain = text.replace(",", ".") if self.decimal == "," and "." not in text else text
        plain = plain.replace("−", "-")
        if _NUMBER.fullmatch(plain) and (self.decimal == "." or "." not in text):
            if abs(value := float(plain)) <= units.LARGEST:
                return value
            got, expected = quoted(text), f"a number up to {units.LARGEST:g}, as instruments read"
            self.log.fault(line, got, expected, column=item.heading, cause="large")
            return nan
        got, fix = quoted(text) if text else "an empty cell", ""
        if self.decimal == "," and "." in text:
            fix = "the decimal mark is a comma, and nothing groups the digits"
        elif _GROUPED.fullmatch(text):
            fix = "the decimal mark is a point, and nothing groups the digits: take the commas out of the file"
            if "." not in text:
                fix += "; where the comma is the decimal mark, state 'decimal: comma'"
        elif "," in text:
            fix = "the decimal mark is a point, unless 'decimal: comma' is stated"
        expected = f"a number, such as '12{self.decimal}34'"
        self.log.fault(line, got, expected, fix, column=item.heading, cause=fix or got)
        return nan

    def _clock(self, item: Held, cells: Sequence[str], where: Integers) -> Floats:
        """Seconds since midnight of the first day, from times of day with or without a date."""
        found = [_moment(cell) for cell in cells]
        wrong = next((at for at, moment in enumerate(found) if moment is None), None)
        if wrong is not None:
            got = f"{quoted(cells[wrong])} under {quoted(item.heading)}, which has no unit"
            self.log.fault(int(where[wrong]), got, f"a time, such as '{shown(item.column)}' above the numbers")
            return np.full(len(cells), nan)
        self.log.note(
            said("'{heading}' holds times of day, which count in seconds from the first of them", heading=item.heading)
        )
        return np.array([self._seconds(*moment) for moment in found if moment is not None])

    def _seconds(self, day: int, seconds: Fraction) -> float:
        """Seconds since midnight of the first day; of that day alone, as a float holds no microsecond of 2000 years."""
        self.day = day if self.day is None else self.day
        return float(86400 * (day - self.day) + seconds)

    def words(self, item: Held, cells: Cells, where: Integers) -> list[str]:
        """Words of a column, each as it stands for another where that is stated, and one of those allowed."""
        texts = [normalize("NFC", cell.strip()) if isinstance(cell, str) else f"{cell:.12g}" for cell in cells]
        words = [item.words.get(text, text) for text in texts]
        allowed = item.column.choices
        for at, (word, line) in enumerate(zip(words, where, strict=True)):
            if not word:
                self.log.fault(int(line), "an empty cell", "a text", column=item.heading)
            elif allowed and word not in allowed:
                near = next((choice for choice in allowed if same(choice, word)), None)
                if near is not None:
                    self.log.note(said("'{word}' was read as '{near}'", word=word, near=near))
                    words[at] = near
                    continue
                expected = f"one of {', '.join(allowed)}"
                self.log.fault(int(line), quoted(word), expected, mean(word, list(allowed)), column=item.heading)
        return words

    def judge(self, item: Held, values: Floats, rows: Integers) -> None:
        """Note what is wrong with a column as a whole: gaps alone, a dead channel, stamps that do not increase."""
        if np.isnan(values).all():
            self.log.fault(int(rows[0]), "gaps alone", "at least one reading", column=item.heading)
        elif item.column.varies and len(values) > 1 and np.nanmin(values) == np.nanmax(values):
            got = f"the same reading, {np.nanmin(values):g}, on every line"
            self.log.fault(int(rows[0]), got, "readings that vary", "the channel may be dead", column=item.heading)
        if item.column.increasing:
            for row in np.flatnonzero(np.diff(values) <= 0) + 1:
                before, now = values[row - 1], values[row]
                got = f"the time stamp {now:.15g} a second time" if now == before else f"{now:.15g} after {before:.15g}"
                fix = "'rows: [first, last]' in the campaign file says which lines are used"
                if (np.diff(values) < 0).all():
                    fix = "every line is earlier than the one before it: sort the lines by time"
                self.log.fault(
                    int(rows[row]), got, "time stamps that increase", fix, column=item.heading, cause="before"
                )


def _moment(cell: str) -> tuple[int, Fraction] | None:
    """Day, 0 where there is none, and seconds of it; None for what is no time of day, and for a day that is none."""
    match = _CLOCK.fullmatch(cell.strip())
    if match is None:
        return None
    day = match["day"]
    try:
        pattern = "%Y-%m-%d" if day and "-" in day else "%d.%m.%Y"
        days = datetime.strptime(day, pattern).toordinal() if day else 0
    except ValueError:
        return None
    return days, 3600 * int(match["h"]) + 60 * int(match["m"]) + Fraction(match["s"].replace(",", "."))
