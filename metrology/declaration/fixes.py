"""Edits that put a fault right without a judgement: where one thing alone can be meant, and no value changes by it.

Every edit names what it takes away, and is left out where the file holds something else there.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from typing import TYPE_CHECKING

import yaml

from metrology.errors import Edit

if TYPE_CHECKING:
    from metrology.declaration.document import Document
    from metrology.declaration.entry import Refusal

FORMAT = "format: metrology-campaign/1\n"
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
MARK = b"\xef\xbb\xbf"


def plain(raw: bytes) -> bytes:
    """The bytes of a file without a byte order mark, its lines ended as on Unix, the last one too."""
    text = raw.removeprefix(MARK).replace(b"\r\n", b"\n")
    return text if text.endswith(b"\n") or not text else text + b"\n"


def apply(text: str, edits: Iterable[Edit]) -> str:
    """Make the edits in a text; of two at one place the first."""
    lines = text.split("\n")
    taken: set[tuple[int, int]] = set()
    for edit in sorted(edits, key=lambda one: (one.line, one.column), reverse=True):
        line, at = lines[edit.line - 1], edit.column - 1
        if (edit.line, edit.column) not in taken and line.startswith(edit.old, at):
            taken.add((edit.line, edit.column))
            lines[edit.line - 1] = line[:at] + edit.new + line[at + len(edit.old) :]
    return "\n".join(lines)


def indentation(number: int, line: str, width: int | None) -> Edit | None:
    """Spaces for the tabs that a line begins with; a tab behind them may stand in a text."""
    old = line[: len(line) - len(line.lstrip(" \t"))]
    return Edit(number, 1, old, old.expandtabs(width)) if "\t" in old and width else None


def tab_width(text: str) -> int | None:
    """Columns of a tab with which the fewest keys stay empty; None where several widths give different content."""
    # A value that is no YAML says nothing of the indentation.
    read = _read(text) or _read(_VALUE.sub(r"\1 x", text))
    least = min((_empty(content) for content in read.values()), default=0)
    best = {width: content for width, content in read.items() if _empty(content) == least}
    return min(best) if best and len(set(best.values())) == 1 else None


_VALUE = re.compile(r"""^([ \t]*(?:- )*[^\s:#{['"-][^:\n]*:)[ \t]+[^\s#].*$""", re.MULTILINE)


def _read(text: str) -> dict[int, tuple[object, ...]]:
    """Width of a tab → what the text holds with it, for those with which it is YAML."""
    read = {}
    for width in (2, 4, 8):
        with suppress(yaml.YAMLError):
            read[width] = _content(text.expandtabs(width))
    return read


def _content(text: str) -> tuple[object, ...]:
    return tuple((type(event), getattr(event, "value", None)) for event in yaml.parse(text, Loader=_LOADER))


def _empty(content: tuple[object, ...]) -> int:
    return content.count((yaml.ScalarEvent, ""))


def in_quotes(text: str, row: int) -> Edit:
    """The value of a line in quotes, without a comment that follows it."""
    line = text.split("\n")[row]
    key, _, value = line.partition(": ")
    bare = re.split(r"\s#", value)[0].strip()
    quote = "'" if '"' in bare or "\\" in bare else '"'
    written = bare.replace("'", "''") if quote == "'" else bare
    return Edit(row + 1, len(key) + 3 + value.index(bare), bare, f"{quote}{written}{quote}")


def comma(raw: bytes, at: tuple[int, int], written: str) -> Edit | None:
    """A point for the decimal comma of a number between braces, where YAML has taken the comma for the end."""
    from metrology.units.decimals import pointed

    found = pointed(written)
    return None if found is None else _at(raw, at, *found)


def edit(document: Document, refusal: Refusal) -> Edit | None:
    """The edit that fixes what is refused; None where there is no such."""
    place = refusal.loc
    if place == ("format",) and place not in document.positions and document.keys:
        line, column = min(document.keys.values())
        return Edit(line, column, "", FORMAT) if column == 1 else None
    if refusal.swap is None:
        return None
    at = (document.keys if refusal.of_key else document.positions).get(document.locate(place))
    return None if at is None else _at(document.raw, at, *refusal.swap)


def _at(raw: bytes, at: tuple[int, int], old: str, new: str) -> Edit | None:
    """The one place where `old` stands as a word of its own in the entry that begins at a line and a column."""
    lines = raw.removeprefix(MARK).decode("utf-8", "replace").split("\n")
    entry = re.split(r"[,}\]#:](?=\s|$)", lines[at[0] - 1][at[1] - 1 :])[0]
    found = [match.start() for match in re.finditer(rf"(?<!\w){re.escape(old)}(?!\w)", entry)]
    return Edit(at[0], at[1] + found[0], old, new) if len(found) == 1 else None
