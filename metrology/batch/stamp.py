"""Whether a report is up to date: by hashes of what went in, of the code that made it, and of what came out."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from metrology.batch import card
from metrology.batch.bundle import Bundle

if TYPE_CHECKING:
    import hashlib

NAME = "batch.json"
"""Lies beside the report."""
SCHEMA = "metrology-batch/1"


@cache
def code() -> str:
    """Hash of everything but the campaign that a report depends on: our code, templates, versions of the libraries."""
    import metrology
    from metrology import chain
    from metrology.method.discovery import templates

    versions = json.dumps(chain.software(), sort_keys=True).encode()
    total = sha256(versions)
    package = Path(metrology.__file__).parent
    for folder, pattern in ((package, "*.py"), (templates(), "*")):
        for path in sorted(path for path in folder.rglob(pattern) if path.is_file()):
            _enter(total, path.relative_to(folder).as_posix(), path.read_bytes())
    return total.hexdigest()


def content(packed: Bundle) -> str:
    """Hash of all that a campaign reads, and of where its files lie from each other."""
    total = sha256()
    for name, content in sorted(packed.files.items()):
        _enter(total, name, content)
    return total.hexdigest()


def key(packed: Bundle) -> str:
    """Hash of all that determines a report: what the campaign reads, where the report lies from it, and the code."""
    total = sha256(code().encode())
    _enter(total, packed.home, content(packed).encode())
    return total.hexdigest()


def _enter(total: hashlib._Hash, name: str, content: bytes) -> None:
    """Add a file so that no other name and content give the same."""
    total.update(sha256(os.fsencode(name)).digest() + sha256(content).digest())


def text(key: str, files: Mapping[str, bytes], news: Sequence[str] | None = None) -> bytes:
    """Return the stamp to lie beside the files of a report; `news`: what differs from the report before."""
    stated = {name: {"sha256": sha256(content).hexdigest(), "bytes": len(content)} for name, content in files.items()}
    whole = {"schema": SCHEMA, "key": key, "files": stated, **({} if news is None else {"news": list(news)})}
    return (json.dumps(whole, indent=1, ensure_ascii=False) + "\n").encode()


def changed(folder: Path, files: Mapping[str, bytes]) -> tuple[str, ...] | None:
    """What differs between the report in `folder` and the files that take its place; None where there is none yet."""
    before, now = card.read(folder), card.parse(files.get(card.NAME, b""))
    return None if before is None or now is None else tuple(card.changes(before, now))


def news(folder: Path) -> tuple[str, ...] | None:
    """What differed when the report in `folder` was made, as its stamp has it; None where nothing is known."""
    try:
        stated = json.loads((folder / NAME).read_bytes())["news"]
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return tuple(map(str, stated)) if isinstance(stated, list) else None


def fresh(folder: Path, key: str) -> bool:
    """Whether `folder` holds the report of this key, every file as it was made; signatures may follow upon the PDF."""
    try:
        stated = json.loads((folder / NAME).read_bytes())
        return (
            stated["schema"] == SCHEMA
            and stated["key"] == key
            and "results.json" in stated["files"]
            and all(_same(folder / name, entry) for name, entry in stated["files"].items())
        )
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        # A stamp that cannot be read, or says something else: the report is made anew.
        return False


def _same(path: Path, stated: Mapping[str, object]) -> bool:
    content, size = path.read_bytes(), stated["bytes"]
    if path.suffix == ".pdf" and isinstance(size, int):
        content = content[:size]
    return sha256(content).hexdigest() == stated["sha256"]
