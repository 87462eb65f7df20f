"""The audit trail by a report: one line for each command that touched it, each with the hash of the line before.

Lines are only ever added. A line that is changed, taken out or put in breaks the chain from there on; that the end was
cut off, or all of it written anew, is found by the signatures, which state the trail's length and last hash.
"""

from __future__ import annotations

import getpass
import json
import os
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

from metrology import __version__
from metrology.errors import Fault, MetrologyError, own_text

NAME = "audit.jsonl"
START = "0" * 64
"""What the first line has in the place of a hash."""
MAX_BYTES = 64 * 1024 * 1024


@dataclass(frozen=True)
class Entry:
    """One line.

    Parameters
    ----------
    digest : str
        SHA-256 of the line, which the next one holds.
    command : str
        ``check``, ``run``, ``report``, ``sign``, ``export`` or ``batch``.
    at : str
        When, by this machine's clock, in UTC.
    files : mapping
        Name to SHA-256 of what was written.
    detail : str
        What else is to be known: a role, faults found.
    campaign : str
        Campaign file that was evaluated, where the command was given one.
    """

    digest: str
    command: str
    at: str
    files: Mapping[str, str] = field(default_factory=dict)
    detail: str = ""
    campaign: str = ""


def extended(
    content: bytes, command: str, files: Mapping[str, bytes], *, detail: str = "", campaign: str = ""
) -> bytes:
    """The trail with one line more.

    Raises
    ------
    MetrologyError
        Where the trail is damaged: nothing is added to one that no longer proves anything.
    """
    entries = parse(content, NAME)
    line = {
        "number": len(entries) + 1,
        "at": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command,
        "by": _user(),
        "host": socket.gethostname(),
        "version": __version__,
        "files": {name: sha256(one).hexdigest() for name, one in sorted(files.items())},
        **({"detail": detail} if detail else {}),
        **({"campaign": campaign} if campaign else {}),
        "previous": entries[-1].digest if entries else START,
    }
    return content + json.dumps(line, ensure_ascii=False).encode() + b"\n"


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # no name, as in a container
        return str(os.getuid())


def read(path: Path) -> tuple[Entry, ...]:
    """Read a trail; empty where there is none.

    Raises
    ------
    MetrologyError
        For a trail whose chain does not hold, or that cannot be read.
    """
    return parse(content(path), str(path))


def content(path: Path) -> bytes:
    """The bytes of a trail; none where there is none.

    Raises
    ------
    MetrologyError
        Where it cannot be read, is a link, or is larger than 64 MiB.
    """
    try:
        if path.is_symlink():
            raise MetrologyError(Fault(str(path), "a link", "the trail itself, a plain file"))
        with path.open("rb") as file:
            found = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        return b""
    except OSError as error:
        raise MetrologyError(Fault(str(path), own_text(error), "an audit trail")) from None
    if len(found) > MAX_BYTES:
        raise MetrologyError(Fault(str(path), f"more than {MAX_BYTES >> 20} MiB", "an audit trail"))
    return found


def parse(content: bytes, where: str) -> tuple[Entry, ...]:
    """The lines of a trail.

    Raises
    ------
    MetrologyError
        For the first line that does not follow from the one before.
    """
    found: list[Entry] = []
    lines = content.split(b"\n")
    for number, line in enumerate(lines[:-1], 1):
        stated = _stated(line)
        previous = found[-1].digest if found else START
        if stated is None or stated.get("previous") != previous or stated.get("number") != number:
            raise _broken(where, f"a chain that breaks at line {number}")
        files = stated.get("files")
        found.append(
            Entry(
                digest=sha256(line).hexdigest(),
                command=str(stated.get("command", "")),
                at=str(stated.get("at", "")),
                files={str(k): str(v) for k, v in files.items()} if isinstance(files, dict) else {},
                detail=str(stated.get("detail", "")),
                campaign=str(stated.get("campaign", "")),
            )
        )
    if lines[-1]:
        raise _broken(where, "a last line without its end")
    return tuple(found)


def _stated(line: bytes) -> dict[str, Any] | None:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def _broken(where: str, got: str) -> MetrologyError:
    fix = "find out who changed it; move it away to begin a new one, and keep it"
    return MetrologyError(Fault(where, got, "the lines as they were written, none changed or taken out", fix))
