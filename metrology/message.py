"""A sentence that can be said again in another language: English text that knows its message and its values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from string import Formatter
from typing import Any, Literal

Code = Literal["en", "de", "fr", "it", "es"]
"""Languages that a report can be in, by ISO 639."""
Value = str | int | float | tuple[str, ...]
"""What a message takes: numbers as they are, names and further sentences as texts, lists of these."""
JOINTS = {"": "; ", "comma": ", ", "stroke": " / ", "or": " or ", "space": " "}
"""How the items of a list are joined, by the format that a message asks for: ``{names:comma}``."""
NAMES = ("Coulomb", "Zener", "Bouc–Wen", "Boltzmann")
"""Names with which a title may begin, and which stay as they are."""


class Sentence(str):
    """English text, made of `message` and `values`; `plural` is the message for a count that is not one."""

    message: str
    plural: str
    values: Mapping[str, Value]


class English(Formatter):
    """Formats as `str.format` does, lists too: ``{names}`` joins with semicolons, ``{names:comma}`` with commas."""

    def format_field(self, value: Any, spec: str) -> str:
        """Text of one value; ``lowered`` is a title within a sentence, ``figures`` a number that is a text already."""
        if isinstance(value, tuple):
            kind, _, joint = spec.rpartition(" ")
            return JOINTS[joint].join(map(lowered, value) if kind else value)
        if isinstance(value, str):
            return lowered(value) if spec == "lowered" else value
        return str(super().format_field(value, spec))


_ENGLISH = English()


def said(message: str, /, **values: Value) -> Sentence:
    """A message of the catalogue with its values, as an English sentence.

    Examples
    --------
    >>> text = said("{name} has no value.", name="k")
    >>> text, text.message
    ('k has no value.', '{name} has no value.')
    """
    return _made(message, "", message, values)


def counted(one: str, many: str, /, count: int, **values: Value) -> Sentence:
    """A message that depends on a count, which it can name ``{count}``.

    Examples
    --------
    >>> counted("{count} run", "{count} runs", 3)
    '3 runs'
    """
    return _made(one if count == 1 else many, many, one, {"count": count, **values})


def _made(text: str, plural: str, message: str, values: Mapping[str, Value]) -> Sentence:
    made = Sentence(_ENGLISH.vformat(text, (), values))
    made.message, made.plural, made.values = message, plural, dict(values)
    return made


def lowered(title: str) -> str:
    """The title within a sentence: its first letter small, unless a name or an abbreviation begins it."""
    first = title.split(" ")[0].removesuffix(":")
    return title if first in NAMES or first[1:] != first[1:].lower() else title[:1].lower() + title[1:]


def parts(text: str) -> Iterator[Sentence]:
    """A sentence and those among its values."""
    if isinstance(text, Sentence):
        yield text
        for value in text.values.values():
            for one in value if isinstance(value, tuple) else (value,):
                if isinstance(one, str):
                    yield from parts(one)
