"""Headings of columns: name and unit in every way in which laboratories write them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

from metrology import units
from metrology.declaration.columns import Column
from metrology.declaration.readings import ColumnOf
from metrology.readings.sheet import Heading
from metrology.units.dimensions import TextError

_BRACKETS = re.compile(r"(?P<name>.*\S)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\)|<(?P<angle>[^<>]*)>)\s*")
_WORD_IN = re.compile(r"(?P<name>.*\S)\s+in\s+(?P<unit>\S+)")
_RUN = re.compile(
    r"(?P<heading>.*[\])>])\s*(?P<run>(?:run|set|trial|lauf|messung|versuch|essai|série|prova|serie|ensayo)\s*#?\s*\d+)",
    re.IGNORECASE,
)
"""A heading that numbers its run behind the unit, as PASCO Capstone writes it: ``Position (m) Run #1``."""


@dataclass(frozen=True)
class Written:
    """A heading taken apart; `usual` where it is written as the documentation has it, ``name / unit``."""

    name: str
    unit: str
    usual: bool


def tidy(heading: str) -> str:
    """A heading with one space around its first solidus: ``reading / mm``."""
    name, solidus, unit = heading.partition("/")
    return f"{name.strip()} / {unit.strip()}" if solidus else name.strip()


def take_apart(text: str) -> Written:
    """Name and unit of a heading: ``name / unit``, ``name [unit]``, ``name (unit)``, ``name in unit``.

    Examples
    --------
    >>> take_apart("Kraft [N]"), take_apart("Weg in mm").unit
    (Written(name='Kraft', unit='N', usual=False), 'mm')
    >>> take_apart("x (filtered)").name
    'x (filtered)'
    >>> take_apart("Time (s) Run #1")
    Written(name='Time Run #1', unit='s', usual=False)
    """
    if numbered := _RUN.fullmatch(text.strip()):
        written = take_apart(numbered["heading"])
        return Written(f"{written.name} {numbered['run']}", written.unit, usual=False) if written.unit else written
    for pattern in (_BRACKETS, _WORD_IN):
        if match := pattern.fullmatch(text.strip()):
            unit = spelled(next((part for part in match.groups()[1:] if part is not None), "").strip())
            if is_unit(unit):
                return Written(match["name"], unit, usual=False)
    name, _, unit = tidy(text).partition(" / ")
    return Written(name, spelled(unit), usual=spelled(unit) == unit)


_SPELLED = {
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "sek": "s", "sekunden": "s", "newton": "N", "newtons": "N",
    "volt": "V", "volts": "V", "degree": "deg", "degrees": "deg", "grad": "deg", "meter": "m", "meters": "m",
    "millimeters": "mm", "millimeter": "mm", "metre": "m", "metres": "m", "millimetre": "mm", "millimetres": "mm",
    "centimeter": "cm", "centimeters": "cm", "centimetre": "cm", "centimetres": "cm", "cms": "cm",
    "gram": "g", "grams": "g", "gramm": "g", "gm": "g", "gms": "g", "kilogram": "kg", "kilograms": "kg", "kgs": "kg",
    "lbs": "lb", "pound": "lb", "pounds": "lb",
    "inches": "in", "inch": "in", "prozent": "%", "percent": "%",
}  # fmt: skip
"""Units in words, as testing machines write them."""


def spelled(unit: str) -> str:
    """The symbol of a unit that is written in words; others as they are."""
    return _SPELLED.get(unit.casefold(), unit)


def is_unit(text: str) -> bool:
    """Whether a text is a unit; an empty one and a dash stand for a number."""
    if text in ("", "-", "–", "1"):
        return True
    try:
        units.unit(text)
    except TextError:
        return False
    return True


def unit_text(cell: str) -> str:
    """A unit as it stands in a cell of its own: ``[mm]``, ``(mm)``, ``mm``."""
    return spelled(cell.strip().strip("[]()<>").strip())


def are_units(cells: Sequence[str]) -> bool:
    """Whether a line below the headings has their units: units alone, and one at least that is no plain number."""
    real = [cell for cell in cells if cell not in ("", "-", "–")]
    return bool(real) and "1" not in real and all(is_unit(cell) for cell in real)


def same(first: str, second: str) -> bool:
    """Whether two texts are alike but for their case and for spaces."""
    return _folded(first) == _folded(second)


def _folded(text: str) -> str:
    return " ".join(unicodedata.normalize("NFKC", text).casefold().replace("_", " ").split())


def find(column: Column, stated: ColumnOf | None, headings: Sequence[Heading]) -> tuple[int, bool] | None:
    """Position of a column among headings, and whether it is written exactly as it is due; None where it is not there.

    A stated column is looked for by its heading as it stands there, then by its name without a unit, then by number.
    """
    if found := matching(column, stated, headings):
        return found[0], stated is not None or _matches(tidy(column.name), headings[found[0]], *_EXACT)
    if stated is not None and stated.column.isdecimal() and 1 <= int(stated.column) <= len(headings):
        return int(stated.column) - 1, True
    return None


def matching(column: Column, stated: ColumnOf | None, headings: Sequence[Heading]) -> list[int]:
    """Positions of all headings that fit a column as well as the best one does: more than one may be meant."""
    wanted = tidy(stated.column if stated else column.name)
    found = ([at for at, one in enumerate(headings) if _matches(wanted, one, how)] for how in (*_EXACT, "roughly"))
    return next((places for places in found if places), [])


_EXACT = ("whole", "name")


def _matches(wanted: str, given: Heading, *ways: str) -> bool:
    """Whether a heading is the wanted one in one of these ways: as a `whole`, by its `name` alone, or `roughly`."""
    heading, plain = given.text, tidy(given.text)
    if "whole" in ways and (wanted == plain or (given.unit != "" and wanted == f"{plain} / {given.unit}")):
        return True
    if "name" in ways and wanted == plain.partition(" / ")[0]:
        return True
    if "roughly" not in ways:
        return False
    written, due = take_apart(heading), take_apart(wanted)
    return (
        same(wanted, heading)
        or same(wanted, written.name)
        or (same(due.name, written.name) and same_unit(due.unit, written.unit or given.unit))
    )


def same_unit(first: str, second: str) -> bool:
    """Whether two texts are one unit."""
    try:
        return units.unit(first or "1").text == units.unit(second or "1").text
    except TextError:
        return first == second


def shown(column: Column) -> str:
    """The heading that a column should have."""
    if column.kind == "text" or "/" in column.name or column.unit in (None, "1"):
        return column.name
    return f"{column.name} / {column.unit}"


def nearest(name: str, headings: Sequence[str]) -> str | None:
    """The heading that is probably meant by a name."""
    names = {take_apart(heading).name: heading for heading in headings}
    from difflib import get_close_matches

    near = get_close_matches(take_apart(name).name.casefold(), [one.casefold() for one in names], n=1)
    return next((heading for one, heading in names.items() if near and one.casefold() == near[0]), None)
