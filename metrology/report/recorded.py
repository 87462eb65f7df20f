"""What is written by a report enters the audit trail in its folder, in the same step as the files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from metrology import audit_trail
from metrology.report import staging


def line(folder: Path, command: str, files: Mapping[str, bytes], *, detail: str = "") -> dict[str, bytes]:
    """The trail of a folder with a line for what a command writes, by its name; for `staging.replace_folder`.

    Raises
    ------
    MetrologyError
        Where the trail is damaged.
    """
    path = folder / audit_trail.NAME
    return {audit_trail.NAME: audit_trail.extended(audit_trail.content(path), command, files, detail=detail)}


def add(folder: Path, command: str, files: Mapping[str, bytes], *, detail: str = "") -> bool:
    """Add a line to the trail of a folder that has one; say whether it has.

    Raises
    ------
    MetrologyError
        Where the trail is damaged, or cannot be written.
    """
    path = folder / audit_trail.NAME
    if not path.exists():
        return False
    with staging.locked(path):
        staging.replace_file(path, line(folder, command, files, detail=detail)[audit_trail.NAME])
    return True
