"""What an unknown file of readings holds: its layout, and what each column looks like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from metrology import units
from metrology.declaration.columns import Integers
from metrology.declaration.readings import SEPARATORS, Readings
from metrology.draft import instruments
from metrology.draft.instruments import size_of
from metrology.draft.seen import Seen, as_numbers, as_words
from metrology.draft.vocabulary import by_suffix, role
from metrology.readings import apart, formats, text
from metrology.readings.headings import spelled, take_apart
from metrology.readings.layout import COMMA, GROUPED
from metrology.readings.packed import stored, unpacked
from metrology.readings.sheet import Chunk, Heading, Job, Log, Sheet, refused, sampling
from metrology.units.dimensions import TextError

NO_PARTS: Mapping[str, str] = MappingProxyType({})
STATE = "name it: --{kind} …"
RATE = 0.01
"""Part by which a rate in the header and that of the stamps may differ: clocks differ by less."""
TOP = 60
"""Lines in which a header block is read for what it says."""
COORDINATES = ("x", "y", "z", "tx", "ty", "tz", "rx", "ry", "rz", "exx", "eyy", "exy")
RECORDED = ("force", "thrust", "displacement", "strain", "angle", "velocity", "acceleration", "reading")


@dataclass(frozen=True)
class Survey:
    """What one file holds.

    Parameters
    ----------
    path : Path
    title : str
        Name of the format.
    found : instruments.Found
        What its header block says.
    columns : tuple of Seen
    stated : dict
        What a mapping under `readings:` states of it, beside the file and the columns.
    notices : tuple of str
        What was found out about its layout.
    step : float
        Time between two samples / s where the file states it, else 0.
    date : str
        Day of the measurement where the file states it.
    lines : array
        Line of each row.
    doubtful : str
        A number whose mark may be the decimal mark or group the digits, where every one is so.
    unsettled : dict
        Why an entry of `stated` is a guess, by its key.
    rows : tuple of int, optional
        First and last line of the stretch that is read, where it is not the whole.
    lost : tuple of str
        What of the file no run reads, a sentence each.
    beside : tuple of Survey
        Other files of the same run.
    """

    path: Path
    title: str
    found: instruments.Found
    columns: tuple[Seen, ...]
    stated: dict[str, str] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    step: float = 0.0
    date: str = ""
    lines: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    doubtful: str = ""
    unsettled: dict[str, str] = field(default_factory=dict)
    rows: tuple[int, int] | None = None
    lost: tuple[str, ...] = ()
    beside: tuple[Survey, ...] = ()

    @property
    def other_rate(self) -> str:
        """Two rates, where the header block states another one than the stamps have; else nothing."""
        time = self.first("time")
        if not self.found.rate or time is None or time.values is None or len(time.values) < 2:
            return ""
        try:
            second = float(units.unit(time.unit or "1").factor)
        except TextError:
            return ""
        step = float(np.nanmedian(np.diff(time.values))) * second
        rate = 1 / step if time.unit and step > 0 else self.found.rate
        if abs(rate / self.found.rate - 1) < RATE:
            return ""
        return f"the header has {self.found.rate:.6g} Hz, the stamps {rate:.6g} Hz"

    def fact(self, key: str) -> str:
        """What the file says beside its readings: by its header block, or by a column with one value."""
        sizes = (f"{one.words[0]} {one.unit}" for one in self.columns if one.constant and size_of(one.name) == key)
        return self.found.facts.get(key, "") or next(sizes, "")

    def first(self, *roles: str) -> Seen | None:
        """The first column of the first of these roles that there is; of coordinates, the one that moves most."""
        for wanted in roles:
            found = [one for one in self.columns if one.role == wanted]
            if found and all(one.name.strip().casefold() in COORDINATES for one in found):
                return max(found, key=lambda one: 0.0 if one.values is None else float(np.nanstd(one.values)))
            if found:
                return found[0]
        return None


def survey(path: Path, parts: Mapping[str, str] = NO_PARTS) -> Survey:
    """Look at a file, or at a part of it: a `member`, `sheet`, `group`, `dataset` or `channel` by its name.

    Of `parts`, `decimal` is its decimal mark, ``point`` or ``comma``.

    Raises
    ------
    MetrologyError
        For a file that cannot be read, or in which no table was found.
    """
    raw = stored(path)
    stated = Readings.model_validate({"file": path.name, **parts})
    content, name = unpacked(path, raw, stated.member, state=STATE)
    log = Log(str(path))
    plain = Job(path, content, stated, lambda _headings: 0, 10**6, log, STATE)
    found = formats.recognise(plain, name)
    top = _top(plain, found)
    block = instruments.recognise(top)
    if block.line:
        stated = stated.model_copy(update={"header": block.line - 1, "separator": "comma"})
    job = replace(plain, stated=stated, wanted=_recognised)
    with apart.readable(str(path), found):
        sheet = apart.load(job, found)
        chunks = list(sheet.chunks)
    block = instruments.recognise(sheet.above) if sheet.above else block
    sheet = replace(sheet, chunks=iter(chunks))
    unsettled: dict[str, str] = {}
    if found.name in ("xlsx", "ods") and (comma := _typed_comma(chunks)):
        sheet = replace(
            sheet, decimal=",", doubtful="" if stated.decimal else comma if GROUPED.fullmatch(comma) else ""
        )
        parts = {"decimal": "comma", **parts}
        unsettled["decimal"] = "numbers stand as texts with a comma"
    columns = _columns(sheet, block)
    if not any(one.values is not None for one in columns):
        log.stop()
        raise refused(path, "no table of numbers", "headings above columns of numbers", "write 'readings:' by hand")
    options = {**parts, **_options(job, found, sheet, columns)}
    rivals = {",", ";", "\t", "|"} - {sheet.separator}
    if "separator" in options and any(rivals & set(one.text) for one in sheet.headings):
        unsettled["separator"] = "the headings have other marks, too"
    step = _step(job, sheet, columns)
    lines = np.concatenate([where for _, where in chunks])
    return Survey(
        path,
        found.title.partition(" ")[2],
        block,
        columns,
        options,
        tuple(log.notices),
        step,
        sheet.date,
        lines,
        sheet.doubtful,
        unsettled,
    )


def _typed_comma(chunks: Sequence[Chunk]) -> str:
    """A number with a decimal comma, of a workbook in which numbers stand as texts; one that can be no group first."""
    texts = [cell.strip() for cells, _ in chunks for column in cells if isinstance(column, Sequence) for cell in column]
    found = [cell for cell in texts if COMMA.fullmatch(cell)]
    return next((cell for cell in found if not GROUPED.fullmatch(cell)), found[0] if found else "")


def _step(job: Job, sheet: Sheet, columns: Sequence[Seen]) -> float:
    """Time between two readings / s of the columns that look like anything; 0 where the file does not state it."""
    known = [heading for heading, seen in zip(sheet.headings, columns, strict=True) if seen.role]
    sampled, other = sampling(known)
    if other is not None and not any(seen.role == "time" for seen in columns):
        got = f"columns that were sampled at different times: '{other.text}' with {other.sampled}, others {sampled}"
        raise refused(job.log.where, got, "columns on the same rows", "write 'readings:' by hand, an entry for each")
    return float(sampled.step) if sampled else 0.0


def _top(job: Job, found: formats.Format) -> list[str]:
    """The first lines of a text; none of a file in another format."""
    if found.name not in ("text", "lvm"):
        return []
    quiet = replace(job, log=Log(job.log.where))
    return text.decoded(quiet).split("\n", TOP)[:TOP]


def _recognised(headings: Sequence[Heading]) -> int:
    """How many headings have a word or a unit that laboratories use."""
    taken = [(take_apart(heading.text), heading.unit) for heading in headings]
    return sum(
        bool(role(one.name, one.unit)) or (one.unit or below) not in ("", "1") or by_suffix(one.name)[1] != ""
        for one, below in taken
    )


def _columns(sheet: Sheet, block: instruments.Found) -> tuple[Seen, ...]:
    parts: list[list[Any]] = [[] for _ in sheet.headings]
    for cells, _ in sheet.chunks:
        for part, column in zip(parts, cells, strict=True):
            part.extend(column if isinstance(column, Sequence) else column.tolist())
    return tuple(
        _seen(number, heading, part, sheet.decimal, block)
        for number, (heading, part) in enumerate(zip(sheet.headings, parts, strict=True), start=1)
    )


def _seen(number: int, heading: Heading, cells: list[Any], decimal: str, block: instruments.Found) -> Seen:
    written = take_apart(heading.text)
    unit = spelled(heading.unit) or ("" if written.unit in ("1", "-", "–") else written.unit)
    with_unit = unit != ""
    if not unit and block.unit and written.name in ("X", "Y", "Z"):
        unit = block.unit
    name, suffix = by_suffix(written.name) if not unit else (written.name, "")
    unit = unit or suffix
    if unit == "g" and role(name, "") == "acceleration":
        unit = "gn"
    words = as_words(cells)
    plain = tuple(map(_by_point, words)) if decimal == "," else words
    texts = tuple(cell.strip() if isinstance(cell, str) else f"{cell:.12g}" for cell in cells)
    values = as_numbers(plain)
    numbers = words if values is None else plain
    seen = Seen(number, heading.text, name, unit, role(name, unit), values, numbers, texts, with_unit)
    # What says the same on every row tells of the specimen, and is no record.
    return replace(seen, role="") if seen.constant and seen.role in RECORDED else seen


def _by_point(word: str) -> str:
    """Return a number with a decimal comma, in which points group the digits, as one with a decimal point."""
    whole = GROUPED.fullmatch(word) and "," not in word
    return word.replace(".", "") if whole else word.replace(",", ".")


def _options(job: Job, found: formats.Format, sheet: Sheet, columns: Sequence[Seen]) -> dict[str, str]:
    """What the mapping states, so that nothing has to be found again."""
    options: dict[str, str] = {}
    if found.name == "text":
        options["separator"] = next(name for name, mark in SEPARATORS.items() if mark == sheet.separator)
        numbers = (cell for one in columns if one.values is not None for cell in one.written)
        if sheet.separator == "," or any("." in cell or "," in cell for cell in numbers):
            options["decimal"] = "comma" if sheet.decimal == "," else "point"
        if any("Windows-1252" in notice for notice in job.log.notices):
            options["encoding"] = "cp1252"
    if found.name in ("text", "xlsx", "ods") and sheet.line:
        options["header"] = str(sheet.line - 1)
    for notice in job.log.notices:
        if notice.startswith("its sheet '"):
            options["sheet"] = notice.removeprefix("its sheet '").removesuffix("' was read")
    return options
