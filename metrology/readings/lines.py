"""The lines of a text of readings, some at a time: a list of all of them needs ten times the memory of the text."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from metrology.readings.sheet import refused

MAX_LINE = 10_000
MAX_NOTES = 1000
_BLOCK = 1 << 20


def end(text: str) -> int:
    """Where the last line ends that is not blank."""
    stop = len(text)
    while not text[(start := text.rfind("\n", 0, stop) + 1) : stop].strip() and start:
        stop = start - 1
    return stop


def below_notes(path: Path, text: str, stop: int) -> tuple[int, int]:
    """Where the heading begins, and its line.

    Raises
    ------
    MetrologyError
        For more than 1000 lines of notes above it.
    """
    start, number = 0, 1
    while text.startswith("#", start) and (after := text.find("\n", start, stop)) >= 0:
        start, number = after + 1, number + 1
        if number > MAX_NOTES:
            raise refused(f"{path}:{number}", f"more than {MAX_NOTES} lines of notes", "a heading line")
    return start, number


def one(path: Path, text: str, start: int, number: int) -> str:
    """The line that begins at a place.

    Raises
    ------
    MetrologyError
        Where it is longer than 10 000 characters.
    """
    line = text[start : _line_end(text, start, len(text))]
    _refuse_wide(path, line, number)
    return line


def blocks(path: Path, text: str, span: tuple[int, int], number: int) -> Iterator[tuple[list[str], int]]:
    """Lines between two places, about a million characters at a time, and the number of the first of them.

    Raises
    ------
    MetrologyError
        For a line of more than 10 000 characters.
    """
    start, stop = span
    while start <= stop:
        after = _line_end(text, min(start + _BLOCK, stop), stop)
        block = text[start:after].split("\n")
        if max(map(len, block)) > MAX_LINE:
            for at, line in enumerate(block, start=number):
                _refuse_wide(path, line, at)
        yield block, number
        start, number = after + 1, number + len(block)


def _refuse_wide(path: Path, line: str, number: int) -> None:
    if len(line) > MAX_LINE:
        raise refused(f"{path}:{number}", f"a line of {len(line)} characters", f"at most {MAX_LINE}")


def _line_end(text: str, start: int, stop: int) -> int:
    found = text.find("\n", start, stop)
    return found if found >= 0 else stop
