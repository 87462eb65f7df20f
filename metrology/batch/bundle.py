"""A campaign as bytes that travel: its file, the readings that it names, and where all of them lie."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from metrology.campaign import branding, calibration, own, results_file
from metrology.campaign.readings import inside
from metrology.declaration import document
from metrology.errors import Fault, MetrologyError
from metrology.readings.packed import MAX_BYTES

SUFFIXES = ((), (calibration.SUFFIX, results_file.SUFFIX, own.SUFFIX))
"""What `inside` lets a campaign read: readings, and what its other loaders take."""


@dataclass(frozen=True)
class Bundle:
    """A campaign on its way to a worker.

    Parameters
    ----------
    path : Path
        The campaign file, as the user named it.
    identity : str
        The campaign's id; empty where it has none that could name a folder.
    place : str
        The campaign file from the folder that holds everything.
    home : str
        The folder of its report, likewise.
    files : mapping
        Everything that the campaign reads, path from that folder to content.
    """

    path: Path
    identity: str
    place: str
    home: str
    files: Mapping[str, bytes]


def pack(path: Path, output: Path) -> Bundle:
    """Return the campaign with every file that it can read, whether or not it can be made.

    Raises
    ------
    MetrologyError
        For a campaign file, or readings, that cannot be read.
    """
    stated = document.read(path)
    data = stated.data if isinstance(stated.data, dict) else {}
    identity = _identity(data)
    own = path.resolve()
    contents = {own: stated.raw}
    other = _extended(path, data)
    if other is not None:
        contents[other] = _content(other)
    folder = (other or own).parent
    contents |= {
        folder / name: _content(folder / name) for name in sorted(set(_texts(data))) if _readable(folder, name)
    }
    contents |= {look.resolve(): _content(look) for _, look in branding.named(folder, data)}
    home = (output / (identity or "campaign")).resolve()
    root = os.path.commonpath([*(file.parent for file in contents), home])
    files = {os.path.relpath(file, root): content for file, content in contents.items()}
    return Bundle(path, identity, os.path.relpath(own, root), os.path.relpath(home, root), files)


def folders(path: Path) -> set[Path]:
    """Return the folders below which everything lies that a campaign reads: its own, and that of a file it extends."""
    own = path.resolve()
    try:
        data = document.read(path).data
    except MetrologyError:
        return {own.parent}
    other = _extended(path, data) if isinstance(data, dict) else None
    return {own.parent} | ({other.parent} if other is not None else set())


def _identity(data: Mapping[str, Any]) -> str:
    from pydantic import TypeAdapter, ValidationError

    from metrology.declaration.scalars import Id

    try:
        return str(TypeAdapter(Id).validate_python(data.get("id")))
    except ValidationError:
        return ""


def _extended(path: Path, data: Mapping[str, Any]) -> Path | None:
    """Path of the campaign file that this one extends, as `metrology.campaign.extension` allows it."""
    stated = data.get("extends")
    if not isinstance(stated, str) or Path(stated).is_absolute() or any(letter in stated for letter in "\\:\0"):
        return None
    other = path.parent / stated
    try:
        data = document.read(other).data
    except MetrologyError:
        return None
    # What is no campaign file goes nowhere: that it is none is for the worker to say.
    return other.resolve() if isinstance(data, dict) and "format" in data else None


def _texts(data: object) -> Iterator[str]:
    if isinstance(data, str):
        yield data
    elif isinstance(data, dict):
        for value in data.values():
            yield from _texts(value)
    elif isinstance(data, list):
        for value in data:
            yield from _texts(value)


def _readable(folder: Path, name: str) -> bool:
    """Whether a text of the campaign names a file that a campaign may read; what does not is for the worker to say."""
    for suffixes in SUFFIXES:
        with suppress(ValueError, OSError):
            return inside(folder, name, suffixes).is_file()
    return False


def _content(path: Path) -> bytes:
    """The content, or so much of it that it will be refused as too large."""
    try:
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise MetrologyError(Fault(str(path), f"a file that cannot be read ({error.strerror})", "readings")) from None


@contextmanager
def unpacked(packed: Bundle) -> Iterator[Path]:
    """A folder that holds the files of a campaign, for as long as it is needed."""
    with TemporaryDirectory(prefix="metrology-") as name:
        root = Path(name).resolve()
        for path, content in packed.files.items():
            file = root / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        yield root


def named(packed: Bundle, root: Path, text: str) -> str:
    """Return a message about unpacked files with the paths that the user knows."""
    own = str((root / packed.place).parent)
    return text.replace(own, str(packed.path.parent)).replace(f"{root}{os.sep}", "")
