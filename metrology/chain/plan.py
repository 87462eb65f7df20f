"""What a campaign is evaluated from: its measurement model, and what was fitted and tested on the way to it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from metrology.method.model import Identity, Model

if TYPE_CHECKING:
    from metrology.declaration.acceptance import Acceptance
    from metrology.findings import Fit, TestItem
    from metrology.gum.evaluation import Contribution

__all__ = ["Identity", "Plan", "Suspect"]


@dataclass(frozen=True)
class Suspect:
    """What forbids that a number is judged; `accepted`: why it is judged all the same."""

    sentence: str
    accepted: Acceptance | None = None


@dataclass
class Plan(Model):
    """The model with what is shown of fits and tests; `ready`: each test as its method prepared it.

    `corrected`: by test, what the model as stated contributed, and what the one that the data support put in its place.
    `suspect`: by input or result, what is wrong with the readings that it comes from, or with their use.
    `imported`: names of the inputs that are results of other campaigns, by what their components say of the source.
    """

    fits: list[Fit] = field(default_factory=list)
    tests: list[TestItem] = field(default_factory=list)
    ready: dict[str, Any] = field(default_factory=dict)
    suspect: dict[str, tuple[Suspect, ...]] = field(default_factory=dict)
    imported: dict[str, tuple[str, ...]] = field(default_factory=dict)
    corrected: dict[str, tuple[Contribution, Contribution]] = field(default_factory=dict)
