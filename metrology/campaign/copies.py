"""Records that are copies of one another: a second name makes no second measurement."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from metrology.errors import Fault

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign


def check_copies(campaign: Campaign) -> Iterator[Fault]:
    """Files of one test with the same content under two names: a copy repeats nothing and verifies nothing."""
    for owner, tables in campaign.tables.items():
        first: dict[str, str] = {}
        for source in dict.fromkeys(table.source for table in tables):
            if source.sha256 in first and owner[0] == "tests":
                got = f"the content of '{first[source.sha256]}' a second time"
                expected = f"a record of its own in each file of test '{owner[1]}'"
                yield Fault(source.path, got, expected, "a copy repeats nothing: name every record once")
            first.setdefault(source.sha256, source.path)
