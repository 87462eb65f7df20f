"""The audit trail by a report: whether its chain holds, and knows this file and its signatures."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from hashlib import sha256
from typing import TYPE_CHECKING

from metrology import audit_trail
from metrology.errors import MetrologyError
from metrology.signoff.revisions import is_stamp
from metrology.signoff.verdict import Check, failed, good

if TYPE_CHECKING:
    from metrology.signoff.opened import Opened
    from metrology.signoff.signatures import Signature

SUBJECT = "audit trail"
_ANCHOR = re.compile(r"audit trail of (\d+) entr(?:y|ies), ([0-9a-f]{64})")


def anchor(entries: Sequence[audit_trail.Entry]) -> str:
    """What a signature states of the trail: how long it was and the hash of its last entry; empty where there is none.

    So nobody can shorten it, or write it anew, without the signer's key.
    """
    if not entries:
        return ""
    count = len(entries)
    return f"audit trail of {count} {'entry' if count == 1 else 'entries'}, {entries[-1].digest}"


def checks(opened: Opened, given: Sequence[Signature]) -> Iterator[Check]:
    """One check where a trail lies by the report; a PDF that was sent by itself has none, which decides nothing."""
    path = opened.path.parent / audit_trail.NAME
    anchors = [
        (one.role, found[1], found[2]) for one in given if (found := _ANCHOR.search(one.reason)) and not one.broken
    ]
    if not path.exists():
        if anchors:
            yield Check(SUBJECT, "note", f"{audit_trail.NAME} does not lie by this file; the signatures state its hash")
        return
    try:
        entries = audit_trail.read(path)
    except MetrologyError as error:
        yield failed(SUBJECT, f"{audit_trail.NAME}: {error.faults[0].got}")
        return
    faults = [*_unknown(opened, entries), *_not_anchored(entries, anchors)]
    yield from (failed(SUBJECT, fault) for fault in faults)
    if not faults:
        known = f", as {len(anchors)} signature{'s state' if len(anchors) > 1 else ' states'} it" if anchors else ""
        count = f"{len(entries)} {'entry' if len(entries) == 1 else 'entries'}"
        yield good(SUBJECT, f"{count}, each with the hash of the one before{known}; the report is in it")


def _unknown(opened: Opened, entries: Sequence[audit_trail.Entry]) -> Iterator[str]:
    known = {digest for entry in entries for digest in entry.files.values()}
    if not any(sha256(content).hexdigest() in known for content in _states(opened)):
        yield "no entry knows this report: something else made or changed it"


def _states(opened: Opened) -> Iterator[bytes]:
    """The file, and as it was before each time stamp that an archive added behind the last signature."""
    yield opened.content
    signatures = [one for _, one in opened.signatures if not isinstance(one, Exception) and not is_stamp(one)]
    last = max((int(one.signed_revision) for one in signatures), default=0)
    for number in range(last, opened.revisions):
        end = opened.content.find(b"%%EOF", opened.reader.xrefs.get_startxref_for_revision(number))
        yield from (opened.content[: end + length] for length in (5, 6))


def _not_anchored(entries: Sequence[audit_trail.Entry], anchors: Sequence[tuple[str, str, str]]) -> Iterator[str]:
    for role, count, digest in anchors:
        at = int(count)
        if at > len(entries):
            yield f"it has {len(entries)} entries, and had {at} when the {role} signed: it was shortened"
        elif entries[at - 1].digest != digest:
            yield f"its first {at} entries are not those that were there when the {role} signed"
