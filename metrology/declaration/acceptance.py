"""Why a result is judged in spite of what speaks against it, and who says so."""

from __future__ import annotations

from pydantic import Field

from metrology.declaration.entry import Entry
from metrology.declaration.scalars import Filled


class Acceptance(Entry):
    """In spite of what speaks against it a result is judged: why, and who says so; printed with the verdict."""

    reason: Filled = Field(description="Why results may be judged all the same.", examples=["below 1 % of k"])
    by: Filled = Field(description="Who accepts it.", examples=["A. Smith"])
