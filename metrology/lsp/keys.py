"""What the JSON Schema of campaign files says of a place in one: the keys and words it takes, and what they mean."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from metrology.declaration.document import Place

Node = Mapping[str, Any]


class Keys:
    """The schema, read beside a file: `values` are its texts by place, which say what kind of entry one is.

    Examples
    --------
    >>> keys = Keys({("samples", "a", "section", "shape"): "round"})
    >>> sorted(keys.of(("samples", "a", "section")))
    ['diameter', 'shape']
    >>> keys.meaning(("samples", "a", "section", "diameter"))["description"]
    'Diameter d.'
    """

    def __init__(self, values: Mapping[Place, str]) -> None:
        self.values = values
        self.schema = _schema()

    def of(self, place: Place) -> dict[str, Node]:
        """Return the keys that an entry can have, each with what the schema says of it."""
        found: dict[str, Node] = {}
        for node in self._nodes(place):
            for key, what in node.get("properties", {}).items():
                found.setdefault(key, what)
        return found

    def words(self, place: Place) -> tuple[str, ...]:
        """Return the words that can stand at a place, where they are given."""
        found: list[str] = []
        if place:
            parents = self._nodes(place[:-1], whole=True)
            for node in (one["properties"][place[-1]] for one in parents if place[-1] in one.get("properties", {})):
                found += (word for part in self._parts(node, place, whole=True) for word in _listed(part))
        for node in self._nodes(place):
            found += _listed(node)
        return tuple(dict.fromkeys(found))

    def meaning(self, place: Place) -> Node | None:
        """Return what the schema says of the key at a place; None where it knows no such key."""
        key = place[-1]
        return self.of(place[:-1]).get(key) if isinstance(key, str) else None

    def _nodes(self, place: Place, *, whole: bool = False) -> list[Node]:
        """Every part of the schema that an entry may have to follow."""
        nodes = list(self._parts(self.schema, (), whole=False))
        for length, key in enumerate(place, start=1):
            last = whole and length == len(place)
            nodes = [
                part
                for node in nodes
                for below in _below(node, key)
                for part in self._parts(below, place[:length], whole=last)
            ]
        return nodes

    def _parts(self, node: Node, place: Place, *, whole: bool) -> Iterator[Node]:
        """Resolve references and choices; of a choice by a key the one that the file names, all of them if `whole`."""
        if "$ref" in node:
            yield from self._parts(self.schema["$defs"][node["$ref"].rpartition("/")[2]], place, whole=whole)
            return
        choice = node.get("discriminator")
        named = choice and choice["mapping"].get(self.values.get((*place, choice["propertyName"])))
        if named and not whole:
            yield from self._parts({"$ref": named}, place, whole=whole)
            return
        for part in (*node.get("anyOf", ()), *node.get("oneOf", ()), *node.get("allOf", ())):
            yield from self._parts(part, place, whole=whole)
        yield node


@cache
def _schema() -> Node:
    from metrology.campaign.json_schema import schema_json

    found: Node = json.loads(schema_json())
    return found


def _below(node: Node, key: str | int) -> Iterator[Node]:
    """What a part of the schema says of one key, or of an entry of a list."""
    if isinstance(key, int):
        listed = node.get("prefixItems", ())
        yield from listed[key : key + 1]
        if isinstance(node.get("items"), Mapping) and key >= len(listed):
            yield node["items"]
    elif key in node.get("properties", {}):
        yield node["properties"][key]
    else:
        yield from (what for pattern, what in node.get("patternProperties", {}).items() if re.search(pattern, key))
        if isinstance(node.get("additionalProperties"), Mapping):
            yield node["additionalProperties"]


def _listed(node: Node) -> tuple[str, ...]:
    if node.get("type") == "boolean":
        return ("true", "false")
    words = node.get("enum", (node["const"],) if "const" in node else ())
    return tuple(word for word in words if isinstance(word, str))


def described(key: str, node: Node) -> str:
    """Return what is known of a key, in Markdown."""
    example = next((one for one in node.get("examples", ()) if isinstance(one, str)), "")
    text = f"**{key}**: {node.get('description', '')}".rstrip(": ")
    shown = f"\n\nSuch as:\n```yaml\n{key}: {example}\n```" if example else ""
    default = node.get("default")
    return text + shown + (f"\n\nDefault: `{default}`" if default not in (None, "", {}, []) else "")
