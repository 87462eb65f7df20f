"""Records that are copies of one another: a second name makes no second measurement."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from metrology.errors import Fault

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.columns import Table

Rows = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
WINDOW = 32
"""Readings in a row that are alike in two records: with two levels of noise one in 2³² by chance."""

DIGITS = 1e-6
"""Part of the span of a record by which its readings differ where a copy was written with other digits."""


def check_copies(campaign: Campaign) -> Iterator[Fault]:
    """Files of one test with the same content, or readings, under two names: a copy repeats and verifies nothing."""
    for owner, tables in campaign.tables.items():
        if owner[0] != "tests":
            continue
        first: dict[str, Table] = {}
        for table in tables:
            first.setdefault(table.name, table)
        for one, other in combinations(first.values(), 2):
            got = _alike(one, other)
            if got:
                expected = f"a record of its own in each file of test '{owner[1]}'"
                yield Fault(other.source.path, got, expected, "a copy repeats nothing: name every record once")


def _alike(one: Table, other: Table) -> str:
    """What of one table stands in another of the same columns too; nothing where the two are parts of one file."""
    if one.source.path == other.source.path:
        return ""
    if one.source.sha256 == other.source.sha256:
        return f"the content of '{one.source.path}' a second time"
    names = sorted((one.numbers.keys() & other.numbers.keys()) - {"time"})
    if not names:
        return ""
    rows, sought = (np.column_stack([table.numbers[name] for name in names]) for table in (one, other))
    if _holds(rows, sought):
        return f"readings '{', '.join(names)}' of '{one.source.path}' a second time"
    return ""


def _holds(rows: Rows, sought: Rows) -> bool:
    """Whether a stretch from the middle of a record stands in another one, reading by reading.

    A stretch in which many readings are like the one before says nothing: channels at rest, or held.
    """
    middle = len(sought) // 2
    window = sought[middle : middle + WINDOW]
    at_rest = (np.diff(window, axis=0) == 0).all(axis=1)
    if len(window) < WINDOW or len(rows) < WINDOW or at_rest.sum() > WINDOW // 4:
        return False
    same = DIGITS * np.ptp(rows, axis=0)
    starts = np.flatnonzero((abs(rows[: len(rows) - WINDOW + 1] - window[0]) <= same).all(axis=1))
    return any(bool((abs(rows[start : start + WINDOW] - window) <= same).all()) for start in starts)
