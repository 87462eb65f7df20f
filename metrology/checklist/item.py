"""One item of a checklist, and the same filled in."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

from metrology.checklist.record import Record
from metrology.message import said

MOST_NAMED = 4
"""Places that are named one by one where an item is missing; more are counted."""


@dataclass(frozen=True)
class Row:
    """An item of a checklist as a campaign fills it.

    Parameters
    ----------
    clause : str
        Of the standard.
    asks : str
        What it asks.
    key : str
        Where the campaign file gives it; empty where the report gives it by itself.
    section : str
        Template of the section that shows it, ``cover`` for page 1, ``page`` for every page.
    state : {"given", "missing", "not applicable"}
    reason : str
        What is missing, or why the item does not apply.
    """

    clause: str
    asks: str
    key: str
    section: str
    state: Literal["given", "missing", "not applicable"]
    reason: str = ""


@dataclass(frozen=True)
class Item:
    """An item of a checklist: `lacks` names the places that are missing, `spared` says why the item does not apply."""

    clause: str
    asks: str
    key: str
    section: str
    lacks: Callable[[Record], Iterable[str]] = lambda _record: ()
    spared: Callable[[Record], str] = lambda _record: ""

    def fill(self, record: Record) -> Row:
        """Return the item as a campaign fills it."""
        if reason := self.spared(record):
            return Row(self.clause, self.asks, self.key, self.section, "not applicable", reason)
        missing = tuple(self.lacks(record))
        if missing:
            return Row(self.clause, self.asks, self.key, self.section, "missing", _listed(missing))
        return Row(self.clause, self.asks, self.key, self.section, "given")


def _listed(missing: tuple[str, ...]) -> str:
    if len(missing) <= MOST_NAMED:
        return said("not stated: {places:comma}", places=missing)
    more = len(missing) - MOST_NAMED
    return said("not stated: {places:comma} and {count} more", places=missing[:MOST_NAMED], count=more)
