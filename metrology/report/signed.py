"""A signed report is never lost: made again alike it stays as it is, and another one does not take its place."""

from __future__ import annotations

from pathlib import Path

from metrology.errors import Fault, MetrologyError

MARK = b"/ByteRange"
"""Every signature has one; what else a report of ours holds is compressed, or no such key."""


def kept(path: Path, made: bytes | None) -> bytes | None:
    """What shall stand at `path`: `made`, or the file there where that is `made` with signatures; None for nothing.

    Raises
    ------
    MetrologyError
        Where the file there is signed and begins with something else.
    """
    older = path.read_bytes() if path.is_file() else b""
    if MARK not in older:
        return made
    if made is not None and older.startswith(made):
        return older
    raise MetrologyError(
        Fault(
            str(path),
            "a signed report of other content",
            "no signed report, or this very one",
            "move it away to keep it, and give the new report a number of its own (`report.replaces` names the older)",
        )
    )
