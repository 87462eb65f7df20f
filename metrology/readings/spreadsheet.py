"""Excel workbooks and OpenDocument spreadsheets: numbers as they are stored; formulas and macros are refused."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from io import BytesIO
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from metrology.message import said
from metrology.readings import percent
from metrology.readings.headings import are_units, unit_text
from metrology.readings.percent import column_number, is_named
from metrology.readings.sheet import MAX_VALUES, Chunk, Heading, Job, Sheet, refused
from metrology.readings.tables import check_size, of_rows
from metrology.units.dimensions import quoted

HEADER_ROWS = 300
_TABLE = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"
_CELL = re.compile(rb'\br="([A-Z]{1,3})([0-9]{1,7})"')
Row = tuple[int, list[str]]


def read(job: Job) -> Sheet:
    """Return the table of one sheet: the stated one, or the one that has most of the columns that are due."""
    from python_calamine import CalamineWorkbook

    _refuse_macros(job)
    _refuse_broken(job)
    try:
        book = CalamineWorkbook.from_filelike(BytesIO(job.content))
        names = [name for name in book.sheet_names if job.stated.sheet in (None, name)]
        if not names:
            job.choose("sheet", book.sheet_names, job.stated.sheet)
        _refuse_far_cells(job, names)
        whole = {name: _rows(job, book.get_sheet_by_name(name)) for name in names}
        found = {name: _table(job, rows) for name, rows in whole.items()}
    except (KeyboardInterrupt, SystemExit, MemoryError):
        raise
    except BaseException as error:
        # The library is written in Rust: where it fails it raises an exception that is no `Exception`.
        if isinstance(error, Exception):
            raise
        raise refused(job.log.where, "a workbook that cannot be read", "a whole file", "copy it again") from None
    scores = {name: job.wanted([Heading(cell) for cell in rows[0][1]]) if rows else 0 for name, rows in found.items()}
    best = [name for name in scores if scores[name] == max(scores.values())]
    name = best[0] if max(scores.values()) else job.choose("sheet", book.sheet_names, job.stated.sheet)
    if len(best) > 1 and job.stated.sheet is None:
        job.choose("sheet", best, None)
    if len(book.sheet_names) > 1 and job.stated.sheet is None:
        job.log.note(said("its sheet '{name}' was read", name=name))
    rows = found[name]
    if not rows:
        raise refused(job.log.where, f"the sheet '{name}', which is empty", "a sheet with readings")
    above = tuple("\t".join(filter(None, cells)) for number, cells in whole[name] if number < rows[0][0])
    return replace(_sheet(job, rows, name), above=above)


def _refuse_macros(job: Job) -> None:
    with zipfile.ZipFile(BytesIO(job.content)) as archive:
        if any(name.endswith("vbaProject.bin") or name.startswith("Basic/") for name in archive.namelist()):
            raise refused(job.log.where, "a workbook with macros", "one without", "save it as .xlsx")


def _refuse_broken(job: Job) -> None:
    """Refuse parts that are no XML, at which the reader may not end, and those that declare entities."""
    with zipfile.ZipFile(BytesIO(job.content)) as archive:
        for name in archive.namelist():
            if name != "content.xml" and not (name.startswith("xl/") and name.endswith(".xml")):
                continue
            part = archive.read(name)
            if b"<!DOCTYPE" in part or b"<!ENTITY" in part:
                got = f"a document type in '{name}', which a workbook does not have"
                raise refused(job.log.where, got, "one without", "save it anew")
            try:
                for _, element in ET.iterparse(BytesIO(part)):  # noqa: S314 - no entity is declared
                    element.clear()
            except (ET.ParseError, LookupError, ValueError) as error:
                got = f"a workbook whose part '{name}' is no XML ({error})"
                raise refused(job.log.where, got, "a whole file", "copy it again") from None


def _refuse_far_cells(job: Job, names: Sequence[str]) -> None:
    """Refuse a sheet with a cell so far away that the reader would need all memory for the empty ones before it."""
    with zipfile.ZipFile(BytesIO(job.content)) as archive:
        if "content.xml" in archive.namelist():
            return
        for name in names:
            cells = [
                (column_number(match[1].decode()), int(match[2]))
                for match in _CELL.finditer(archive.read(_part(archive, name)))
            ]
            columns, rows = (max(places, default=0) for places in zip(*cells, strict=True)) if cells else (0, 0)
            if columns * rows > MAX_VALUES:
                got = f"the sheet '{name}', with cells down to row {rows} and out to column {columns}"
                raise refused(job.log.where, got, "a table", "delete what stands far below it or to its right")


def _rows(job: Job, sheet: Any) -> list[Row]:
    check_size(job, sheet.total_height * sheet.total_width, sheet.total_width)
    return list(of_rows(sheet.to_python(skip_empty_area=False)))


def _table(job: Job, rows: list[Row]) -> list[Row]:
    """Rows of a sheet from the line of its headings on."""
    if job.stated.header is not None:
        return [row for row in rows if row[0] > job.stated.header]
    scores = [job.wanted([Heading(cell) for cell in cells]) for _, cells in rows[:HEADER_ROWS]]
    first = scores.index(max(scores)) if scores else 0
    return rows[first:]


def _sheet(job: Job, rows: Sequence[Row], name: str) -> Sheet:
    (line, cells), strange = rows[0], _strange(job, name)
    if line > 1 and job.stated.header is None:
        job.log.note(said("rows 1 to {last} above the headings were passed over", last=line - 1))
    used = [index for index, cell in enumerate(cells) if cell or any(row[index] for _, row in rows[1:])]
    headings, data = [Heading(cells[index]) for index in used], rows[1:]
    below = [unit_text(rows[1][1][index]) for index in used] if len(rows) > 1 else []
    if are_units(below):
        headings = [Heading(one.text, unit) for one, unit in zip(headings, below, strict=True)]
        job.log.note(said("row {row} was read as the units of the headings", row=rows[1][0]))
        data = rows[2:]
    for number, _ in data:
        if number in strange:
            fix = "copy the cells and paste their values" if strange[number].startswith("a formula") else ""
            job.log.fault(number, strange[number], "a reading, which nothing computed", fix)
    headings, data = percent.as_shown(job, headings, data, used, _percents(job, name))
    decimal = "," if job.stated.decimal == "comma" else "."
    return Sheet(headings, _chunks(data, used, comma=decimal == ","), line, ".")


def _chunks(rows: Sequence[Row], used: Sequence[int], *, comma: bool) -> Iterator[Chunk]:
    if not rows:
        return
    lines = np.array([number for number, _ in rows], dtype=np.int64)
    columns = [[cells[index] for _, cells in rows] for index in used]
    yield [[_pointed(cell) for cell in column] if comma else column for column in columns], lines


def _pointed(cell: str) -> str:
    """A number that is stored as text with a decimal comma; stored numbers have none."""
    return cell.replace(",", ".") if re.fullmatch(r"[+-]?\d*,\d+", cell) else cell


# -- formulas and errors


def _strange(job: Job, sheet: str) -> dict[int, str]:
    """First cell with a formula, or with an error in the place of a number, of each row that has one, by its number."""
    with zipfile.ZipFile(BytesIO(job.content)) as archive:
        if "content.xml" in archive.namelist():
            return _of_ods(archive.read("content.xml"), sheet)
        return _of_xlsx(archive.read(_part(archive, sheet)))


def _percents(job: Job, sheet: str) -> percent.Percents:
    with zipfile.ZipFile(BytesIO(job.content)) as archive:
        if "content.xml" in archive.namelist():
            return percent.of_ods(archive.read("content.xml"), sheet)
        return percent.of_xlsx(archive, _part(archive, sheet))


def _part(archive: zipfile.ZipFile, sheet: str) -> str:
    """Name of the part of an Excel workbook that holds a sheet."""
    book = ET.fromstring(archive.read("xl/workbook.xml"))  # noqa: S314 - its size is bounded, expat's bombs too
    found = next(one for one in book.iter() if is_named(one, "sheet") and one.get("name") == sheet)
    wanted = next(value for key, value in found.items() if key.endswith("}id"))
    links = ET.fromstring(archive.read("xl/_rels/workbook.xml.rels"))  # noqa: S314
    target = next(str(one.get("Target")) for one in links if one.get("Id") == wanted)
    return target.removeprefix("/") if target.startswith("/") else f"xl/{target}"


def _of_xlsx(part: bytes) -> dict[int, str]:
    """Likewise of an Excel workbook, whose rows and cells may leave out where they stand: then they follow the last."""
    found: dict[int, str] = {}
    number = column = 0
    for event, one in ET.iterparse(BytesIO(part), events=("start", "end")):  # noqa: S314
        if event == "start" and is_named(one, "row"):
            number, column = int(one.get("r", number + 1)), 0
        elif event == "start" and is_named(one, "c"):
            place = re.fullmatch(r"([A-Z]{1,3})([0-9]{1,7})", one.get("r", ""))
            column = column_number(place[1]) if place else column + 1
        elif is_named(one, "c"):
            at = one.get("r") or f"{column} of row {number}"
            row = int(re.sub(r"\D", "", one.get("r", "")) or number)
            if any(is_named(part, "f") for part in one):
                found.setdefault(row, f"a formula in cell {at}")
            elif one.get("t") == "e":
                shown = "".join(part.text or "" for part in one)[:20]
                found.setdefault(row, f"the error {quoted(shown)} in cell {at}")
        elif is_named(one, "row") and event == "end":
            one.clear()
    return found


def _of_ods(part: bytes, sheet: str) -> dict[int, str]:
    found: dict[int, str] = {}
    root = ET.fromstring(part)  # noqa: S314
    for table in root.iter(f"{_TABLE}table"):
        if table.get(f"{_TABLE}name") != sheet:
            continue
        number = 0
        for row in table.iter(f"{_TABLE}table-row"):
            if any(cell.get(f"{_TABLE}formula") for cell in row):
                found.setdefault(number + 1, f"a formula in a cell of row {number + 1}")
            number += int(row.get(f"{_TABLE}number-rows-repeated", "1"))
    return found
