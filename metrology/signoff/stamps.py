"""Time stamps: those within a signature (PAdES B-T) and those of the document, which an archive renews (B-LTA)."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import TYPE_CHECKING, Any

from metrology.signoff import evidence

if TYPE_CHECKING:
    from metrology.signoff.evidence import Evidence


CLOCKS = timedelta(minutes=5)
"""How far two clocks may differ before an order of times means something."""


@dataclass(frozen=True)
class Stamp:
    """One time stamp.

    Parameters
    ----------
    when : datetime, optional
        What it states; None where it cannot be read.
    authority : str
        Who gave it, by the name in the certificate.
    revision : int
        Of the file; what was there before existed at that time.
    broken : str
        Why it does not hold, whoever gave it; empty where it does.
    untrusted : str
        Why it proves nothing here; empty where it does.
    """

    when: datetime | None
    authority: str = ""
    revision: int = 0
    broken: str = ""
    untrusted: str = ""

    @property
    def holds(self) -> bool:
        """Whether it proves its time."""
        return not self.broken and not self.untrusted


def read(embedded: Sequence[Any], known: Evidence) -> tuple[Stamp, ...]:
    """Time stamps of the document, in order; each is judged at the time that the next one proves, the last today."""
    found: list[Stamp] = []
    at = evidence.now()
    for one in sorted(embedded, key=lambda one: int(one.signed_revision), reverse=True):
        stamp = _document(one, known, at)
        found.insert(0, stamp)
        if stamp.holds and stamp.when is not None:
            at = min(at, stamp.when)
    return tuple(found)


def _document(embedded: Any, known: Evidence, at: datetime) -> Stamp:
    from pyhanko.sign.validation import validate_pdf_timestamp

    revision = int(embedded.signed_revision)
    try:
        status = validate_pdf_timestamp(embedded, known.context(at, stamping=True))
    except Exception as error:  # noqa: BLE001  (a forged one may break any part of the reader)
        return Stamp(None, revision=revision, broken=f"it cannot be read ({type(error).__name__}: {error})")
    stamp = _judged(status, revision)
    if not stamp.broken and _changed(status):
        return Stamp(stamp.when, stamp.authority, revision, "pages, attachments or anything else were changed after it")
    return stamp


def _changed(status: Any) -> bool:
    level = status.modification_level
    return status.docmdp_ok is False or level is None or level.name == "OTHER"


def attached(embedded: Any, known: Evidence, given: Sequence[Stamp]) -> Stamp | None:
    """The time stamp within a signature; None where it has none. Of several, the first that holds."""
    at = _earliest(embedded, given) or evidence.now()
    context = known.context(at, stamping=True)
    revision = int(embedded.signed_revision)
    found = [_judged(status, revision) for status in asyncio.run(_statuses(embedded.signer_info, context))]
    return next((one for one in found if one.holds), found[-1]) if found else None


async def _statuses(signer: Any, context: Any) -> list[Any]:
    from pyhanko.sign.validation import generic_cms
    from pyhanko.sign.validation.status import TimestampSignatureStatus

    imprint = generic_cms.message_imprint_checker(signer)
    return [
        TimestampSignatureStatus(**await generic_cms.validate_tst_signed_data(token, context, imprint))
        for token in generic_cms.extract_tst_data_iter(signer, signed=False)
    ]


def _judged(status: Any, revision: int) -> Stamp:
    from metrology.signoff.certificates import BROKEN

    when, name = status.timestamp, str(status.signing_cert.subject.native.get("common_name") or "an authority")
    broken = untrusted = ""
    if not (status.intact and status.valid):
        broken = "it does not belong to these bytes, or was not made with the key of its certificate"
    elif when > evidence.now() + CLOCKS:
        broken = f"it states a time to come, {when:%Y-%m-%d}"
    elif status.md_algorithm in BROKEN:
        broken = f"it was made with {status.md_algorithm.upper()}, which can be forged"
    elif not status.trusted:
        untrusted = f"the time stamp of {name} counts for nothing: it is none of an authority that you trust for that"
    return Stamp(when, name, revision, broken, untrusted)


def _earliest(embedded: Any, given: Sequence[Stamp]) -> datetime | None:
    """When a signature existed, by the time stamps of the document after it."""
    later = [one.when for one in given if one.holds and one.when and one.revision > int(embedded.signed_revision)]
    return min(later, default=None)


def proven(embedded: Any, own: Stamp | None, given: Sequence[Stamp]) -> datetime | None:
    """The earliest time at which a signature is known to have existed."""
    times = [_earliest(embedded, given), own.when if own and own.holds else None]
    return min((time for time in times if time is not None), default=None)
