"""LabVIEW measurement files (.lvm): a header of keys and values, one of channels, then a segment of readings.

NI, "LabVIEW Measurement (LVM) File Format", version 1.0 to 2.0: keys are separated from values by the stated separator;
`X_Columns` says whether stamps are written (`One`, `Multi`) or follow from `X0` and `Delta_X` (`No`).
"""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction

from metrology.readings import text
from metrology.readings.sheet import Job, Sampled, Sheet, refused
from metrology.units.dimensions import quoted

_SEPARATORS = {"tab": "\t", "comma": ","}
_PLAIN = re.compile(r"[+-]?\d{1,20}(?:[.,]\d{1,20})?(?:[eE][+-]?\d{1,2})?", re.ASCII)
_END = "***End_of_Header***"


def read(job: Job) -> Sheet:
    """Return the first segment of readings; a second one is refused."""
    whole = text.decoded(job)
    lines = whole.split("\n")
    ends = [at for at, line in enumerate(lines) if line.startswith(_END)]
    if len(ends) != 2:
        got = f"{max(len(ends) - 1, 0)} segments of readings"
        raise refused(job.log.where, got, "one segment", "write one segment a file")
    if ends[1] + 2 >= len(lines):
        raise refused(job.log.at(ends[1] + 1), "no readings below the header", "a line of headings and readings")
    keys = _keys(lines[: ends[1]])
    separator = _SEPARATORS.get(keys.get("Separator", ["Tab"])[0].lower(), "\t")
    comma = keys.get("Decimal_Separator", ["."])[0] == ","
    kind = keys.get("X_Columns", ["No"])[0].lower()
    if kind == "multi":
        raise refused(job.log.where, "time stamps of their own for every channel", "one column of stamps, or none")
    table = "\n".join(line.rstrip("\t") for line in lines[ends[1] + 1 :])
    below = _below(job, table, separator, comma=comma, above=ends[1] + 1)
    units = dict(zip(_channels(lines[ends[1] + 1], separator), keys.get("Y_Unit_Label", []), strict=False))
    headings = [replace(one, unit=units.get(one.text, "")) for one in below.headings]
    headings = [replace(one, text="time / s") if one.text == "X_Value" else one for one in headings]
    if kind == "one":
        return replace(below, headings=headings)
    step, start = keys.get("Delta_X", ["0"])[0], keys.get("X0", ["0"])[0]
    sampled = Sampled(_number(job, "Delta_X", step), _number(job, "X0", start))
    headings = [replace(one, sampled=sampled) for one in headings]
    made = replace(below, date=_date(keys))
    if headings[:1] and headings[0].text == "time / s":  # a column that is empty on every line
        return replace(made, headings=headings[1:], chunks=((cells[1:], where) for cells, where in below.chunks))
    return replace(made, headings=headings)


def _keys(lines: list[str]) -> dict[str, list[str]]:
    """Keys of the headers with their values; a later key, of the channels, replaces one of the file."""
    found: dict[str, list[str]] = {}
    for line in lines:
        for separator in ("\t", ","):
            key, mark, values = line.partition(separator)
            if mark and " " not in key:
                found[key] = [value.strip() for value in values.split(separator)]
                break
    return found


def _channels(heading: str, separator: str) -> list[str]:
    return [cell.strip() for cell in heading.split(separator) if cell.strip() not in ("X_Value", "Comment", "")]


def _below(job: Job, table: str, separator: str, *, comma: bool, above: int) -> Sheet:
    """The table below the headers, with line numbers of the whole file."""
    layout = text.laid_out(replace(job, content=b""), table, separator, "," if comma else ".")
    chunks = ((cells, where + above) for cells, where in layout.chunks)
    return replace(layout, chunks=chunks, line=above + 1)


def _number(job: Job, key: str, written: str) -> Fraction:
    if not _PLAIN.fullmatch(written):
        raise refused(job.log.where, f"{quoted(written)} as {key}", "a number", "copy the file again")
    return Fraction(written.replace(",", "."))


def _date(keys: dict[str, list[str]]) -> str:
    return keys.get("Date", [""])[0].replace("/", "-")
