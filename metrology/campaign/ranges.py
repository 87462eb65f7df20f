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
    from metrology.declaration.quantity import Stated

MAX_FAULTS = 20
_SLACK = 1e-9  # of the range: what binary fractions may add to a reading at its end


def check_ranges(campaign: Campaign) -> Iterator[Fault]:
    """Readings in use that no instrument of the declared range can have shown, the first twenty of each file."""
    for name, test in campaign.tests.items():
        unused = {exclusion.line for exclusion in test.exclusions if exclusion.line is not None}
        left_out = {exclusion.file for exclusion in test.exclusions if exclusion.line is None}
        method, tables = METHODS[test.method], iter(campaign.tables.get(("tests", name), ()))
        fix = f"exclude {f'the {method.whole}' if method.whole else 'it'} with a reason, or correct the range"
        for files in method.readings(name, test):
            for table in islice(tables, len(files.files)):
                if table.name not in left_out:
                    for column, instrument in files.ranges.items():
                        for what, ends in _bounds(campaign, instrument):
                            for where, got in islice(_beyond(ends, table, column, unused), MAX_FAULTS):
                                expected = f"a reading within {what}, {ends[0].value} to {ends[1].value}"
                                yield Fault(where, got, expected, fix)


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
