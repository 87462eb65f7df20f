"""What can still be judged of a faulty campaign file, so that a user sees all its faults at once and not in rounds.

Entries with a fault are taken out, and the rest is checked as a campaign of its own. What the rest says about entries
that were taken out (an unknown sample, which is only misspelled further up) is not passed on.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal

_STANDINS = {"format": "metrology-campaign/1", "id": "unnamed", "title": "untitled"}


@dataclass
class Rest:
    """The entries of a file that have no fault.

    Parameters
    ----------
    data : dict
        The entries.
    kept : mapping of place to list of int
        Place in the file of each entry of a list.
    lost : set of str
        Names that the entries taken out declare; None where they cannot be found.
    """

    data: dict[str, Any]
    kept: dict[Place, list[int]] = field(default_factory=dict)
    lost: set[str] | None = field(default_factory=set)

    def passed_on(self, found: Iterable[Refusal]) -> list[Refusal]:
        """Refusals of the rest, with their places in the file, without those that concern what was taken out."""
        return [replace(refusal, loc=self._place(refusal.loc)) for refusal in found if not self._is_about_lost(refusal)]

    def _place(self, loc: Place) -> Place:
        for length in range(1, len(loc)):
            index = loc[length]
            if isinstance(index, int) and loc[:length] in self.kept:
                return (*loc[:length], self.kept[loc[:length]][index], *loc[length + 1 :])
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
            fixed = _exclusions(rest, entries, [place for place in places if place[:1] == ("tests",)])
            inner -= fixed.keys()
            rest.data[str(section)] = {key: value for key, value in entries.items() if key not in inner} | fixed
            _note(rest, [(key, entries[key]) for key in inner if key in entries])
        else:
            kept = rest.kept[section,] = [index for index in range(len(entries)) if index not in inner]
            rest.data[str(section)] = [entries[index] for index in kept]
            _note(rest, [("", entries[index]) for index in inner if isinstance(index, int)])
    rest.data = _STANDINS | rest.data
    return rest


def _exclusions(rest: Rest, tests: dict[str, Any], places: Sequence[Place]) -> dict[str, Any]:
    """Tests whose only faults lie in exclusions: with those that say a line, whatever else is wrong with them."""
    fixed = {}
    for name, test in tests.items():
        inside = [place for place in places if len(place) > 1 and place[1] == name]
        if not isinstance(test, dict) or not isinstance(test.get("exclusions"), list):
            continue
        if not inside or any(len(place) < 4 or place[2] != "exclusions" for place in inside):
            continue
        inside_of = {place[3]: place[4:5] for place in inside}
        lineless = {place[3] for place in inside if place[4:5] in (("line",), ("file",))}
        items = {index: item for index, item in enumerate(test["exclusions"]) if index not in lineless}
        items = {index: _bare(item) if index in inside_of else item for index, item in items.items()}
        whole = {index: item for index, item in items.items() if item is not None}
        rest.kept["tests", name, "exclusions"] = list(whole)
        fixed[name] = test | {"exclusions": list(whole.values())}
    return fixed


def _bare(item: Any) -> dict[str, Any] | None:
    """An exclusion as its file and line alone, where it has one of them."""
    if not isinstance(item, dict) or not {"file", "line"} & item.keys():
        return None
    return {key: item[key] for key in ("file", "line") if key in item} | {"reason": "not judged"}


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
