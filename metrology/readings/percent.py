"""Cells of a spreadsheet that are formatted as percent: 0.0006 is stored where 0.06 % is shown.

ECMA-376 part 1, 18.8.30: number formats 9 and 10 are percent, and those of the workbook's own that hold a percent sign.
OpenDocument 1.3 part 3, 19.387: the type of such a cell is `percentage`.
"""

from __future__ import annotations

import re
import zipfile
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal, InvalidOperation
from functools import reduce
from io import BytesIO
from xml.etree import ElementTree as ET

from metrology.message import said
from metrology.readings.sheet import Heading, Job

_TABLE = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"
_TYPE = "{urn:oasis:names:tc:opendocument:xmlns:office:1.0}value-type"
_BUILT_IN = frozenset({"9", "10"})
Row = tuple[int, list[str]]
Percents = dict[int, set[int]]
"""Rows, from 1, with a number formatted as percent, by the number of the column, from 1."""


def is_named(element: ET.Element, name: str) -> bool:
    """Whether an element has a name, in the name space of transitional or of strict Office Open XML."""
    return element.tag.rpartition("}")[2] == name


def column_number(letters: str) -> int:
    """Number of a column by its letters: A is 1, Z 26, AA 27."""
    return reduce(lambda number, letter: 26 * number + ord(letter) - 64, letters, 0)


def of_xlsx(archive: zipfile.ZipFile, part: str) -> Percents:
    """Cells of the sheet in a part of an Excel workbook; one that does not say where it stands follows the last."""
    styles = _styles(archive)
    found: Percents = defaultdict(set)
    number = column = 0
    for event, one in ET.iterparse(BytesIO(archive.read(part)), events=("start", "end")) if styles else ():  # noqa: S314
        if event == "start" and is_named(one, "row"):
            number, column = int(one.get("r", number + 1)), 0
        elif event == "start" and is_named(one, "c"):
            place = re.fullmatch(r"([A-Z]{1,3})([0-9]{1,7})", one.get("r", ""))
            column = column_number(place[1]) if place else column + 1
            if one.get("s") in styles and one.get("t", "n") == "n":
                found[column].add(number)
        elif event == "end" and is_named(one, "row"):
            one.clear()
    return found


def _styles(archive: zipfile.ZipFile) -> frozenset[str]:
    """Numbers of the cell styles that show percent."""
    if "xl/styles.xml" not in archive.namelist():
        return frozenset()
    root = ET.fromstring(archive.read("xl/styles.xml"))  # noqa: S314 - its size is bounded, no entity is declared
    # A percent sign in quotation marks, or behind a backslash, is a letter.
    own = {
        one.get("numFmtId", "")
        for one in root.iter()
        if is_named(one, "numFmt") and "%" in re.sub(r'"[^"]*"|\\.', "", one.get("formatCode", ""))
    }
    styles = next((one for one in root.iter() if is_named(one, "cellXfs")), None)
    each = enumerate(styles if styles is not None else ())
    return frozenset(str(at) for at, style in each if style.get("numFmtId") in _BUILT_IN | own)


def of_ods(content: bytes, sheet: str) -> Percents:
    """Cells of a sheet of an OpenDocument spreadsheet."""
    found: Percents = defaultdict(set)
    if b'"percentage"' not in content:
        return found
    for table in ET.fromstring(content).iter(f"{_TABLE}table"):  # noqa: S314
        if table.get(f"{_TABLE}name") != sheet:
            continue
        number = 0
        for row in table.iter(f"{_TABLE}table-row"):
            column = 0
            rows = int(row.get(f"{_TABLE}number-rows-repeated", "1"))
            for cell in row:
                columns = int(cell.get(f"{_TABLE}number-columns-repeated", "1"))
                if cell.get(_TYPE) == "percentage":
                    for each in range(column + 1, column + columns + 1):
                        found[each].update(range(number + 1, number + rows + 1))
                column += columns
            number += rows
    return found


def as_shown(
    job: Job, headings: Sequence[Heading], rows: Sequence[Row], used: Sequence[int], percents: Percents
) -> tuple[list[Heading], Sequence[Row]]:
    """Headings and rows with the numbers that are shown as percent in %; a column that is so in part is a fault.

    `used`: index of the column of each heading in the rows.
    """
    shown, changed = list(headings), list(rows)
    for at, index in enumerate(used):
        inside = percents.get(index + 1, set()) & {number for number, _ in rows}
        if not inside:
            continue
        name = shown[at].text
        plain = next((number for number, cells in rows if cells[index] and number not in inside), 0)
        if plain:
            got = f"a cell that is not formatted as percent, as that of row {min(inside)} is"
            job.log.fault(plain, got, "one format for all numbers of a column", column=name)
        unit = shown[at].unit
        if unit not in ("", "-", "–", "%"):
            job.log.fault(min(inside), f"cells formatted as percent, in '{unit}'", "one of the two", column=name)
        job.log.note(said("the cells of '{name}' are formatted as percent, and were read in %", name=name))
        shown[at] = replace(shown[at], unit="%")
        changed = [
            (number, [*cells[:index], _hundredfold(cells[index]), *cells[index + 1 :]]) for number, cells in changed
        ]
    return shown, changed


def _hundredfold(cell: str) -> str:
    """A stored number in %, digit by digit; a text as it is.

    Examples
    --------
    >>> _hundredfold("0.0006"), _hundredfold("-1"), _hundredfold("2e-05"), _hundredfold("n/a")
    ('0.06', '-100', '0.002', 'n/a')
    """
    try:
        shown = f"{Decimal(cell).scaleb(2):f}"
    except (InvalidOperation, ValueError):
        return cell
    return shown.rstrip("0").rstrip(".") if "." in shown else shown
