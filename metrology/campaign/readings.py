"""The readings that a campaign names: files inside its folder, read strictly, checked against what it declares."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, assert_never

from metrology.declaration.columns import Column, Table
from metrology.declaration.conduct import Exclusion, Test
from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal, mean
from metrology.declaration.readings import Readings
from metrology.errors import Fault, MetrologyError, Notice
from metrology.message import said
from metrology.methods import METHODS
from metrology.readings.files import read, renamed
from metrology.readings.formats import is_readable
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.fits import Fit

MAX_NUMBERS = 20_000_000
"""Numbers in all readings of a campaign, with the line of each row: 160 MB."""
MAX_NEIGHBOURS = 1000
"""Files among which one is looked for that is misspelled."""
Owner = tuple[str, str]


class Shelf:
    """Reads the files of one campaign, each once a use, and keeps tables and faults."""

    def __init__(self, campaign: Campaign) -> None:
        self.campaign = campaign
        self.tables: dict[Owner, tuple[Table, ...]] = {}
        self.faults: list[Fault] = []
        self.refusals: list[Refusal] = []
        self.notices: list[str] = []
        self.held = 0

    def fetch(self) -> None:
        """Read everything and check it."""
        for name, test in self.campaign.tests.items():
            self._read_test(name, test)
            self._exclusions(name, test.exclusions)
        for name, ensemble in self.campaign.ensembles.items():
            groups = [Column(heading, kind="text") for heading in ensemble.factors]
            self._read(("ensembles", name), ensemble.readings, ensemble.columns.values(), groups)
            for table in self.tables.get(("ensembles", name), ()):
                self.faults.extend(_ensemble(table))
        for name, fit in self.campaign.fits.items():
            self._read_fit(name, fit)

    def _read_test(self, name: str, test: Test) -> None:
        """Read the files of a test, which its method names; the tables stand in their order."""
        read: list[Table | None] = []
        for files in METHODS[test.method].readings(name, test):
            tables = [self._table(place, stated, files.columns) for place, stated in files.files]
            whole = [table for table in tables if table is not None]
            if len(whole) == len(tables):
                self._note(files.check(whole))
            read += tables
        for table in read:
            if table is not None and test.date is not None and table.date not in ("", str(test.date)):
                text = "{file}: it says that it was recorded on {day}, test '{test}' on {stated}."
                self.notices.append(said(text, file=table.name, day=table.date, test=name, stated=str(test.date)))
        if None not in read:
            self.tables["tests", name] = tuple(table for table in read if table is not None)

    def _note(self, wrong: Iterable[Refusal | Fault | Notice]) -> None:
        """Keep what is wrong, in the campaign file or in the readings, and what is to be noted."""
        for one in wrong:
            match one:
                case Refusal():
                    self.refusals.append(one)
                case Fault():
                    self.faults.append(one)
                case Notice():
                    self.notices.append(noted(one))
                case _:
                    assert_never(one)

    def _read(self, owner: Owner, stated: Readings, headings: Iterable[str], more: Iterable[Column] = ()) -> None:
        """Read one file, of which some columns are wanted."""
        columns = [*(Column(heading) for heading in headings), *more]
        table = self._table((*owner, "readings"), stated, columns, others=True)
        if table is not None:
            self.tables[owner] = (table,)

    def _table(
        self, place: Place, stated: Readings | str, columns: Sequence[Column], *, others: bool = False
    ) -> Table | None:
        stated = Readings.model_validate(stated)
        path, raw = self.campaign.folder / stated.file, self.campaign.attached.get(stated.file)
        if (raw is None and not self._is_there(place, stated.file)) or self.held > MAX_NUMBERS:
            return None
        try:
            table = renamed(read(path, columns, others=others, stated=stated, raw=raw), Path(stated.file).as_posix())
        except MetrologyError as error:
            self.faults.extend(error.faults)
            return None
        if table.notices:
            self.notices.append(said("{file}: {notes}.", file=table.name, notes=tuple(table.notices)))
        self.held += len(table) * (len(table.numbers) + 1)
        if self.held > MAX_NUMBERS:
            got = f"more than {MAX_NUMBERS} numbers in the readings up to this file"
            self.faults.append(Fault(str(path), got, "less for one campaign", "lower the rate, or make two campaigns"))
            return None
        return table

    def _is_there(self, place: Place, file: str) -> bool:
        """Whether a file is one of the campaign's folder; what it is else is refused."""
        try:
            path = inside(self.campaign.folder, file)
        except ValueError as error:
            expected = "a file with readings in the campaign's folder"
            self.refusals.append(Refusal(place, quoted(file), expected, str(error)))
            return False
        if not path.exists():
            near = mean(file, _neighbours(self.campaign.folder))
            self.refusals.append(Refusal(place, f"{quoted(file)}, which is not there", "a file with readings", near))
            return False
        return True

    def _read_fit(self, name: str, fit: Fit) -> None:
        scatters = [scatter for scatter in (fit.u_x, fit.u_y) if scatter is not None]
        headings = [axis.column for axis in (fit.x, fit.y, *scatters) if axis.column is not None]
        if not headings:
            return
        if fit.readings is None:
            self.refusals.append(Refusal(("fits", name), "columns without 'readings'", "the file that has them"))
            return
        self._read(("fits", name), fit.readings, dict.fromkeys(headings))

    def _exclusions(self, name: str, exclusions: Sequence[Exclusion]) -> None:
        tables = self.tables.get(("tests", name), ())
        files = [table.name for table in tables]
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


def noted(notice: Notice) -> str:
    """A notice as a sentence; one with marks that no terminal may show as it is printed."""
    sentence = said("{where}: {sentence}", where=notice.where, sentence=notice.text)
    return sentence if sentence.isprintable() else str(notice)


def _line(table: Table, exclusion: Exclusion, before: Sequence[Exclusion], place: Place) -> Iterator[Refusal]:
    if exclusion.line is None:
        if any(other.file == exclusion.file for other in before):
            yield Refusal((*place[:-1], "file"), f"{quoted(table.name)} a second time", "every exclusion once")
    elif exclusion.line not in table.lines:
        first, last = int(table.lines[0]), int(table.lines[-1])
        yield Refusal(place, f"line {exclusion.line}", f"a line of {table.name} with a reading, {first} to {last}")
    elif any((other.file, other.line) == (exclusion.file, exclusion.line) for other in before):
        yield Refusal(place, f"line {exclusion.line} a second time", "every exclusion once")


def inside(folder: Path, file: str, suffixes: tuple[str, ...] = ()) -> Path:
    """Path of a file of the campaign: of readings, or with one of the suffixes; a ValueError says why it is none."""
    path = Path(file)
    if path.is_absolute() or "\\" in file or ":" in file or "\0" in file:
        raise ValueError("write the path from the campaign's folder, with '/'")
    if ".." in path.parts:
        raise ValueError("'..' leaves the campaign's folder")
    if suffixes and not file.endswith(suffixes):
        raise ValueError(f"the name ends in {' or '.join(suffixes)}")
    if not suffixes and not is_readable(file):
        raise ValueError("the name ends as that of a format in docs/readings.md: .csv, .xlsx, .tdms …")
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


def _neighbours(folder: Path) -> list[str]:
    """Names of files with readings in the campaign's folder and the folders in it."""
    found = [path for pattern in ("*", "*/*") for path in islice(folder.glob(pattern), MAX_NEIGHBOURS)]
    return [path.relative_to(folder).as_posix() for path in found if is_readable(path.name)]


def _ensemble(table: Table) -> Iterator[Fault]:
    if len(table) < 2:
        yield Fault(str(table.path), "one reading only", "at least two readings, for a standard deviation")
