"""The languages of a report: messages looked up in catalogues of gettext, numbers with the decimal sign chosen."""

from __future__ import annotations

import gettext
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from string import Formatter
from typing import TYPE_CHECKING, Any

from metrology.language import display, wording
from metrology.message import JOINTS, English, Sentence, Value, lowered, parts

if TYPE_CHECKING:
    from metrology.findings import Findings, Message

LOCALE = Path(__file__).with_name("locale")
DOMAIN = "metrology"
_FIGURES = re.compile(r"(?<=\d)\.(?=\d)")
_SHOWN: Mapping[str, Callable[[Any], str]] = {
    "number": display.number, "number 4": lambda value: display.number(value, 4),
    "normalised": display.normalised, "percent": display.percent, "chance": display.chance,
}  # fmt: skip
"""Formats of numbers in messages besides those of Python."""
_OWN_POINT = re.compile(r"(\{[^}]*\})|(?<=\d)\.(?=\d)")
"""Points between figures of a text that are none of a measured number: of a clause, a version; fields are left out."""
_KEPT = "\N{ONE DOT LEADER}"
"""Stands for such a point until the numbers have their decimal sign."""
LONG = 10_000
"""Counts from which on digits stand in groups of three (ISO 80000-1, 7.3.1)."""
_NO_LOWERING = ("de",)
"""Languages in which a title within a sentence keeps its capital: it begins with a noun."""


@dataclass(frozen=True)
class Language:
    """One language of a report.

    Parameters
    ----------
    code : str
        ``de``.
    comma : bool
        Whether decimals follow a comma.
    messages : mapping of str to Message
        By English text: what sentences of `results.json` were made of.
    """

    code: str = "en"
    comma: bool = False
    messages: Mapping[str, Message] = field(default_factory=dict)

    def say(self, message: str, /, **values: Value) -> str:
        """A message with its values."""
        return self._formatted(self.word(message), values)

    def count(self, one: str, many: str, /, count: int, **values: Value) -> str:
        """A message that depends on a count."""
        return self._formatted(self.plural(one, many, count), {"count": count, **values})

    def plural(self, one: str, many: str, count: int) -> str:
        """The form of a message that goes with a count, without its values."""
        return read(self.code).ngettext(one, many, count)

    def word(self, message: str, context: str = "") -> str:
        """A message without values; one that the catalogue lacks, such as a name, stays as it is."""
        if not message:
            return message
        known = read(self.code)
        return known.pgettext(context, message) if context else known.gettext(message)

    def spoken(self, text: str) -> str:
        """A sentence of the findings; a text of the campaign stays as it is."""
        made = text if isinstance(text, Sentence) else self.messages.get(text)
        if made is None:
            return text if (own := self.word(text)) == text else self.figures(own)
        if self.code == "en" and not self.comma:
            return wording.prose(text)
        message = self.word(made.message)
        if made.plural:
            message = self.plural(made.message, made.plural, made.values["count"])  # type: ignore[arg-type]
        # As a whole: what a number is printed as hangs on the words before it.
        whole = _Whole(self).vformat(_own_points(message), (), made.values)
        return self.figures(wording.prose(whole)).replace(_KEPT, ".")

    def quoted(self, text: str) -> str:
        """A sentence of the findings; one that the catalogue lacks as it is, with the remark that it is English."""
        spoken = self.spoken(text)
        if self.code == "en" or spoken != text or text in self.messages:
            return spoken
        return self.say("(in English) {text}", text=text)

    def lowered(self, title: str) -> str:
        """A title of the findings within a sentence."""
        text = self.spoken(title)
        return text if self.code in _NO_LOWERING else lowered(text)

    def figures(self, text: str) -> str:
        """A number, or several, with the decimal sign of the report."""
        return _FIGURES.sub(",", text) if self.comma else text

    def _formatted(self, message: str, values: Mapping[str, Value]) -> str:
        return _Words(self).vformat(message, (), values)


class _Words(English):
    """Formats the values of a message in a language."""

    def __init__(self, language: Language) -> None:
        self._language = language

    def format_field(self, value: Any, spec: str) -> str:
        """Text of one value: `lowered` a title within a sentence, `figures` a number, `quoted` what may be English."""
        language = self._language
        if isinstance(value, tuple):
            kind, _, joint = spec.rpartition(" ")
            return language.word(JOINTS[joint]).join(map(language.lowered if kind else language.spoken, value))
        if isinstance(value, str):
            return _text(language, value, spec)
        shown = _SHOWN[spec](value) if spec in _SHOWN else wording.prose(super().format_field(value, spec))
        return language.figures(shown)


class _Whole(_Words):
    """The same for a sentence in which numbers are set afterwards, all at once."""

    def format_field(self, value: Any, spec: str) -> str:
        """Text of one value, as the message asks for it; points of texts are marked as their own."""
        if isinstance(value, tuple) or (isinstance(value, str) and spec != "figures"):
            return _own_points(super().format_field(value, spec))
        if isinstance(value, int) and not spec and value >= LONG:
            return display.grouped(value)
        return _SHOWN[spec](value) if spec in _SHOWN else English.format_field(self, value, spec)


def _own_points(text: str) -> str:
    return _OWN_POINT.sub(lambda found: found[1] or _KEPT, text)


def _text(language: Language, value: str, spec: str) -> str:
    if spec == "figures":
        return language.figures(value)
    said = {"lowered": language.lowered, "quoted": language.quoted}.get(spec, language.spoken)
    return said(value)


ENGLISH = Language()


def stored(findings: Findings) -> tuple[Message, ...]:
    """What the sentences were made of that a report can say in another language: those that are no message as it is."""
    from metrology.findings import Message

    made = {
        str(one): one
        for text in _sentences(findings)
        for one in parts(text)
        if one.message != one and not _is_alone(one)
    }
    return tuple(Message(text, one.message, one.plural, _as_printed(one)) for text, one in made.items())


def _as_printed(one: Sentence) -> dict[str, Value]:
    """The values of a sentence, numbers with the digits that it prints: further ones differ between processors."""
    asked: dict[str, set[str]] = {"count": set()} if one.plural else {}
    for text in (one.message, one.plural):
        for _, name, spec, _ in Formatter().parse(text):
            asked.setdefault(name or "", set()).add(spec or "")
    return {name: _to_digits(value, asked[name]) for name, value in one.values.items() if name in asked}


def _to_digits(value: Value, specs: set[str]) -> Value:
    """A number as its one format has it; any other value as it is."""
    spec = next(iter(specs)) if len(specs) == 1 else ""
    if not isinstance(value, float) or spec[-1:] not in ("e", "f", "g", "%"):
        return value
    return float(format(value, spec).removesuffix("%")) / (100.0 if spec.endswith("%") else 1.0)


def _is_alone(one: Sentence) -> bool:
    """Whether a sentence is one of its own values and nothing more, so that it says nothing of how it was made."""
    return any(one == value or (isinstance(value, tuple) and one in value) for value in one.values.values())


def _sentences(value: Any) -> Iterator[Sentence]:
    """Every sentence in records, tables and lists; lists of numbers are not looked through."""
    if isinstance(value, Sentence):
        yield value
    elif is_dataclass(value):
        for one in fields(value):
            yield from _sentences(getattr(value, one.name))
    elif isinstance(value, Mapping):
        for one in value.values():
            yield from _sentences(one)
    elif isinstance(value, tuple | list) and not (value and isinstance(value[0], int | float)):
        for one in value:
            yield from _sentences(one)


def languages(findings: Findings) -> tuple[Language, ...]:
    """The languages of a campaign's report, the first one first."""
    campaign = findings.campaign
    messages = english(findings).messages
    return tuple(Language(code, campaign.decimal_sign == "comma", messages) for code in campaign.languages)


def english(findings: Findings) -> Language:
    """English as of the findings, whether they were evaluated or read from a file."""
    return Language("en", messages={one.text: one for one in findings.messages})


@cache
def read(code: str) -> gettext.NullTranslations:
    """The catalogue of a language, read as translators edit it."""
    if code == "en":
        return gettext.NullTranslations()
    from babel.messages.mofile import write_mo
    from babel.messages.pofile import read_po

    compiled = BytesIO()
    with (LOCALE / code / "LC_MESSAGES" / f"{DOMAIN}.po").open("rb") as file:
        write_mo(compiled, read_po(file, locale=code))
    compiled.seek(0)
    return gettext.GNUTranslations(compiled)
