"""The unit of a column: from its heading, from what the file says of itself, or as the campaign file states it."""

from __future__ import annotations

from metrology import units
from metrology.declaration.columns import Column
from metrology.declaration.readings import ColumnOf
from metrology.message import said
from metrology.readings.headings import is_unit, same_unit, shown, spelled, take_apart, tidy
from metrology.readings.sheet import Heading, Log, Sheet
from metrology.units.dimensions import TextError, quoted


def unit_of(
    log: Log, column: Column, heading: Heading, stated: ColumnOf | None, sheet: Sheet
) -> tuple[units.Unit | None, bool]:
    """Unit of a column, from its heading, the file's metadata or the campaign file; whether it may be a clock."""
    text = _unit_text(log, column, heading, stated, sheet)
    clock = column.increasing and text == "1"
    try:
        unit = units.unit(text)
    except TextError as error:
        log.fault(sheet.line, error.got, error.expected, error.fix, column=heading.text)
        return None, False
    due_unit = column.unit or take_apart(column.name).unit or "1"
    if is_unit(due_unit) and unit.dimension != units.dimension(due_unit) and not clock:
        due = units.unit(due_unit).name
        got = f"{quoted(tidy(heading.text))}, {'without a unit' if unit.text == '1' else unit.name}"
        fix = "" if stated is None else "state it: '{column: …, unit: …}'"
        log.fault(sheet.line, got, f"{due}, such as '{shown(column)}'", fix)
    return unit, clock


def _unit_text(log: Log, column: Column, heading: Heading, stated: ColumnOf | None, sheet: Sheet) -> str:
    of_file = [one for one in (take_apart(heading.text).unit, spelled(heading.unit)) if one not in ("", "-", "–")]
    given = stated.unit if stated else None
    for first, second in zip(of_file, of_file[1:] + [given] * bool(given and of_file), strict=False):
        if second is not None and not same_unit(first, second):
            got = f"the unit '{second}' stated" if second is given else f"the unit '{second}' in its metadata"
            log.fault(sheet.line, got, f"'{first}', as the file has it", column=heading.text)
    text = given or (of_file[0] if of_file else "1")
    if text == "g" and units.dimension(column.unit or "1") == units.dimension("m/s^2"):
        log.note(
            said(
                "the unit 'g' of '{heading}' was read as gn, the standard acceleration of free fall",
                heading=heading.text,
            )
        )
        return "gn"
    return text
