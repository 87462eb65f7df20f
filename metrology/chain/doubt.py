"""One failed check on the way to a result, and what the laboratory says where it accepts it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from metrology.message import said

if TYPE_CHECKING:
    from metrology.declaration.acceptance import Acceptance


@dataclass(frozen=True)
class Doubt:
    """A failed check on the way to a result.

    Parameters
    ----------
    check : str
        Its name, by which the laboratory may accept it.
    sentence : str
        What failed, of which test.
    covered : bool
        Whether the uncertainty covers what failed, so that a fail stands and only a pass is forbidden.
    acceptance : str
        Reason and person, where the laboratory accepts it.
    concerns : tuple of str
        Quantities of its test that it says something of; empty where it is all.
    shape : bool
        Whether it is of the shape of a distribution alone: value and standard uncertainty hold, and so does a verdict
        that no distribution with them could change.
    accepted : Acceptance, optional
        The acceptance as the campaign states it.
    """

    check: str
    sentence: str
    covered: bool = False
    acceptance: str = ""
    concerns: tuple[str, ...] = ()
    shape: bool = False
    accepted: Acceptance | None = None

    def bars(self, verdict: str) -> bool:
        """Whether it forbids a verdict."""
        return not self.acceptance and not (self.covered and "fail" in verdict)


def with_acceptance(doubt: Doubt, accepted: Acceptance | None) -> Doubt:
    """A doubt with what the laboratory says where it accepts it."""
    if accepted is None:
        return doubt
    text = "{sentence} Accepted by {by}: {reason}."
    words = said(text, sentence=doubt.sentence, by=accepted.by, reason=accepted.reason)
    return replace(doubt, acceptance=words, accepted=accepted)
