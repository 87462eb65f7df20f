"""Numbers with a decimal comma between braces, where YAML takes the comma for the end: ``{width: 0,01 mm}``."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import yaml

_WHOLE = re.compile(r"[+-]?[0-9]+")
_FRACTION = re.compile(r"[0-9]")
COMMA = "between braces and brackets a comma ends the entry; the decimal mark is a point"


@dataclass
class Split:
    """A value between braces, and the entries after it that are the rest of its number: ``0``, ``01 mm``."""

    key: str = ""
    event: Any = None
    parts: list[str] = field(default_factory=list)

    def begin(self, key: Any, value: Any) -> None:
        """Take note of an entry."""
        number = isinstance(value, yaml.ScalarEvent) and not value.style and _WHOLE.fullmatch(value.value)
        self.key, self.event, self.parts = str(key.value), value, [value.value] if number else []

    def takes(self, key: Any, value: Any) -> bool:
        """Whether an entry without a value goes on where the number before it ends; it is taken if so."""
        empty = isinstance(value, yaml.ScalarEvent) and not value.style and value.value == ""
        follows = bool(empty and self.parts and self.parts[-1][-1:].isdigit() and _FRACTION.match(key.value))
        self.parts += [key.value] if follows else []
        return follows
