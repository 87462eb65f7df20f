"""What readings must fulfil beside their form: they stand within the range that their instrument declares."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from metrology import units
from metrology.campaign.methods import DecayTest, ElongationTest
from metrology.errors import Fault

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.campaign.tables import Table

MAX_FAULTS = 20
_SLACK = 1e-9  # of the range: what binary fractions may add to a reading at its end


def check_ranges(campaign: Campaign) -> Iterator[Fault]:
    """Readings in use that no instrument of the declared range can have shown, the first twenty of each file."""
    for name, test in campaign.tests.items():
        if isinstance(test, ElongationTest):
            column, instrument = "reading", test.instruments.extension
            mend = "exclude it with a reason, or correct the range"
        elif isinstance(test, DecayTest):
            column, instrument = test.column[0], test.instruments.displacement
            mend = "exclude the release with a reason, or correct the range"
        else:
            continue
        unused = {exclusion.line for exclusion in test.exclusions if exclusion.line is not None}
        left_out = {exclusion.file for exclusion in test.exclusions if exclusion.line is None}
        for table in campaign.tables.get(("tests", name), ()):
            if table.source.path in left_out:
                continue
            for where, got, ends in islice(_beyond(campaign, instrument, table, column, unused), MAX_FAULTS):
                yield Fault(where, got, f"a reading within the range of '{instrument}', {ends}", mend)


def _beyond(
    campaign: Campaign, instrument: str, table: Table, column: str, unused: set[int]
) -> Iterator[tuple[str, str, str]]:
    """Place and text of every reading beyond the range, and the range as written."""
    declared = campaign.instruments.get(instrument)
    if declared is None or declared.range is None or declared.range[0].dimension != units.dimension("m"):
        return
    low, high = declared.range
    slack = _SLACK * (high.si - low.si)
    values, unit = table.numbers[column], table.units[column]
    for row in np.flatnonzero((values < low.si - slack) | (values > high.si + slack)):
        if int(table.lines[row]) not in unused:
            got = f"'{values[row] / units.factor(unit):.12g} {unit}'"
            yield table.at(int(row), column), got, f"{low.value} to {high.value}"
