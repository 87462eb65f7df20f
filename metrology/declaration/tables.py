"""Readings: CSV files with units in their headings, plain or gzipped, read strictly and quickly into SI."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

from metrology.declaration.columns import Column, SourceFile, Table, source_file
from metrology.declaration.lines import refused
from metrology.declaration.rows import Reader
from metrology.errors import MetrologyError

__all__ = ["Column", "SourceFile", "Table", "read"]

MAX_BYTES = 64 * 1024 * 1024


def read(path: Path, columns: Sequence[Column], *, others: bool = False) -> Table:
    """Read a CSV file, plain or gzipped, that has the stated columns.

    Parameters
    ----------
    path : Path
        Ends in ``.csv`` or ``.csv.gz``. UTF-8, cells separated by commas, a point as decimal mark, one heading line;
        lines that begin with ``#`` above the heading are notes.
    columns : sequence of Column
        In any order.
    others : bool
        Whether the file may have further columns, which are passed over.

    Raises
    ------
    MetrologyError
        With the line of each fault, the first 20 of them.
    """
    text, source = _text(path)
    return Reader(path, columns, others=others).read(text, source)


def _text(path: Path) -> tuple[str, SourceFile]:
    """The text and the hash of a file; its bytes are not kept, as they would lie beside the text."""
    raw = _stored(path)
    source = source_file(path.name, raw)
    return _decoded(path, _expanded(path, raw)), source


def _stored(path: Path) -> bytes:
    try:
        if path.exists() and not path.is_file():
            raise refused(path, "no plain file", "a CSV file with readings")
        if path.exists() and path.stat().st_size > MAX_BYTES:
            raise _too_large(path)
        with path.open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise refused(path, "no such file", "a CSV file with readings") from None
    except OSError as error:
        raise refused(path, f"a file that cannot be read ({error.strerror})", "a CSV file with readings") from None
    return _limited(path, raw)


def _limited(path: Path, raw: bytes) -> bytes:
    if len(raw) > MAX_BYTES:
        raise _too_large(path)
    return raw


def _too_large(path: Path) -> MetrologyError:
    mend = "split the file, or lower the rate: keep every n-th sample of a record that was filtered before"
    return refused(
        path, "a file that is too large", f"at most {MAX_BYTES >> 20} MiB of readings a file, unpacked", mend
    )


def _expanded(path: Path, raw: bytes) -> bytes:
    if path.suffix != ".gz":
        return raw
    try:
        with gzip.open(BytesIO(raw)) as file:
            return _limited(path, file.read(MAX_BYTES + 1))
    except (OSError, EOFError, zlib.error):
        raise refused(path, "a damaged or truncated gzip file", "a whole .csv.gz file", "copy the file again") from None


def _decoded(path: Path, raw: bytes) -> str:
    if raw.startswith(b"\xef\xbb\xbf"):
        raise refused(
            f"{path}:1", "a byte order mark", "UTF-8 without it", "save the file as UTF-8 without a byte order mark"
        )
    try:
        text = raw.replace(b"\r\n", b"\n").decode("utf-8")
    except UnicodeDecodeError as error:
        where = f"{path}:{raw.count(10, 0, error.start) + 1}"
        raise refused(where, f"byte 0x{raw[error.start]:02x}", "text in UTF-8", "save the file as UTF-8") from None
    for character, name in (("\0", "a null character"), ("\r", "a carriage return without a line feed")):
        if character in text:
            raise refused(f"{path}:{text.count(chr(10), 0, text.index(character)) + 1}", name, "lines of plain text")
    if not text or text.isspace():
        raise refused(path, "an empty file", "a heading line and readings")
    return text
