"""What every reader returns: a table as the file has it, before anybody asks what its columns mean."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from operator import itemgetter
from pathlib import Path

from metrology.declaration.columns import Floats, Integers
from metrology.declaration.readings import Readings
from metrology.errors import Fault, MetrologyError

MAX_FAULTS = 20
MAX_COLUMNS = 1000
MAX_VALUES = 20_000_000
"""Numbers that a file may hold: 160 MB, as many as all readings of a campaign."""
STATE = "state it in the campaign file: '{kind}: …'"
"""What is to be done where a file has several parts of a kind and none is stated."""
Cells = Sequence[str] | Floats
Chunk = tuple[Sequence[Cells], Integers]
Wanted = Callable[[Sequence["Heading"]], int]
"""How many of the columns that are due a line of headings has."""


class SeveralPartsError(MetrologyError):
    """A file with several parts of a `kind`, of which none is stated; `names` are those that may be meant."""

    kind = ""
    names: tuple[str, ...] = ()

    @classmethod
    def of(cls, kind: str, names: Sequence[str], error: MetrologyError) -> SeveralPartsError:
        """The same refusal, with what may be stated."""
        made = cls(*error.faults)
        made.kind, made.names = kind, tuple(names)
        return made


def refused(where: str | Path, got: str, expected: str, fix: str = "") -> MetrologyError:
    """One fault as an error."""
    return MetrologyError(Fault(str(where), got, expected, fix))


@dataclass(frozen=True)
class Sampled:
    """When the readings of a column were taken: `step` and `start` / s, and the instant from which the start counts."""

    step: Fraction
    start: Fraction = Fraction(0)
    since: str = ""

    def __str__(self) -> str:
        """As messages have it."""
        since = f" after {self.since}" if self.since else ""
        return f"a step of {float(self.step):g} s from {float(self.start):g} s{since} on"


@dataclass(frozen=True)
class Heading:
    """What the file says of a column: its heading, and what its metadata have, the unit and when it was sampled."""

    text: str
    unit: str = ""
    sampled: Sampled | None = None


@dataclass(frozen=True)
class Sheet:
    """A table as a file holds it.

    Parameters
    ----------
    headings : sequence of Heading
        Of the columns, from the left.
    chunks : iterator
        Some rows at a time: cells by column, as texts or as numbers, and the line of each row in the file.
    line : int
        Line of the headings, by which faults name them; 0 in a file without lines.
    decimal, separator : str
        Decimal mark of cells that are texts, and what stands between the cells of a text.
    date : str
        Day of the measurement where the file states it, ``2026-10-05``.
    above : sequence of str
        Rows above the headings of a workbook, their cells joined by tabs.
    doubtful : str
        A number whose mark may be the decimal mark or group the digits, in a text where every one is so.
    """

    headings: Sequence[Heading]
    chunks: Iterator[Chunk]
    line: int = 0
    decimal: str = "."
    date: str = ""
    separator: str = ""
    above: Sequence[str] = ()
    doubtful: str = ""


def sampling(headings: Sequence[Heading]) -> tuple[Sampled | None, Heading | None]:
    """When the rows of some columns were taken, and the first column that was sampled otherwise; None where none is.

    A column of which the file says nothing stands on the rows of the others.
    """
    timed = [one for one in headings if one.sampled is not None]
    if not timed:
        return None, None
    return timed[0].sampled, next((one for one in timed if one.sampled != timed[0].sampled), None)


def refuse_doubtful(log: Log, sheet: Sheet) -> None:
    """Refuse a text of which nobody knows what the marks within its numbers are."""
    if sheet.doubtful:
        mark, other = ("comma", "point") if "," in sheet.doubtful else ("point", "comma")
        got = f"numbers such as '{sheet.doubtful}', whose {mark} may be a decimal mark or group the digits"
        raise refused(log.where, got, "one of the two", f"state 'decimal: {mark}', or 'decimal: {other}' and no groups")


@dataclass
class Log:
    """Faults and notices of one file, as they turn up; too many faults end the reading.

    `again`: how often a fault with the same cause came again, and on which line the last time.
    """

    where: str
    faults: list[tuple[int, Fault]] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)
    again: dict[tuple[str, ...], tuple[int, int, int]] = field(default_factory=dict)

    def at(self, line: int, column: str = "") -> str:
        """Where a line stands: ``readings.csv:14 reading``."""
        return f"{self.where}:{line} {column}".rstrip() if line else f"{self.where} {column}".rstrip()

    def fault(self, line: int, got: str, expected: str, fix: str = "", *, column: str = "", cause: str = "") -> None:
        """Keep a fault; of those of a column with one `cause` the first, and how many more there are."""
        if cause:
            place, more, _ = self.again.get((column, cause), (len(self.faults), -1, line))
            self.again[column, cause] = (place, more + 1, line)
            if more >= 0:
                return
        full = len(self.faults) + 1 >= MAX_FAULTS
        got = f"{got}; what is wrong beyond {MAX_FAULTS} faults of a file is not listed" if full else got
        self.faults.append((line, Fault(self.at(line, column), got, expected, fix)))
        if full:
            self.stop()

    def stop(self) -> None:
        """Raise the faults, by line, where there are any."""
        if self.faults:
            for place, more, last in self.again.values():
                line, fault = self.faults[place]
                if more:
                    folded = f"{fault.got}, and {more} more down to line {last}"
                    self.faults[place] = line, replace(fault, got=folded)
            self.again.clear()
            raise MetrologyError(*(fault for _, fault in sorted(self.faults, key=itemgetter(0))))

    def note(self, text: str) -> None:
        """Keep what was done to read the file, once."""
        if text not in self.notices:
            self.notices.append(text)


@dataclass(frozen=True)
class Job:
    """One file to be read.

    Parameters
    ----------
    path : Path
        The file; what it holds is in `content`.
    content : bytes
        Unpacked.
    stated : Readings
        How the campaign says that it is read.
    wanted : callable
        Counts the columns that are due among headings: how the line of the headings and the sheet are found.
    due : int
        How many columns are due.
    log : Log
        Takes faults and notices.
    state : str
        What is to be done where a file has several parts of a `kind` and none is stated.
    """

    path: Path
    content: bytes
    stated: Readings
    wanted: Wanted
    due: int
    log: Log
    state: str = STATE

    def choose(self, kind: str, names: Sequence[str], given: str | None) -> str:
        """Return the part of a file that is read: the one that is stated, or the only one.

        Raises
        ------
        MetrologyError
            Where there is none of the stated name, or more than one and none is stated.
        """
        if given is not None and given in names:
            return given
        if given is None and len(names) == 1:
            return names[0]
        expected = f"one of {', '.join(repr(name) for name in names[:12])}" if names else f"a file with a {kind}"
        got = f"no {kind} '{given}'" if given is not None else f"{len(names)} {kind}s and none stated"
        error = refused(self.log.where, got, expected, self.state.format(kind=kind) if names else "")
        raise SeveralPartsError.of(kind, names, error) if given is None and names else error
