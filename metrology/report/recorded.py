"""What is written by a report enters the audit trail in its folder, in the same step as the files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from metrology import audit_trail
from metrology.errors import Fault, MetrologyError
from metrology.report import staging

ID = re.compile(r"""^id:\s*['"]?([\w-]+)""", re.MULTILINE)
"""The id of a campaign file, a key of its own line."""


def line(
    folder: Path, command: str, files: Mapping[str, bytes], *, detail: str = "", campaign: Path | None = None
) -> dict[str, bytes]:
    """The trail of a folder with a line for what a command writes, by its name; for `staging.replace_folder`.

    `campaign`: the file that was evaluated, where it is known.

    Raises
    ------
    MetrologyError
        Where the trail is damaged, or says that the folder holds the results of another campaign.
    """
    content = audit_trail.content(folder / audit_trail.NAME)
    name = ""
    if campaign is not None:
        _refuse(folder, content, campaign)
        name = str(campaign.resolve())
    return {audit_trail.NAME: audit_trail.extended(content, command, files, detail=detail, campaign=name)}


def refuse_other(folder: Path, campaign: Path) -> None:
    """Refuse to replace what another campaign of the same id gave; one that was moved away, or renamed, is none.

    Asked before an evaluation, which may take minutes; `line` asks again when it writes.

    Raises
    ------
    MetrologyError
        Where the trail is damaged, or says that the folder holds the results of another campaign.
    """
    _refuse(folder, audit_trail.content(folder / audit_trail.NAME), campaign)


def _refuse(folder: Path, trail: bytes, campaign: Path) -> None:
    known = [one.campaign for one in audit_trail.parse(trail, audit_trail.NAME) if one.campaign]
    if not known or Path(known[-1]) == campaign.resolve():
        return
    other = Path(known[-1])
    with suppress(OSError, UnicodeDecodeError):
        stated = ID.search(other.read_text("utf-8"))
        if stated is not None and stated[1] == folder.name and not other.samefile(campaign):
            raise MetrologyError(
                Fault(
                    str(folder),
                    f"results of {other}, which has the same id {folder.name!r} as {campaign}",
                    "a folder without results, or with those of this very campaign",
                    "give one of the two campaigns another id, or write elsewhere with --output",
                )
            )


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
