"""`metrology check --fix`: mechanical faults of a campaign file, fixed in the file."""

from __future__ import annotations

import difflib
from pathlib import Path

from metrology.errors import printable

ROUNDS = 20
"""One fault may hide others: how often the file is read again at most."""


def fix(path: Path) -> str:
    """Rewrite a campaign file without its mechanical faults, and return the difference; nothing where there is none.

    Comments and layout stay, and so does the value of every number.

    Raises
    ------
    MetrologyError
        Where the file cannot be read or written.
    """
    from metrology.campaign.load import faults
    from metrology.declaration import fixes, source_text
    from metrology.report import staging

    raw = source_text.read_raw(path)
    if len(raw) > source_text.MAX_BYTES:
        return ""
    try:
        text = fixes.plain(raw).decode("utf-8")
    except UnicodeDecodeError:
        return ""
    for _ in range(ROUNDS):
        edits = [fault.edit for fault in faults(path, text) if fault.edit is not None]
        if not edits:
            break
        text = fixes.apply(text, edits)
    content = text.encode("utf-8")
    if content == raw:
        return ""
    staging.replace_file(path, content)
    return _difference(path, raw, content)


def _difference(path: Path, old: bytes, new: bytes) -> str:
    """What was changed, line by line; that line ends or a byte order mark were is said in a sentence."""
    before, after = (content.decode("utf-8").splitlines() for content in (old, new))
    lines = difflib.unified_diff(before, after, f"{path} (before)", str(path), lineterm="")
    changed = [
        sentence
        for sentence, was in (
            ("a byte order mark was removed", old.startswith(b"\xef\xbb\xbf")),
            ("lines ended as on Windows; they end as on Unix now", b"\r\n" in old),
            ("the last line is ended", not old.endswith(b"\n")),
        )
        if was
    ]
    return "\n".join([*(printable(line) for line in lines), *(f"{path}: {sentence}" for sentence in changed)])
