"""Every signature of a report by itself: whose it is, whether its bytes are intact, since when it is known to exist."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from typing import TYPE_CHECKING, Any

from metrology.report.pdf import no_collection
from metrology.signoff import evidence, stamps
from metrology.signoff.authority import MARK
from metrology.signoff.certificates import BROKEN, common_name, fingerprint, objections
from metrology.signoff.policy import Policy
from metrology.signoff.revisions import is_stamp
from metrology.signoff.stamps import CLOCKS, Stamp

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

    from metrology.signoff.evidence import Evidence
    from metrology.signoff.opened import Opened

_CHANGED = "the bytes that it covers are not those that were signed"


@dataclass(frozen=True)
class Signature:
    """One signature.

    Parameters
    ----------
    role : str
        In which it was given.
    certificate : Certificate, optional
        Of the signer; None where it cannot be read.
    when : datetime, optional
        As the signer's clock had it; nothing vouches for it.
    proven : datetime, optional
        When it existed for certain, by a time stamp.
    broken : str
        Why it does not hold, whoever gave it; empty where it does.
    untrusted : str
        Why the certificate is not to be relied on; empty where it is.
    unknown : str
        What could not be checked of it, and why; empty where all was.
    certifying : bool
        Whether it says that the file may be signed further, and nothing else.
    reason : str
        As the signature states it.
    note : str
        What must be known with it.
    """

    role: str
    certificate: Certificate | None = None
    when: datetime | None = None
    proven: datetime | None = None
    broken: str = ""
    untrusted: str = ""
    unknown: str = ""
    certifying: bool = False
    reason: str = ""
    note: str = ""

    @property
    def signer(self) -> str:
        """Name in the certificate."""
        return common_name(self.certificate) if self.certificate else ""

    @property
    def fingerprint(self) -> str:
        """SHA-256 of the certificate."""
        return fingerprint(self.certificate) if self.certificate else ""


def read(opened: Opened, policy: Policy | None = None) -> tuple[Signature, ...]:
    """Every signature, in the order in which they were given; none is skipped, whatever is wrong with it."""
    return read_all(opened, policy or Policy())[0]


def read_all(opened: Opened, policy: Policy) -> tuple[tuple[Signature, ...], tuple[Stamp, ...]]:
    """Every signature and every time stamp of the document, each in the order in which they were given."""
    with no_collection(), quiet():
        try:
            known = evidence.gather(policy, opened)
        except Exception:  # noqa: BLE001  (a store that is damaged holds nothing; that it was changed is found elsewhere)
            known = evidence.gather(policy)
        damaged = [(role, error) for role, error in opened.signatures if isinstance(error, Exception)]
        readable = _readable(opened)
        given = stamps.read([embedded for embedded in readable if is_stamp(embedded)], known)
        return (
            *(_judged(embedded, known, given) for embedded in readable if not is_stamp(embedded)),
            *(_unreadable(role, error) for role, error in damaged),
        ), given


def roles(opened: Opened) -> list[str]:
    """In which roles the file is signed, whatever the signatures are worth."""
    return [role for role, found in opened.signatures if isinstance(found, Exception) or not is_stamp(found)]


def _readable(opened: Opened) -> list[Any]:
    """Signatures that can be read, in the order in which they were given."""
    found = [embedded for _, embedded in opened.signatures if not isinstance(embedded, Exception)]
    return sorted(found, key=lambda embedded: int(embedded.signed_revision))


def _unreadable(role: str, error: Exception) -> Signature:
    return Signature(role, broken=f"{_CHANGED}, or cannot be read ({type(error).__name__}: {error})")


@contextmanager
def quiet() -> Iterator[None]:
    """Keep pyHanko from writing tracebacks to the terminal: what it finds is reported in words."""
    loggers = [logging.getLogger(name) for name in ("pyhanko", "pyhanko_certvalidator")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _judged(embedded: Any, known: Evidence, given: Sequence[Stamp]) -> Signature:
    from cryptography import x509

    role = str(embedded.field_name)
    try:
        own = stamps.attached(embedded, known, given)
        proven = stamps.proven(embedded, own, given)
        certificate = x509.load_der_x509_certificate(embedded.signer_cert.dump())
        when = embedded.self_reported_timestamp
        at = proven or min(evidence.now(), certificate.not_valid_after_utc)
        status = _validated(embedded, known, at)
        found = Signature(
            role=role,
            certificate=certificate,
            when=when,
            proven=proven,
            broken=_broken(status, embedded, when)
            or _stuffed(embedded)
            or (f"its time stamp: {own.broken}" if own and own.broken else ""),
            certifying=embedded.docmdp_level is not None and embedded.docmdp_level.name == "FILL_FORMS",
            reason=str(embedded.sig_object.get("/Reason", "")),
        )
        covered = not known.policy.strict or _validated(embedded, known, at, strict=True).trusted
        untrusted, unknown = _trust(found, status, known, own, covered=covered)
        return replace(found, untrusted=untrusted, unknown=unknown, note=_note(found, known, own))
    except Exception as error:  # noqa: BLE001  (a forged signature may break any part of the reader)
        return _unreadable(role, error)


def _validated(embedded: Any, known: Evidence, at: datetime, *, strict: bool = False) -> Any:
    """Status by pyHanko at the time that is proven; else today, or on the last day of a certificate that expired."""
    from pyhanko.sign.validation import validate_pdf_signature
    from pyhanko.sign.validation.settings import KeyUsageConstraints

    usage = KeyUsageConstraints(key_usage={"digital_signature", "non_repudiation"})
    return validate_pdf_signature(
        embedded,
        known.context(at, strict=strict),
        known.context(at, stamping=True),
        key_usage_settings=usage,
        skip_diff=strict,
    )


def _broken(status: Any, embedded: Any, when: datetime | None) -> str:
    if not status.intact:
        return _CHANGED
    if not status.valid:
        return "it was not made with the key of its certificate"
    if not status.docmdp_ok or status.modification_level is None:
        return "pages, attachments or anything else were changed after it"
    if embedded.md_algorithm in BROKEN:
        return f"it was made with {embedded.md_algorithm.upper()}, which can be forged"
    if when is None or when > evidence.now() + CLOCKS:
        return "it states no time" if when is None else f"it states a time to come, {when:%Y-%m-%d}"
    return ""


def _stuffed(embedded: Any) -> str:
    """No signature covers the room of its own: behind what it needs there must be nothing but zeros."""
    room = bytes(embedded.pkcs7_content)
    return "the room left behind it is filled with something" if room[_length(room) :].strip(b"\0") else ""


def _length(der: bytes) -> int:
    from asn1crypto.parser import peek  # type: ignore[import-untyped]

    return int(peek(der))


def _trust(found: Signature, status: Any, known: Evidence, own: Stamp | None, *, covered: bool) -> tuple[str, str]:
    """Why a certificate is not to be relied on, and what could not be checked of it."""
    certificate, policy = found.certificate, known.policy
    assert certificate is not None
    at = found.proven or found.when or evidence.now()
    against = [objection.got for objection in objections(certificate, policy, at)]
    revoked = known.revoked(certificate)
    if against:
        return f"it is of {against[0]}", ""
    if revoked and (found.proven is None or revoked <= found.proven):
        proof = "" if found.proven else ", and no time stamp proves that the signature is older"
        return f"the certificate was revoked on {revoked:%Y-%m-%d}{proof}", ""
    if status.trust_problem_indic is not None:
        return _problem(status, certificate), ""
    return "", _unknown(found, known, own, covered=covered)


def _problem(status: Any, certificate: Certificate) -> str:
    name = status.trust_problem_indic.name
    if "REVOKED" in name:
        return "the certificate, or one behind it, was revoked"
    if "CRYPTO" in name:
        return "the certificate, or one behind it, is of an algorithm that can be forged"
    if name in {"EXPIRED", "NOT_YET_VALID", "OUT_OF_BOUNDS_NO_POE", "OUT_OF_BOUNDS_NOT_REVOKED"}:
        return "a certificate behind it was not valid then"
    issuer = common_name(certificate) if certificate.issuer == certificate.subject else _issuer(certificate)
    return f"the certificate leads to no authority that you trust (it was issued by {issuer})"


def _issuer(certificate: Certificate) -> str:
    from cryptography.x509.oid import NameOID

    found = certificate.issuer.get_attributes_for_oid(NameOID.COMMON_NAME)
    return str(found[0].value) if found else certificate.issuer.rfc4514_string()


def _unknown(found: Signature, known: Evidence, own: Stamp | None, *, covered: bool) -> str:
    assert found.certificate is not None
    last = found.certificate.not_valid_after_utc
    if not covered:
        return "no list of revoked certificates that is fresh enough covers the certificate and those behind it"
    if found.proven is None and last < evidence.now():
        return f"the certificate expired on {last:%Y-%m-%d}, and no time stamp proves that the signature is older"
    if known.policy.stamped and found.proven is None:
        return own.untrusted if own else "it has no time stamp, which the trust policy asks for"
    return ""


def _note(found: Signature, known: Evidence, own: Stamp | None) -> str:
    assert found.certificate is not None
    notes = []
    if MARK in found.certificate.issuer.rfc4514_string():
        notes.append(f"{MARK}: for trying out, proves nothing")
    if own and own.untrusted:
        notes.append(own.untrusted)
    if found.proven and found.certificate.not_valid_after_utc < evidence.now():
        notes.append("the certificate has expired since")
    if found.proven and known.revoked(found.certificate):
        notes.append("the certificate was revoked later")
    if found.proven and found.when and abs(found.when - found.proven) > CLOCKS:
        notes.append(f"the signer's clock stated {found.when:%Y-%m-%d %H:%M:%S %Z}")
    return "; ".join(notes)
