"""Records that are copies of one another: a second name makes no second measurement."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np

from metrology.errors import Fault

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.columns import Table

Rows = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
WINDOW = 32
"""Readings in a row that are alike in two records: with two levels of noise one in 2³² by chance."""
PARTS = (0.5, 0.125, 0.375, 0.625, 0.875)
"""Where in a record stretches are taken that are sought in the others: half of one may stand in another."""
MOVES = 4.0
"""Usual step of a stretch, over what other digits make, below which it says nothing: a motion that has died away."""
COMMON = 100
"""Places in each record, on average, at which a step of one column may stand that is looked up."""
DIGITS = 1e-6
"""Part of the span of a record by which its readings differ where a copy was written with other digits."""


@dataclass(frozen=True)
class Record:
    """Readings of one file in one test; the stamps are nobody's measurement, and are left out of its columns."""

    test: str
    sample: str
    table: Table
    columns: Mapping[str, Rows]

    @property
    def names(self) -> set[str]:
        """Names of what was read."""
        return set(self.columns)

    @property
    def apart(self) -> list[Record]:
        """A record of each column, by one name for all: what one method calls x is an angle to another."""
        return [replace(self, columns={"reading": column}) for column in self.columns.values()]

    def repeats(self, other: Record) -> bool:
        """Whether a copy would be another measurement here: two tests may evaluate one record of one sample."""
        own = self.table.source.path == other.table.source.path
        return (self.test == other.test and not own) or self.sample != other.sample

    def is_evaluated_again(self, other: Record) -> bool:
        """Whether a copy would be one measurement that two tests of one sample evaluate."""
        return self.test != other.test and self.sample == other.sample


def check_copies(campaign: Campaign) -> Iterator[Fault]:
    """Files with the same content, or readings, under two names: a copy repeats and verifies nothing."""
    records = list(_records(campaign))
    found: dict[tuple[int, int], str] = {}
    content: dict[str, list[int]] = {}
    for at, one in enumerate(records):
        for before in content.setdefault(one.table.source.sha256, []):
            if _is_whole(records[before], one):
                found[before, at] = f"the content of '{records[before].table.source.path}' a second time"
                break
        content[one.table.source.sha256].append(at)
    for before, at, names in _alike(records, Record.repeats):
        path = records[before].table.source.path
        found.setdefault((before, at), f"readings '{', '.join(names)}' of '{path}' a second time")
    for (_, at), got in sorted(found.items()):
        test, path = records[at].test, records[at].table.source.path
        yield Fault(path, got, f"a record of its own in each file of test '{test}'", "name every record once")


def of_one_record(campaign: Campaign) -> set[frozenset[str]]:
    """Pairs of tests of one sample that evaluate one record, or a copy of it: their results are one measurement."""
    by_sample: dict[str, list[Record]] = {}
    for record in _records(campaign):
        by_sample.setdefault(record.sample, []).append(record)
    found = [pair for own in by_sample.values() for pair in _evaluated_again(own)]
    return {frozenset((one.test, other.test)) for one, other in found}


def _evaluated_again(records: Sequence[Record]) -> Iterator[tuple[Record, Record]]:
    """Pairs of records of one sample that are one measurement.

    Alike by the names of their columns, or by whatever names: then each column of the one stands in the other.
    """
    pairs = combinations(records, 2)
    yield from (pair for pair in pairs if Record.is_evaluated_again(*pair) and _same(*pair))
    for before, at, _ in _alike(records, Record.is_evaluated_again):
        yield records[before], records[at]
    apart = [(owner, one) for owner, record in enumerate(records) for one in record.apart]
    held: dict[tuple[int, int], tuple[set[int], set[int]]] = {}
    for before, at, _ in _alike([one for _, one in apart], Record.is_evaluated_again):
        seen = held.setdefault((apart[before][0], apart[at][0]), (set(), set()))
        seen[0].add(before)
        seen[1].add(at)
    for (before, at), (ours, theirs) in held.items():
        one, other = records[before], records[at]
        if len(ours) == len(one.columns) or len(theirs) == len(other.columns):
            yield one, other


def _same(one: Record, other: Record) -> bool:
    """Whether what two tests select is alike but for its order and last digits: of one file it may be other columns."""
    pairs = [(one.columns[name], other.columns[name]) for name in one.names & other.names]
    moved = [_span(a) for a, b in pairs if len(a) == len(b)]
    if len(moved) < len(pairs) or max(moved, default=0.0) == 0.0:
        return False
    return all(np.allclose(np.sort(a), np.sort(b), rtol=0, atol=2 * DIGITS * span, equal_nan=True)
               for (a, b), span in zip(pairs, moved, strict=True))  # fmt: skip


def _records(campaign: Campaign) -> Iterator[Record]:
    for owner, tables in campaign.tables.items():
        if owner[0] == "tests":
            first: dict[str, Table] = {}
            for table in tables:
                first.setdefault(table.name, table)
            sample = campaign.tests[owner[1]].sample
            for table in first.values():
                columns = {name: column for name, column in table.numbers.items() if name != "time"}
                yield Record(owner[1], sample, table, columns)


def _is_whole(one: Record, other: Record) -> bool:
    """Whether two records of one content are copies: what two tests select of one file may differ."""
    if not one.repeats(other):
        return False
    if one.table.source.path != other.table.source.path:
        return True
    names = one.names & other.names
    return bool(names) and all(np.array_equal(one.columns[name], other.columns[name]) for name in names)


def _alike(records: Sequence[Record], counts: Callable[[Record, Record], bool]) -> Iterator[tuple[int, int, list[str]]]:
    """Records of which a stretch stands in another one that counts, reading by reading, or all of it shifted.

    By their steps, which a constant does not change. Steps of one column are looked up in all records at once; a
    column in which a step stands nearly everywhere, at rest or as it was commanded, tells nothing.
    """
    for name in sorted({name for one in records for name in one.columns}):
        having = [at for at, one in enumerate(records) if name in one.columns and len(one.columns[name]) > WINDOW]
        if len(having) < 2:
            continue
        steps = [np.diff(records[at].columns[name]) for at in having]
        every, ends = np.concatenate(steps), np.cumsum([len(part) for part in steps])
        order = np.argsort(every)
        ranked = every[order]
        for (place, at), part in product(enumerate(having), PARTS):
            window = _window(steps[place], part)
            same = 2 * DIGITS * _span(records[at].columns[name])
            low, high = (np.searchsorted(ranked, window + sign * same) for sign in (-1, 1))
            # The rarest steps first, which leave the fewest places.
            rare = np.argsort(high - low)
            key = int(rare[0])
            places = order[low[key] : high[key]]
            if len(places) > COMMON * len(having) or not _tells(window, same):
                continue
            first = places - key
            first = first[(first >= 0) & (first + len(window) <= len(every))]
            for step in rare[1:4].tolist():
                first = first[abs(every[first + step] - window[step]) <= same]
            owner = np.searchsorted(ends, first, side="right")
            start = np.concatenate([[0], ends])[owner]
            inside = (first >= start) & (first + len(window) <= ends[owner]) & (owner != place)
            first, owner, start = first[inside], owner[inside], start[inside]
            rows = every[first[:, None] + np.arange(len(window))]
            hits = (abs(rows - window) <= same).all(axis=1)
            for here, where in zip(first[hits] - start[hits], owner[hits], strict=True):
                other = records[having[where]]
                if counts(other, records[at]) and _holds(other, records[at], int(here), part):
                    pair = sorted((having[where], at))
                    yield pair[0], pair[1], sorted(other.names & records[at].names)


def _tells(window: Rows, same: float) -> bool:
    """Whether the steps of a stretch are larger than what is taken to be alike."""
    moves = np.abs(window[window != 0.0])
    return bool(len(moves)) and float(np.median(moves)) > MOVES * same


def _span(values: Rows) -> float:
    """From the lowest reading to the highest one, gaps left out."""
    seen = values[np.isfinite(values)]
    return float(np.ptp(seen)) if len(seen) else 0.0


def _window(steps: Rows, part: float) -> Rows:
    first = min(int(part * (len(steps) + 1)), len(steps) + 1 - WINDOW)
    return steps[first : first + WINDOW - 1]


def _holds(one: Record, other: Record, start: int, part: float) -> bool:
    """Whether the stretch stands there in all columns of both.

    A stretch in which many readings are like the one before says nothing: channels at rest, or held.
    """
    names = sorted(one.names & other.names)
    rows, sought = (np.diff(np.column_stack([each.columns[name] for name in names]), axis=0)
                    for each in (one, other))  # fmt: skip
    span = np.array([_span(one.columns[name]) for name in names])
    window = np.column_stack([_window(column, part) for column in sought.T])
    at_rest = (window == 0).all(axis=1)
    here = rows[start : start + len(window)]
    if len(here) < len(window) or at_rest.sum() > WINDOW // 4:
        return False
    return bool(((abs(here - window) <= 2 * DIGITS * span) | (np.isnan(here) & np.isnan(window))).all())
