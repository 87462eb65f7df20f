"""The readings that a campaign names: files inside its folder, read strictly, checked against what it declares."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, assert_never

from metrology.declaration.conduct import Exclusion, Test
from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal, mean
from metrology.declaration.tables import Column, Table, read
from metrology.errors import Fault, MetrologyError
from metrology.methods import METHODS
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.fits import Fit

MAX_NUMBERS = 20_000_000
"""Numbers in all readings of a campaign, with the line of each row: 160 MB."""
Owner = tuple[str, str]


class Shelf:
    """Reads the files of one campaign, each once a use, and keeps tables and faults."""

    def __init__(self, campaign: Campaign) -> None:
        self.campaign = campaign
        self.tables: dict[Owner, tuple[Table, ...]] = {}
        self.faults: list[Fault] = []
        self.refusals: list[Refusal] = []
        self.held = 0

    def fetch(self) -> None:
        """Read everything and check it."""
        for name, test in self.campaign.tests.items():
            self._read_test(name, test)
            self._exclusions(name, test.exclusions)
        for name, ensemble in self.campaign.ensembles.items():
            self._read(("ensembles", name), ensemble.readings, ensemble.columns.values())
            for table in self.tables.get(("ensembles", name), ()):
                self.faults.extend(_ensemble(table))
        for name, fit in self.campaign.fits.items():
            self._read_fit(name, fit)

    def _read_test(self, name: str, test: Test) -> None:
        """Read the files of a test, which its method names; the tables stand in their order."""
        read: list[Table | None] = []
        for files in METHODS[test.method].readings(name, test):
            tables = [self._table(place, file, files.columns) for place, file in files.files]
            whole = [table for table in tables if table is not None]
            if len(whole) == len(tables):
                self._note(files.check(whole))
            read += tables
        if None not in read:
            self.tables["tests", name] = tuple(table for table in read if table is not None)

    def _note(self, wrong: Iterable[Refusal | Fault]) -> None:
        """Keep what is wrong: in the campaign file, or in the readings."""
        for one in wrong:
            match one:
                case Refusal():
                    self.refusals.append(one)
                case Fault():
                    self.faults.append(one)
                case _:
                    assert_never(one)

    def _read(self, owner: Owner, file: str, headings: Iterable[str]) -> None:
        """Read one file, of which some columns are wanted."""
        table = self._table((*owner, "readings"), file, [Column(heading) for heading in headings], others=True)
        if table is not None:
            self.tables[owner] = (table,)

    def _table(self, place: Place, file: str, columns: Sequence[Column], *, others: bool = False) -> Table | None:
        try:
            path = _inside(self.campaign.folder, file)
        except ValueError as error:
            self.refusals.append(
                Refusal(place, quoted(file), "a .csv or .csv.gz file in the campaign's folder", str(error))
            )
            return None
        if self.held > MAX_NUMBERS:
            return None
        try:
            table = read(path, columns, others=others)
        except MetrologyError as error:
            self.faults.extend(error.faults)
            return None
        self.held += len(table) * (len(table.numbers) + 1)
        if self.held > MAX_NUMBERS:
            got = f"more than {MAX_NUMBERS} numbers in the readings up to this file"
            self.faults.append(Fault(str(path), got, "less for one campaign", "lower the rate, or make two campaigns"))
            return None
        return replace(table, source=replace(table.source, path=Path(file).as_posix()))

    def _read_fit(self, name: str, fit: Fit) -> None:
        scatters = [scatter for scatter in (fit.u_x, fit.u_y) if scatter is not None]
        headings = [axis.column for axis in (fit.x, fit.y, *scatters) if axis.column is not None]
        if not headings:
            return
        if fit.readings is None:
            self.refusals.append(Refusal(("fits", name), "columns without 'readings'", "the CSV file that has them"))
            return
        self._read(("fits", name), fit.readings, dict.fromkeys(headings))

    def _exclusions(self, name: str, exclusions: Sequence[Exclusion]) -> None:
        tables = self.tables.get(("tests", name), ())
        files = [table.source.path for table in tables]
        for index, exclusion in enumerate(exclusions) if tables else ():
            place = ("tests", name, "exclusions", index)
            if exclusion.line is None and exclusion.file is None:
                continue
            if exclusion.file is None and len(tables) > 1:
                self.refusals.append(Refusal(place, "no 'file'", f"one of {', '.join(files)}"))
            elif exclusion.file is not None and exclusion.file not in files:
                near = mean(exclusion.file, files)
                self.refusals.append(
                    Refusal((*place, "file"), quoted(exclusion.file), f"one of {', '.join(files)}", near)
                )
            else:
                table = tables[files.index(exclusion.file) if exclusion.file else 0]
                self.refusals.extend(_line(table, exclusion, exclusions[:index], (*place, "line")))


def _line(table: Table, exclusion: Exclusion, before: Sequence[Exclusion], place: Place) -> Iterator[Refusal]:
    if exclusion.line is None:
        if any(other.file == exclusion.file for other in before):
            yield Refusal((*place[:-1], "file"), f"{quoted(table.source.path)} a second time", "every exclusion once")
    elif exclusion.line not in table.lines:
        first, last = int(table.lines[0]), int(table.lines[-1])
        yield Refusal(
            place, f"line {exclusion.line}", f"a line of {table.source.path} with a reading, {first} to {last}"
        )
    elif any((other.file, other.line) == (exclusion.file, exclusion.line) for other in before):
        yield Refusal(place, f"line {exclusion.line} a second time", "every exclusion once")


def _inside(folder: Path, file: str) -> Path:
    """Path of a readings file; a ValueError says why it is none that may be read."""
    path = Path(file)
    if path.is_absolute() or "\\" in file or ":" in file or "\0" in file:
        raise ValueError("write the path from the campaign's folder, with '/'")
    if ".." in path.parts:
        raise ValueError("'..' leaves the campaign's folder")
    if not file.endswith((".csv", ".csv.gz")):
        raise ValueError("the name ends in .csv or .csv.gz")
    full = folder / path
    try:
        inside = full.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):
        inside = False
    if not inside:
        raise ValueError("a link leads out of the campaign's folder")
    if full.exists() and not full.is_file():
        raise ValueError("it is no plain file")
    return full


def _ensemble(table: Table) -> Iterator[Fault]:
    if len(table) < 2:
        yield Fault(str(table.path), "one reading only", "at least two readings, for a standard deviation")
