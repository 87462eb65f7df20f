"""The readings that a campaign names: files inside its folder, read strictly, checked against what it declares."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from metrology.campaign.document import Place
from metrology.campaign.entry import Refusal, mean
from metrology.campaign.methods import DecayTest, ElongationTest, Exclusion, ResponseTest
from metrology.campaign.response_checks import check_readings
from metrology.campaign.response_units import by_channel, columns
from metrology.campaign.tables import Column, Table, read
from metrology.elongation import DIRECTIONS
from metrology.errors import Fault, MetrologyError
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.campaign.fits import Fit
    from metrology.campaign.schema import Campaign

MIN_REPEATS = 3
MIN_SAMPLES = 20
MAX_NUMBERS = 20_000_000
"""Numbers in all readings of a campaign, with the line of each row: 160 MB."""
ELONGATION = (
    Column("load", kind="text"),
    Column("repeat", kind="text"),
    Column("direction", kind="text", choices=DIRECTIONS),
    Column("reading", "m", varies=True),
)
TIME = Column("time", "s", increasing=True)
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
            if isinstance(test, ElongationTest):
                self._read(("tests", name), [test.readings], ELONGATION)
                self._each(("tests", name), lambda table, test=test: _elongation(table, test))
            elif isinstance(test, DecayTest):
                reading = Column(*test.column, gaps=True, varies=True)
                self._read(("tests", name), test.readings, (TIME, reading))
                self._each(("tests", name), _decay)
            elif isinstance(test, ResponseTest):
                self._read_runs(name, test)
            self._exclusions(name, test.exclusions)
        for name, ensemble in self.campaign.ensembles.items():
            columns = [Column(heading) for heading in ensemble.columns.values()]
            self._read(("ensembles", name), [ensemble.readings], columns, others=True)
            self._each(("ensembles", name), _ensemble)
        for name, fit in self.campaign.fits.items():
            self._read_fit(name, fit)

    def _read(self, owner: Owner, files: Sequence[str], columns: Sequence[Column], *, others: bool = False) -> None:
        tables = []
        for index, file in enumerate(files):
            place: Place = (*owner, "readings", index) if len(files) > 1 else (*owner, "readings")
            table = self._table(place, file, columns, others=others)
            tables += [] if table is None else [table]
        if len(tables) == len(files):
            self.tables[owner] = tuple(tables)

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

    def _read_runs(self, name: str, test: ResponseTest) -> None:
        """Read the files of every run; the tables of the test stand in the order of its runs."""
        tables: list[Table | None] = []
        for run_name, run in test.runs.items():
            place: Place = ("tests", name, "runs", run_name)
            found = [
                self._table((*place, "readings", index), file, columns(test)) for index, file in enumerate(run.readings)
            ]
            found = [None if table is None else by_channel(table, test) for table in found]
            tables += found
            whole = [table for table in found if table is not None]
            if whole and len(whole) == len(found):
                wrong = list(check_readings(test, run, whole, place))
                self.refusals += [one for one in wrong if isinstance(one, Refusal)]
                self.faults += [one for one in wrong if isinstance(one, Fault)]
        if None not in tables:
            self.tables["tests", name] = tuple(table for table in tables if table is not None)

    def _each(self, owner: Owner, check: object) -> None:
        for table in self.tables.get(owner, ()):
            self.faults.extend(check(table))  # type: ignore[operator]

    def _read_fit(self, name: str, fit: Fit) -> None:
        scatters = [scatter for scatter in (fit.u_x, fit.u_y) if scatter is not None]
        headings = [axis.column for axis in (fit.x, fit.y, *scatters) if axis.column is not None]
        if not headings:
            return
        if fit.readings is None:
            self.refusals.append(Refusal(("fits", name), "columns without 'readings'", "the CSV file that has them"))
            return
        self._read(
            ("fits", name), [fit.readings], [Column(heading) for heading in dict.fromkeys(headings)], others=True
        )

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


def _elongation(table: Table, test: ElongationTest) -> Iterator[Fault]:
    loads, repeats, directions = (table.texts[name] for name in ("load", "repeat", "direction"))
    seen: dict[tuple[str, str, str], int] = {}
    strange: set[str] = set()
    for row, key in enumerate(zip(loads, repeats, directions, strict=True)):
        if key[0] not in test.loads and key[0] not in strange:
            strange.add(key[0])
            near = mean(key[0], list(test.loads))
            yield Fault(
                table.at(row, "load"), quoted(key[0]), f"one of the declared loads {', '.join(test.loads)}", near
            )
        if key in seen:
            got = f"load {key[0]}, repeat {key[1]}, {key[2]} a second time (first in line {table.lines[seen[key]]})"
            yield Fault(table.at(row), got, "every reading once", "number the repeats")
        seen.setdefault(key, row)
    counts = Counter(load for load, _ in {(load, repeat) for load, repeat in zip(loads, repeats, strict=True)})
    for load in test.loads:
        if counts[load] < MIN_REPEATS:
            got = f"{counts[load] or 'no'} repeat{'' if counts[load] == 1 else 's'} of load '{load}'"
            yield Fault(str(table.path), got, "at least three repeats of every load")


def _decay(table: Table) -> Iterator[Fault]:
    if len(table) < MIN_SAMPLES:
        yield Fault(str(table.path), f"{len(table)} samples", f"at least {MIN_SAMPLES}")


def _ensemble(table: Table) -> Iterator[Fault]:
    if len(table) < 2:
        yield Fault(str(table.path), "one reading only", "at least two readings, for a standard deviation")
