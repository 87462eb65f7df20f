"""What can still be judged of a faulty campaign file, so that a user sees all its faults at once and not in rounds.

Entries with a fault are taken out, and the rest is checked as a campaign of its own. What the rest says about entries
that were taken out (an unknown sample, which is only misspelled further up) is not passed on.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from metrology.campaign.document import Place
from metrology.campaign.entry import Refusal

_STANDINS = {"format": "metrology-campaign/1", "id": "unnamed", "title": "untitled"}


@dataclass
class Rest:
    """The entries of a file that have no fault.

    Parameters
    ----------
    data : dict
        The entries.
    kept : mapping of str to list of int
        Place in the file of each entry of a list.
    lost : set of str
        Names that the entries taken out declare; None where they cannot be told.
    """

    data: dict[str, Any]
    kept: dict[str, list[int]] = field(default_factory=dict)
    lost: set[str] | None = field(default_factory=set)

    def passed_on(self, found: Iterable[Refusal]) -> list[Refusal]:
        """Refusals of the rest, with their places in the file, without those that concern what was taken out."""
        return [replace(refusal, loc=self._place(refusal.loc)) for refusal in found if not self._is_about_lost(refusal)]

    def _place(self, loc: Place) -> Place:
        if len(loc) > 1 and isinstance(loc[1], int) and loc[0] in self.kept:
            return (loc[0], self.kept[str(loc[0])][loc[1]], *loc[2:])
        return loc

    def _is_about_lost(self, refusal: Refusal) -> bool:
        if not refusal.missing:
            return False
        return self.lost is None or bool({refusal.missing, refusal.missing.partition(".")[0]} & self.lost)


def without(data: Any, places: Sequence[Place]) -> Rest | None:
    """Take out the entries in which `places` lie; None where nothing is left to judge."""
    if not isinstance(data, dict):
        return None
    rest = Rest(dict(data))
    for section in {place[0] for place in places if place}:
        entries = data.get(str(section))
        inner = {place[1] for place in places if len(place) > 1 and place[0] == section}
        whole = any(place == (section,) for place in places)
        if (
            whole
            or not inner
            or not isinstance(entries, dict | list)
            or section in ("report", "laboratory", "customer")
        ):
            rest.data.pop(str(section), None)
            if isinstance(entries, dict | list) and section not in ("report", "laboratory", "customer"):
                rest.lost = None
        elif isinstance(entries, dict):
            rest.data[str(section)] = {key: value for key, value in entries.items() if key not in inner}
            _note(rest, [(key, entries[key]) for key in inner if key in entries])
        else:
            rest.kept[str(section)] = [index for index in range(len(entries)) if index not in inner]
            rest.data[str(section)] = [entries[index] for index in rest.kept[str(section)]]
            _note(rest, [("", entries[index]) for index in inner if isinstance(index, int)])
    rest.data = _STANDINS | rest.data
    return rest


def _note(rest: Rest, entries: Sequence[tuple[Any, Any]]) -> None:
    """Remember the names that entries taken out declare."""
    if rest.lost is None:
        return
    for key, entry in entries:
        rest.lost.add(str(key))
        if not isinstance(entry, dict):
            continue
        if isinstance(columns := entry.get("columns"), dict):
            rest.lost |= columns.keys()
        rest.lost |= {f"{entry.get('sample')}.{entry.get('quantity')}", str(entry.get("quantity"))}
