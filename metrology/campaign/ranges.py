"""What readings must fulfil beside their form: they stand within the range that their instrument declares."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from metrology import units
from metrology.errors import Fault
from metrology.methods import METHODS

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.columns import Table
    from metrology.declaration.conduct import Test
    from metrology.declaration.quantity import Stated
    from metrology.method import Files

MAX_FAULTS = 20
_SLACK = 1e-9  # of the range: what binary fractions may add to a reading at its end


def check_ranges(campaign: Campaign) -> Iterator[Fault]:
    """Readings in use that nothing can have shown: beyond the instrument's range, or beyond the sample's length."""
    for name, test in campaign.tests.items():
        unused = {exclusion.line for exclusion in test.exclusions if exclusion.line is not None}
        left_out = {exclusion.file for exclusion in test.exclusions if exclusion.line is None}
        for files, table in _tables(campaign, name, test):
            if table.name not in left_out:
                yield from _off_range(campaign, METHODS[test.method].whole, files, table, unused)
                yield from _off_length(campaign, test, files, table, unused)


def _tables(campaign: Campaign, name: str, test: Test) -> Iterator[tuple[Files, Table]]:
    """Tables of a test, each with the files of the method that it belongs to."""
    tables = iter(campaign.tables.get(("tests", name), ()))
    for files in METHODS[test.method].readings(name, test):
        yield from ((files, table) for table in islice(tables, len(files.files)))


def _off_range(campaign: Campaign, whole: str, files: Files, table: Table, unused: set[int]) -> Iterator[Fault]:
    fix = f"exclude {f'the {whole}' if whole else 'it'} with a reason, or correct the range"
    for column, instrument in files.ranges.items():
        for what, ends in _bounds(campaign, instrument):
            found = list(_beyond(ends, table, column, unused))
            more = len(found) - MAX_FAULTS
            for at, (where, got) in enumerate(found[:MAX_FAULTS], 1):
                got = f"{got}, and {more} more" if at == MAX_FAULTS and more > 0 else got
                yield Fault(where, got, f"a reading within {what}, {ends[0].value} to {ends[1].value}", fix)


def _off_length(campaign: Campaign, test: Test, files: Files, table: Table, unused: set[int]) -> Iterator[Fault]:
    """Readings that span as much as the sample is long: a strain of 100 % that no line under test bears."""
    sample = campaign.samples.get(test.sample)
    if not files.stretch or sample is None or sample.length is None:
        return
    used = table.numbers[files.stretch][~np.isin(table.lines, list(unused))]
    span = float(np.nanmax(used) - np.nanmin(used)) if np.isfinite(used).any() else 0.0
    if span >= sample.length.si:
        got = f"{files.stretch}s that span {span:.4g} m, of a sample {sample.length.si:.4g} m long"
        yield Fault(str(table.path), got, "a strain below 100 %", "check the unit in the heading, and single readings")


def _bounds(campaign: Campaign, instrument: str) -> Iterator[tuple[str, tuple[Stated, Stated]]]:
    """What bounds the readings of an instrument: its range, and the readings at which it was calibrated."""
    declared = campaign.instruments.get(instrument)
    if declared is not None and declared.range is not None:
        yield f"the range of '{instrument}'", declared.range
    if declared is not None and declared.certificate is not None and declared.certificate.valid is not None:
        yield f"the range of validity of certificate {declared.certificate.number}", declared.certificate.valid


def _beyond(ends: tuple[Stated, Stated], table: Table, column: str, unused: set[int]) -> Iterator[tuple[str, str]]:
    """Place and text of every reading beyond the ends."""
    low, high = ends
    if low.dimension != units.dimension(table.units[column]):
        return
    slack = _SLACK * (high.si - low.si)
    values, unit = table.numbers[column], table.units[column]
    for row in np.flatnonzero((values < low.si - slack) | (values > high.si + slack)):
        if int(table.lines[row]) not in unused:
            got = f"'{values[row] / units.factor(unit):.12g} {unit}'"
            yield table.at(int(row), column), got
