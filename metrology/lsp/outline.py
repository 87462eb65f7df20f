"""The keys of a campaign file that is being written: whatever can be told of a text that is not YAML yet."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from metrology.declaration.document import Place

_KEY = re.compile(r"""(?P<quote>["']?)(?P<key>[^\s\[\]{},:#"'-][^\[\]{}:#"'\n]*?)(?P=quote)[ ]*:(?=\s|$)""")
_FLOW = re.compile(
    r"""[ ]+
    | (?P<quoted> "[^"]*"? | '[^']*'?)
    | (?P<mark> [\[\]{},:])
    | (?P<plain> [^\[\]{},:"'\ ] (?: [^\[\]{},:\ ] | :(?!\ |$) | [ ](?![ #]) )*)""",
    re.VERBOSE,
)


@dataclass(frozen=True)
class Entry:
    """A key: where it stands (row and column from 0), and the text behind it."""

    place: Place
    row: int
    column: int
    value: str = ""


@dataclass
class _Open:
    """A bracket that is not closed yet: of a mapping, or of a list with `count` entries before this one."""

    place: Place
    listed: bool
    count: int = 0
    key: str | None = None
    word: str = ""

    @property
    def inner(self) -> Place:
        """Place of what is written now."""
        if self.listed:
            return (*self.place, self.count)
        return self.place if self.key is None else (*self.place, self.key)


class Outline:
    """Reads a text line by line; `entries` are its keys, and `here`, `word` and `of_value` say where it ends.

    Parameters
    ----------
    text : str
        A campaign file, or its part before the cursor.
    """

    def __init__(self, text: str) -> None:
        self.entries: list[Entry] = []
        self._block: list[tuple[int, Place, bool]] = []
        self._counts: dict[Place, int] = {}
        self._flow: list[_Open] = []
        self._literal: int | None = None
        self.here: Place = ()
        self.word, self.of_value = "", False
        for row, line in enumerate(text.split("\n")):
            self._line(row, line)

    def _line(self, row: int, line: str) -> None:
        column = len(line) - len(line.lstrip(" "))
        if self._literal is not None and (not line.strip() or column > self._literal):
            self.here, self.word, self.of_value = (), "", True
            return
        self._literal = None
        if not line.strip() or (not self._flow and line.lstrip().startswith("#")):
            above = [place for at, place, _ in self._block if at < column]
            self.here = self._flow[-1].inner if self._flow else above[-1] if above else ()
            self.word, self.of_value = "", bool(line.strip())
        elif self._flow:
            self._brackets(row, line, 0)
        else:
            self._entry(row, line, column)

    def _entry(self, row: int, line: str, column: int) -> None:
        """Read a line outside of brackets."""
        while re.match(r"-(\s|$)", line[column:]):
            self._close(column, listed=True)
            parent = self._block[-1][1] if self._block else ()
            self._counts[parent] = self._counts.get(parent, -1) + 1
            self._block.append((column, (*parent, self._counts[parent]), True))
            column += 1 + len(line[column + 1 :]) - len(line[column + 1 :].lstrip(" "))
        self._close(column, listed=False)
        parent = self._block[-1][1] if self._block else ()
        found = _KEY.match(line, column)
        if found is None:
            self.here, self.word, self.of_value = parent, line[column:].strip(), False
            if line[column : column + 1] in {"{", "["}:
                self._brackets(row, line, column, parent)
            return
        place = (*parent, found["key"])
        self.entries.append(Entry(place, row, found.start("key")))
        self._block.append((column, place, False))
        self._value(row, line, found.end(), place)

    def _close(self, column: int, *, listed: bool) -> None:
        """Leave what stands further to the right; a list may begin below its key, in the same column."""
        while self._block and (
            self._block[-1][0] > column or (self._block[-1][0] == column and (not listed or self._block[-1][2]))
        ):
            self._block.pop()

    def _value(self, row: int, line: str, column: int, place: Place) -> None:
        rest = re.split(r"(?:^|\s)#", line[column:])[0]
        value = rest.strip()
        self.here, self.word, self.of_value = place, value, True
        if value[:1] in {"{", "["}:
            self._brackets(row, line, column + rest.index(value[0]), place)
            return
        self.entries[-1] = replace(self.entries[-1], value=value)
        if value[:1] in {"|", ">"}:
            self._literal = self._block[-1][0]

    def _brackets(self, row: int, line: str, column: int, place: Place = ()) -> None:
        """Read on between braces and brackets; `place`: of the one that begins here, where none is open yet."""
        for found in _FLOW.finditer(line, column):
            mark, word = found["mark"], (found["quoted"] or found["plain"] or "").strip("\"'")
            if word.startswith("#"):
                break
            if mark in {"{", "["}:
                inner = self._flow[-1].inner if self._flow else place
                self._flow.append(_Open(inner, mark == "["))
            elif mark in {"}", "]"}:
                self._flow.pop()
                if not self._flow:
                    return
            elif mark or word:
                self._within(self._flow[-1], mark, word, (row, found.start() + (found["quoted"] is not None)))
        top = self._flow[-1]
        self.here, self.word, self.of_value = top.inner, top.word, top.listed or top.key is not None

    def _within(self, top: _Open, mark: str | None, word: str, at: tuple[int, int]) -> None:
        if mark == ",":
            top.count, top.key, top.word = top.count + 1, None, ""
        elif mark == ":" and not top.listed and top.key is None:
            top.key, top.word = top.word, ""
        elif word and not top.listed and top.key is None:
            top.word = word
            self.entries.append(Entry((*top.place, word), *at))
        elif word:
            top.word = word
            if not top.listed:
                self.entries[-1] = replace(self.entries[-1], value=word)
