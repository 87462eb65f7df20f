"""What a file of readings must hold, and what was read from it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

Floats = np.ndarray[tuple[int], np.dtype[np.float64]]
Integers = np.ndarray[tuple[int], np.dtype[np.int64]]


@dataclass(frozen=True)
class Column:
    """What a column must hold.

    Parameters
    ----------
    name : str
        Word before the solidus of the heading, ``"reading"`` of ``reading / mm``; or a whole heading, with its solidus.
    unit : str or None
        A unit of the dimension that is due, such as ``"m"``; any dimension where None.
    kind : {"number", "text"}
        Texts have no unit.
    required : bool
        Whether the file must have the column.
    gaps : bool
        Whether cells may be empty: NaN.
    increasing : bool
        Whether each number must be greater than the one before, as time stamps are.
    varies : bool
        Whether a column of equal numbers is a fault, as that of a dead channel.
    choices : tuple of str
        Texts that are allowed; any where empty.
    """

    name: str
    unit: str | None = None
    kind: Literal["number", "text"] = "number"
    required: bool = True
    gaps: bool = False
    increasing: bool = False
    varies: bool = False
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class SourceFile:
    """A file that went in: path from the campaign's folder, SHA-256 and size of its bytes."""

    path: str
    sha256: str
    bytes: int


def source_file(path: str, raw: bytes) -> SourceFile:
    """Return the entry of a file with this content."""
    return SourceFile(path, hashlib.sha256(raw).hexdigest(), len(raw))


@dataclass(frozen=True)
class Table:
    """The readings of one file.

    Parameters
    ----------
    path : Path
        The file.
    numbers : mapping of str to ndarray, shape (n,)
        In SI, read-only, by the name of the column as it was asked for; NaN is a gap.
    texts : mapping of str to tuple of str
        Likewise of the columns with texts.
    units : mapping of str to str
        Unit of each column of numbers as the heading has it.
    lines : ndarray of int, shape (n,)
        Line of the file on which each row stands; the first line is 1.
    source : SourceFile
        Hash of the bytes that were read.
    part : str
        What of the file was read, such as a sheet; nothing for the whole of it.
    notices : tuple of str
        What was done to read a file that is not as documented.
    date : str
        Day of the measurement where the file states it, ``2026-10-05``.
    """

    path: Path
    numbers: Mapping[str, Floats]
    texts: Mapping[str, tuple[str, ...]]
    units: Mapping[str, str]
    lines: Integers
    source: SourceFile
    part: str = ""
    notices: tuple[str, ...] = ()
    date: str = ""

    @property
    def name(self) -> str:
        """What campaign files and reports call these readings: path from the campaign's folder, and the part."""
        return f"{self.source.path} [{self.part}]" if self.part else self.source.path

    def __len__(self) -> int:
        return len(self.lines)

    def at(self, row: int, column: str = "") -> str:
        """Where a row stands: ``readings.csv:14 reading``."""
        return f"{self.path}:{self.lines[row]} {column}".rstrip()
