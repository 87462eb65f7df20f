"""What stands against a certificate, each in words of its own: `sign` refuses by them what `verify` fails by."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

from metrology.signoff.authority import MARK

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

    from metrology.identification import Signatory
    from metrology.signoff.policy import Person, Policy

TLS = frozenset({"1.3.6.1.5.5.7.3.1", "1.3.6.1.5.5.7.3.2"})
STAMPS = frozenset({"1.3.6.1.5.5.7.3.8"})
BROKEN = ("md5", "sha1")
"""Digests for which collisions were found."""


@dataclass(frozen=True)
class Objection:
    """What is wrong, as a thing that stands after "got" or behind a name, and what would be right."""

    got: str
    expected: str


def objections(certificate: Certificate, policy: Policy, at: datetime) -> Iterator[Objection]:
    """Everything that keeps a certificate, by itself, from signing documents at a time."""
    yield from _times(certificate, at)
    yield from _strength(certificate, policy)
    yield from _usage(certificate, policy)


def _times(certificate: Certificate, at: datetime) -> Iterator[Objection]:
    first, last = certificate.not_valid_before_utc, certificate.not_valid_after_utc
    if at > last:
        yield Objection(f"a certificate that expired on {last:%Y-%m-%d}", "one that is valid on the day")
    if at < first:
        yield Objection(f"a certificate that is not valid before {first:%Y-%m-%d}", "one that is valid on the day")


def _strength(certificate: Certificate, policy: Policy) -> Iterator[Objection]:
    from cryptography.hazmat.primitives.asymmetric import ec, rsa

    key = certificate.public_key()
    if not isinstance(key, rsa.RSAPublicKey | ec.EllipticCurvePublicKey):
        yield Objection("a key that is neither RSA nor ECDSA", "one of these")
        return
    name, least = ("RSA", policy.keys.rsa) if isinstance(key, rsa.RSAPublicKey) else ("ECDSA", policy.keys.ecdsa)
    if key.key_size < least:
        yield Objection(f"a key of {key.key_size} bits of {name}", f"{least} bits at least")
    digest = certificate.signature_hash_algorithm
    if digest is not None and digest.name in BROKEN:
        yield Objection(f"a certificate signed with {digest.name.upper()}, which can be forged", "SHA-256 or better")


def _usage(certificate: Certificate, policy: Policy) -> Iterator[Objection]:
    from cryptography import x509

    expected = "one for signing documents"
    try:
        usage = certificate.extensions.get_extension_for_class(x509.KeyUsage).value
        if not (usage.digital_signature or usage.content_commitment):
            yield Objection("a certificate that is not for signing documents", expected)
    except x509.ExtensionNotFound:
        yield Objection("a certificate that is not for signing documents", expected)
    try:
        extended = certificate.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
    except x509.ExtensionNotFound:
        return
    found = {usage.dotted_string for usage in extended}
    if not found & policy.usages:
        only = "TLS" if found <= TLS else "time stamps" if found <= STAMPS else "other purposes"
        yield Objection(f"a certificate for {only} only ({', '.join(sorted(found))})", expected)


def unknown(certificate: Certificate, named: Signatory, policy: Policy) -> Iterator[Objection]:
    """What tells that a certificate is not that of the person whom a campaign names in a role."""
    people = policy.persons(named.role)
    if people is None:
        yield from _other_name(certificate, named)
        return
    own = [person for person in people if same_name(person.name, named.name)]
    if not own:
        got = f"{named.name}, whom the trust policy does not know as {named.role}"
        yield Objection(got, f"one of {', '.join(person.name for person in people) or 'nobody'}")
    elif not any(_is(certificate, person, policy) for person in own):
        got = f"the certificate of {common_name(certificate)}, none that the trust policy gives to {named.name}"
        yield Objection(got, f"one of {named.name}")


def _other_name(certificate: Certificate, named: Signatory) -> Iterator[Objection]:
    """Without a policy the name in the certificate decides; a test authority names the role instead."""
    name = common_name(certificate)
    right = f"TEST {named.role}" if MARK in certificate.issuer.rfc4514_string() else named.name
    if not same_name(name, right):
        got = f"the certificate of {name}, who is not {named.name}"
        fix = "" if right == named.name else f" (of a test authority: {right})"
        yield Objection(got, f"a certificate of {named.name}{fix}, or a trust policy that says whose it is")


def _is(certificate: Certificate, person: Person, policy: Policy) -> bool:
    from cryptography import x509

    if person.certificates is not None:
        return fingerprint(certificate) in person.certificates
    assert person.subject is not None
    try:
        subject = x509.Name.from_rfc4514_string(person.subject)
    except ValueError:
        return False
    issuers = dict(policy.issuers).get(person.authority or "", ())
    return _parts(certificate.subject) == _parts(subject) and any(_issued(certificate, issuer) for issuer in issuers)


def _issued(certificate: Certificate, issuer: Certificate) -> bool:
    from cryptography.exceptions import InvalidSignature

    try:
        certificate.verify_directly_issued_by(issuer)
    except (InvalidSignature, ValueError, TypeError):
        return False
    return True


def shared(given: Mapping[str, Certificate], names: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Pairs of roles in which one person signed: by one subject or one key; a campaign may name one person twice."""
    roles = list(given)
    for i, one in enumerate(roles):
        for other in roles[:i]:
            if _same_person(given[one], given[other]) and not same_name(names.get(one, one), names.get(other, other)):
                yield other, one


def _same_person(one: Certificate, other: Certificate) -> bool:
    return (
        one.subject.public_bytes() == other.subject.public_bytes()
        or same_name(common_name(one), common_name(other))
        or one.public_key() == other.public_key()
    )


def same_name(one: str, other: str) -> bool:
    """Whether two names are the same but for spaces and capitals."""
    return one.casefold().split() == other.casefold().split()


def common_name(certificate: Certificate) -> str:
    """Common name of a certificate's subject; all of it where it has none, or several: it is not the name of one."""
    from cryptography.x509.oid import NameOID

    found = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    return str(found[0].value) if len(found) == 1 else certificate.subject.rfc4514_string()


def fingerprint(certificate: Certificate) -> str:
    """SHA-256 of a certificate."""
    from cryptography.hazmat.primitives.hashes import SHA256

    return certificate.fingerprint(SHA256()).hex()


def _parts(name: object) -> Sequence[tuple[str, str]]:
    return sorted((one.oid.dotted_string, str(one.value)) for one in name)  # type: ignore[attr-defined]
