"""Every signature of a report by itself: whose it is, whether its bytes are intact, what came after it."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

from metrology.report.pdf import no_collection
from metrology.signoff.authority import MARK
from metrology.signoff.keys import as_asn1

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

    from metrology.signoff.opened import Opened

_CHANGED = "the bytes that it covers are not those that were signed"
CLOCKS = timedelta(minutes=5)
"""How far two clocks may differ before an order of times means something."""


@dataclass(frozen=True)
class Signature:
    """One signature.

    Parameters
    ----------
    role : str
        In which it was given.
    signer, issuer : str
        Names in the certificate.
    fingerprint : str
        SHA-256 of the certificate.
    when : datetime, optional
        As the signer's clock had it; nothing vouches for it.
    broken : str
        Why it does not hold, whoever gave it; empty where it does.
    untrusted : str
        Why the certificate is not to be relied on; empty where it is.
    certifying : bool
        Whether it says that the file may be signed further, and nothing else.
    note : str
        What must be known beside it.
    """

    role: str
    signer: str = ""
    issuer: str = ""
    fingerprint: str = ""
    when: datetime | None = None
    broken: str = ""
    untrusted: str = ""
    certifying: bool = False
    note: str = ""


def read(opened: Opened, trusted: Sequence[Certificate] = ()) -> tuple[Signature, ...]:
    """Every signature, in the order in which they were given; none is skipped, whatever is wrong with it."""
    with no_collection(), _quiet():
        damaged = [(role, error) for role, error in opened.signatures if isinstance(error, Exception)]
        return (
            *(_judged(embedded, trusted) for embedded in _readable(opened)),
            *(_unreadable(role, error) for role, error in damaged),
        )


def roles(opened: Opened) -> list[str]:
    """In which roles the file is signed, whatever the signatures are worth."""
    return [role for role, _ in opened.signatures]


def _readable(opened: Opened) -> list[Any]:
    """Signatures that can be read, in the order in which they were given."""
    found = [embedded for _, embedded in opened.signatures if not isinstance(embedded, Exception)]
    return sorted(found, key=lambda embedded: int(embedded.signed_revision))


def _unreadable(role: str, error: Exception) -> Signature:
    return Signature(role, broken=f"{_CHANGED}, or cannot be read ({type(error).__name__}: {error})")


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep pyHanko from writing tracebacks to the terminal: what it finds is told in words."""
    loggers = [logging.getLogger(name) for name in ("pyhanko", "pyhanko_certvalidator")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def whole(opened: Opened) -> bool:
    """Whether the last signature covers the file to its end; one that cannot be read is told as broken by itself."""
    from pyhanko.sign.validation.status import SignatureCoverageLevel

    readable = _readable(opened)
    if len(readable) < len(opened.signatures):
        return True
    return bool(readable[-1].evaluate_signature_coverage() == SignatureCoverageLevel.ENTIRE_FILE)


def _judged(embedded: Any, trusted: Sequence[Certificate]) -> Signature:
    role = str(embedded.field_name)
    try:
        when = embedded.self_reported_timestamp
        status = _validated(embedded, trusted, when)
        subject = status.signing_cert
        return Signature(
            role=role,
            signer=_common_name(subject.subject),
            issuer=_common_name(subject.issuer),
            fingerprint=subject.sha256.hex(),
            when=when,
            broken=_broken(status, when) or _stuffed(embedded),
            untrusted=_untrusted(status, when),
            certifying=embedded.docmdp_level is not None and embedded.docmdp_level.name == "FILL_FORMS",
            note=_note(subject, when),
        )
    except Exception as error:  # noqa: BLE001  (a forged signature may break any part of the reader)
        return _unreadable(role, error)


def _validated(embedded: Any, trusted: Sequence[Certificate], when: datetime | None) -> Any:
    """Status by pyHanko, at the time that the signer states: a certificate may expire, and what it signed stays."""
    from pyhanko.sign.validation import validate_pdf_signature
    from pyhanko.sign.validation.settings import KeyUsageConstraints
    from pyhanko_certvalidator import ValidationContext

    context = ValidationContext(
        trust_roots=[as_asn1(certificate) for certificate in trusted],
        moment=when or datetime.now(UTC),
        allow_fetching=False,
        revocation_mode="soft-fail",
    )
    usage = KeyUsageConstraints(key_usage={"digital_signature", "non_repudiation"})
    return validate_pdf_signature(embedded, context, key_usage_settings=usage)


def _broken(status: Any, when: datetime | None) -> str:
    if not status.intact:
        return _CHANGED
    if not status.valid:
        return "it was not made with the key of its certificate"
    if not status.docmdp_ok or status.modification_level is None:
        return "pages, attachments or anything else were changed after it"
    if when is None or when > datetime.now(UTC) + CLOCKS:
        return "it states no time" if when is None else f"it states a time to come, {when:%Y-%m-%d}"
    # What pyHanko itself makes of it, but for trust, which is told apart.
    return "" if status.bottom_line or not status.trusted else "it does not hold by the rules of PAdES"


def _stuffed(embedded: Any) -> str:
    """No signature covers the room of its own: behind what it needs there must be nothing but zeros."""
    room = bytes(embedded.pkcs7_content)
    return "the room left behind it is filled with something" if room[_length(room) :].strip(b"\0") else ""


def _length(der: bytes) -> int:
    from asn1crypto.parser import peek  # type: ignore[import-untyped]

    return int(peek(der))


def _untrusted(status: Any, when: datetime | None) -> str:
    certificate = status.signing_cert
    if when is not None and not certificate.not_valid_before <= when <= certificate.not_valid_after:
        return f"the certificate was not valid then ({_span(certificate)})"
    if status.trusted:
        return ""
    return f"the certificate leads to no authority that you trust (it was issued by {_common_name(certificate.issuer)})"


def _note(certificate: Any, when: datetime | None) -> str:
    notes = []
    if MARK in _common_name(certificate.issuer):
        notes.append(f"{MARK}: for trying out, proves nothing")
    if when is not None and when <= certificate.not_valid_after < datetime.now(UTC):
        notes.append("the certificate has expired since; nothing but the signer's clock says that it was valid then")
    return "; ".join(notes)


def _span(certificate: Any) -> str:
    return f"it is valid from {certificate.not_valid_before:%Y-%m-%d} to {certificate.not_valid_after:%Y-%m-%d}"


def _common_name(name: Any) -> str:
    return str(name.native.get("common_name") or name.human_friendly)
