"""A campaign file as text: of limited size, in UTF-8, without tabs; and what is said of one that is no YAML."""

from __future__ import annotations

from pathlib import Path

import yaml

from metrology.declaration import fixes
from metrology.errors import Fault, MetrologyError

MAX_BYTES = 1024 * 1024
MAX_FAULTS = 100


def read_raw(path: Path) -> bytes:
    """Return the bytes of a campaign file, as many as show that it is too large. Errors as for `document.read`."""
    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            raise MetrologyError(Fault(str(path), "a device or a pipe", "a campaign file, which is a plain file"))
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise MetrologyError(_unreadable(path, error)) from None


def text_of(path: Path, raw: bytes) -> str:
    """The text of a file from its bytes. Errors as for `document.read`."""
    if len(raw) > MAX_BYTES:
        raise MetrologyError(
            Fault(
                str(path), "a file of more than 1 MiB", "a campaign file of at most 1 MiB", "keep readings in CSV files"
            )
        )
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise MetrologyError(
            Fault(f"{path}:{line}", f"byte 0x{raw[error.start]:02x}", "text in UTF-8", "save the file as UTF-8")
        ) from None
    _refuse_characters(path, text)
    return text


def _unreadable(path: Path, error: OSError) -> Fault:
    if isinstance(error, FileNotFoundError):
        return Fault(str(path), "no such file", "a campaign file", "metrology new NAME writes a starter campaign")
    if isinstance(error, IsADirectoryError):
        return Fault(str(path), "a folder", "a campaign file", "name the campaign.yaml in it")
    return Fault(str(path), f"a file that cannot be read ({error.strerror})", "a readable campaign file")


def _refuse_characters(path: Path, text: str) -> None:
    width = fixes.tab_width(text) if "\t" in text else None
    faults = [
        Fault(
            f"{path}:{number}:{line.index(chr(9)) + 1}",
            "a tab",
            "spaces",
            "indent with two spaces",
            fixes.indentation(number, line, width),
        )
        for number, line in enumerate(text.split("\n"), start=1)
        if "\t" in line
    ]
    if faults:
        raise MetrologyError(*faults[:MAX_FAULTS])


def syntax_fault(path: Path, text: str, error: yaml.YAMLError) -> Fault:
    """What is reported of a text that YAML cannot read, with its place and how to mend it."""
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    if mark is None:
        where = f"{path}:{text.count(chr(10), 0, getattr(error, 'position', 0)) + 1}"
        return Fault(where, "a character that YAML does not allow", "printable text")
    if fix := _colon(text.split("\n")[mark.line : mark.line + 1], getattr(error, "problem", "") or ""):
        where = f"{path}:{mark.line + 1}:{mark.column + 1}"
        expected = "a text in quotes where it holds ': '"
        edit = fixes.in_quotes(text, mark.line)
        return Fault(where, "a second colon in a text without quotes", expected, fix, edit)
    problem = getattr(error, "problem", None) or "something that YAML does not allow"
    fix = "check indentation, colons, brackets and quotation marks here and on the line above"
    return Fault(
        f"{path}:{mark.line + 1}:{mark.column + 1}", f"text that is not YAML ({problem})", "'key: value' entries", fix
    )


def _colon(lines: list[str], problem: str) -> str:
    """How a text with a colon is written, where that is what YAML stumbles over; else nothing."""
    key, colon, value = (lines[0] if lines else "").partition(": ")
    if "mapping values are not allowed" not in problem or not colon or ":" not in value:
        return ""
    quote = "'" if '"' in value else '"'
    return f"put the text in quotes: {key.strip()}: {quote}{value.strip()}{quote}"
