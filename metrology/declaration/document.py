"""A YAML file as texts, lists and mappings, each node with its line and column; whatever could be misread is refused.

YAML has many ways to mean something other than what is written: ``no`` is a truth value, ``12:30:00`` the number 45000,
``0123`` is 83; aliases grow a page into gigabytes, tags run code. Here every scalar stays the text that was written,
and the field that receives it decides what it means; anchors, aliases, tags, merge keys, duplicate keys and empty
values are faults.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unicodedata import normalize

import yaml

from metrology.declaration import fixes
from metrology.declaration.source_text import MAX_FAULTS, read_raw, syntax_fault, text_of
from metrology.declaration.split import COMMA, Split
from metrology.errors import Edit, Fault, MetrologyError

MAX_DEPTH = 20
MAX_NODES = 100_000
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_NOTHING = frozenset({"", "~", "null", "Null", "NULL"})

Key = str | int
Place = tuple[Key, ...]


GUESS = "# guess"
"""How `metrology import` marks what nobody has stated."""


@dataclass
class Document:
    """A file's content with the place of every node.

    Parameters
    ----------
    path : Path
        As the user gave it; messages begin with it.
    raw : bytes
        The file's bytes.
    data : dict, list or str
        Mappings, lists and text only; None where a node was refused (its fault is in `faults`).
    positions : dict
        Place of an entry, such as ``("tests", "a", "loads", 2)``, to its line and column (from 1): a text's own, for a
        list or a mapping that of its key.
    faults : list
        Line and column, and the fault: duplicate keys, anchors, aliases, tags and empty values.
    spoiled : set
        Places whose data is not to be judged any further, since a fault stands there already.
    attached : mapping
        Files of readings that come with it and lie nowhere, by their name.
    """

    path: Path
    raw: bytes = b""
    data: Any = None
    positions: dict[Place, tuple[int, int]] = field(default_factory=dict)
    keys: dict[Place, tuple[int, int]] = field(default_factory=dict)
    faults: list[tuple[tuple[int, int], Fault]] = field(default_factory=list)
    spoiled: set[Place] = field(default_factory=set)
    attached: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def notices(self) -> tuple[str, ...]:
        """What was read although it is not as documented, or nobody confirmed it."""
        found = ["it begins with a byte order mark."] if self.raw.startswith(b"\xef\xbb\xbf") else []
        guesses = sum(GUESS.encode() in line for line in self.raw.splitlines())
        if guesses:
            some = "an entry is" if guesses == 1 else f"{guesses} entries are"
            found.append(f"{some} marked as a guess, which nobody has confirmed: correct it, or take the mark away.")
        return tuple(f"{self.path.name}: {sentence}" for sentence in found)

    def locate(self, place: Place) -> Place:
        """Return the part of `place` that stands in the file; what the file does not have is passed over."""
        found: Place = ()
        for key in place:
            if (*found, key) in self.positions:
                found = (*found, key)
        return found

    def at(self, *place: Key, key: bool = False) -> str:
        """Where `place` stands, ``campaign.yaml:14:9 tests.a.loads[2]``, or what is nearest where it is absent."""
        found = self.locate(place)
        line, column = (self.keys if key else self.positions).get(found) or self.positions.get(found, (1, 1))
        return f"{self.path}:{line}:{column} {spell(found)}".rstrip()

    def order(self, place: Place) -> tuple[int, int]:
        """Line and column, to sort faults by."""
        return self.positions.get(self.locate(place), (1, 1))

    def is_spoiled(self, place: Place) -> bool:
        """Whether a fault already stands at `place` or above it."""
        found = self.locate(place)
        return any(found[:length] in self.spoiled for length in range(len(found) + 1))


def spell(place: Place) -> str:
    """Write a place as a person would: ``tests.a.loads[2]``."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place)
    return text.removeprefix(".")


def read(path: Path) -> Document:
    """Read the YAML file `path`.

    Raises
    ------
    MetrologyError
        The file cannot be read, is larger than 1 MiB, is not UTF-8, holds tabs, is not YAML, or is nested deeper than
        20 levels.
        Faults that leave the rest readable are kept in the document.
    """
    return parse(path, read_raw(path))


def parse(path: Path, raw: bytes) -> Document:
    """Read the content of a YAML file; `path` is what messages call it. Errors as for `read`."""
    text = text_of(path, raw)
    try:
        document = _Composer(Document(path, raw), yaml.parse(text, Loader=_LOADER)).compose()
    except yaml.YAMLError as error:
        raise MetrologyError(syntax_fault(path, text, error)) from None
    return document


class _Composer:
    """Builds a `Document` from YAML events, one level of recursion a level of nesting, within the limits."""

    def __init__(self, document: Document, events: Iterator[Any]) -> None:
        self.document = document
        self.events = events
        self.nodes = 0

    def compose(self) -> Document:
        """Read the stream, which holds one document."""
        next(self.events)
        event = next(self.events)
        if isinstance(event, yaml.StreamEndEvent):
            raise MetrologyError(
                Fault(f"{self.document.path}:1:1", "an empty file", "entries, the first of them 'format:'")
            )
        self.document.data = self._node(next(self.events), ())
        next(self.events)
        event = next(self.events)
        if not isinstance(event, yaml.StreamEndEvent):
            raise MetrologyError(
                Fault(self._where(event), "a second document", "one campaign a file", "remove the line '---'")
            )
        return self.document

    def _where(self, event: Any, place: Place = ()) -> str:
        mark = event.start_mark
        return f"{self.document.path}:{mark.line + 1}:{mark.column + 1} {spell(place)}".rstrip()

    def _refuse(
        self, event: Any, place: Place, got: str, expected: str, fix: str = "", edit: Edit | None = None
    ) -> None:
        if len(self.document.faults) < MAX_FAULTS:
            position = (event.start_mark.line + 1, event.start_mark.column + 1)
            self.document.faults.append((position, Fault(self._where(event, place), got, expected, fix, edit)))
        self.document.spoiled.add(place)

    def _node(self, event: Any, place: Place) -> Any:
        self._count(event, place)
        self.document.positions.setdefault(place, (event.start_mark.line + 1, event.start_mark.column + 1))
        if isinstance(event, yaml.AliasEvent):
            self._refuse(event, place, f"the alias '*{event.anchor}'", "the value itself", "write the value out")
            return None
        if event.anchor is not None:
            self._refuse(event, place, f"the anchor '&{event.anchor}'", "the value alone", "remove the anchor")
        if event.tag is not None:
            self._refuse(event, place, f"the tag '{event.tag}'", "a value without a tag", "remove the tag")
        if isinstance(event, yaml.ScalarEvent):
            return self._scalar(event, place)
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(place)
        return self._mapping(place, Split() if event.flow_style else None)

    def _count(self, event: Any, place: Place) -> None:
        self.nodes += 1
        if self.nodes > MAX_NODES:
            raise MetrologyError(
                Fault(
                    self._where(event),
                    f"more than {MAX_NODES} entries",
                    "a smaller campaign",
                    "keep readings in CSV files",
                )
            )
        if len(place) > MAX_DEPTH:
            raise MetrologyError(Fault(self._where(event), f"more than {MAX_DEPTH} levels", "a campaign as documented"))

    def _scalar(self, event: Any, place: Place) -> str | None:
        if not event.style and event.value in _NOTHING:
            self._refuse(
                event,
                place,
                "an empty value",
                "a value",
                "write the value, leave the key out, or indent what stands below and belongs to it",
            )
            return None
        return normalize("NFC", str(event.value))

    def _sequence(self, place: Place) -> list[Any]:
        items: list[Any] = []
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            items.append(self._node(event, (*place, len(items))))
        return items

    def _mapping(self, place: Place, split: Split | None) -> dict[str, Any]:
        entries: dict[str, Any] = {}
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            key = self._key(event, place)
            twice, below = key in entries, (*place, key)
            value_event = next(self.events)
            if split and split.takes(event, value_event):
                continue
            self._tell_split(split, entries, place)
            if twice:
                self._refuse(event, below, f"'{key}' a second time", "every key once", "keep one of the two")
            else:
                self._remember_key(event, below)
            if split:
                split.begin(event, value_event)
            if not twice and isinstance(value_event, yaml.SequenceStartEvent | yaml.MappingStartEvent):
                self.document.positions[below] = self.document.keys[below]
            value = self._node(value_event, below)
            entries.setdefault(key, value)
        self._tell_split(split, entries, place)
        return entries

    def _tell_split(self, split: Split | None, entries: dict[str, Any], place: Place) -> None:
        """Refuse a number that YAML split at a decimal comma between braces; as it was meant, it raises no more."""
        if split and len(split.parts) > 1:
            got = f"'{','.join(split.parts)}', a comma as decimal mark"
            at = (split.event.start_mark.line + 1, split.event.start_mark.column + 1)
            edit = fixes.comma(self.document.raw, at, ",".join(split.parts))
            self._refuse(split.event, (*place, split.key), got, f"'{'.'.join(split.parts)}'", COMMA, edit)
            entries[split.key], split.parts = ".".join(split.parts), []

    def _remember_key(self, event: Any, place: Place) -> None:
        self.document.keys[place] = (event.start_mark.line + 1, event.start_mark.column + 1)

    def _key(self, event: Any, place: Place) -> str:
        self._count(event, place)
        if not isinstance(event, yaml.ScalarEvent) or event.tag is not None or event.anchor is not None:
            raise MetrologyError(Fault(self._where(event, place), "a key that is no plain word", "'key: value'"))
        if event.value == "<<" and not event.style:
            self._refuse(event, place, "the merge key '<<'", "the entries themselves", "write them out")
        return normalize("NFC", str(event.value))
