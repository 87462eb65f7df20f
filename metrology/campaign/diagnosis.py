"""What a campaign file says of its diagnosis: nothing, that there is none, what is tried and what is not."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pydantic import Field

from metrology.declaration.entry import Entry, Refusal, mean
from metrology.declaration.scalars import Filled, Flag

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign


class Diagnose(Entry):
    """How the tests are diagnosed: every test with a model and data is, where nothing is said."""

    off: Flag = Field(False, description="`true`: no test is diagnosed.", examples=["true"])
    without: tuple[Filled, ...] = Field(
        (),
        description="Causes that are not tried in response tests, by their names in the report.",
        examples=["[yaw, sag]"],
    )
    effects: tuple[Filled, ...] = Field(
        (),
        description="Python files of the campaign that declare effects of the laboratory's own (`docs/extend.md`); "
        "run only where the command says `--allow-code`.",
        examples=["[magnet.py]"],
    )


def check_diagnosis(campaign: Campaign) -> Iterator[Refusal]:
    """Causes that nobody would try, and causes named twice."""
    if not campaign.diagnosis.without:
        return
    from metrology.diagnostics.candidate import RESPONSE as TABLE

    stated = campaign.diagnosis.without
    for index, name in enumerate(stated):
        place = ("diagnosis", "without", index)
        if name not in TABLE:
            near = mean(name, list(TABLE)) or f"known are {', '.join(TABLE)}"
            yield Refusal(place, f"'{name}', an unknown cause", "a cause that is tried in response tests", near, name)
        elif name in stated[:index]:
            yield Refusal(place, f"'{name}' a second time", "every cause once")
