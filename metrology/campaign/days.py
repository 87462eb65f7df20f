"""Days in the future: a date that cannot be, since what it dates has been done."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date
from typing import TYPE_CHECKING

from metrology.message import said

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign


def today() -> date:
    """Return the day by the clock of this computer."""
    return date.today()


def ahead(campaign: Campaign) -> Iterator[str]:
    """Say which tests, certificates and reports are dated after today."""
    dated: list[tuple[str, date | None]] = [
        *((name, test.date) for name, test in campaign.tests.items()),
        *(
            (said("certificate of {name}", name=name), one.certificate.date)
            for name, one in campaign.instruments.items()
            if one.certificate is not None
        ),
        (said("issue of the report"), campaign.report.issued),
    ]
    now = today()
    late = tuple(
        said("{what}, {day}", what=what, day=day.isoformat()) for what, day in dated if day is not None and day > now
    )
    if late:
        yield said("Dated in the future: {days}. One of the dates is wrong, or the clock of this computer.", days=late)
