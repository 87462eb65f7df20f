"""How far the Monte Carlo evaluation of a campaign goes."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from metrology.declaration.entry import Entry
from metrology.declaration.scalars import Integer, ranged

Digits = Annotated[Integer, ranged(1, 4, "1, 2, 3 or 4 significant digits of u", closed=True)]
Trials = Annotated[Integer, ranged(1000, 10**7, "1000 to 10000000 trials", closed=True)]


class MonteCarlo(Entry):
    """How far the Monte Carlo evaluation goes (JCGM 101:2008, 7.9)."""

    digits: Digits = Field(
        default=2,
        description="Significant digits of u to which results and intervals are made stable, 1 to 4.",
        examples=["3"],
    )
    max_trials: Trials = Field(
        default=1000000,
        description="Trials after which it stops, 1000 to 10000000; the report says whether it was stable. At most "
        "10⁴/(1 − p) where the parameters of a curve are drawn: each trial is a fit.",
        examples=["10000000"],
    )
