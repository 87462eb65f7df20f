"""What there is to judge a certificate by: trusted authorities, lists of revoked ones, what the file itself holds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from metrology.signoff.keys import as_asn1

if TYPE_CHECKING:
    from cryptography.x509 import Certificate
    from cryptography.x509.ocsp import OCSPResponse

    from metrology.signoff.opened import Opened
    from metrology.signoff.policy import Policy


@dataclass(frozen=True)
class Evidence:
    """Of a policy and of a file's document security store, as pyHanko takes it.

    Parameters
    ----------
    policy : Policy
        What the laboratory accepts.
    certificates, lists, responses : tuple
        Certificates, CRLs and OCSP responses, of asn1crypto's types.
    """

    policy: Policy
    certificates: tuple[Any, ...] = ()
    lists: tuple[Any, ...] = ()
    responses: tuple[Any, ...] = ()

    def context(self, at: datetime, *, stamping: bool = False, strict: bool = False, fetch: bool = False) -> Any:
        """A validation context of pyHanko at a time; offline unless `fetch`.

        A list issued after that time counts too: it holds at least what was revoked then. Where `strict`, every
        certificate has to be covered by a list.
        """
        from pyhanko_certvalidator import ValidationContext

        policy = self.policy
        roots = (policy.stamping or policy.authorities) if stamping else policy.authorities
        return ValidationContext(
            trust_roots=[as_asn1(root) for root in roots],
            other_certs=list(self.certificates),
            crls=list(self.lists),
            ocsps=list(self.responses),
            moment=at,
            allow_fetching=fetch,
            revocation_mode="require" if strict else "soft-fail",
            retroactive_revinfo=True,
        )

    def revoked(self, certificate: Certificate) -> datetime | None:
        """When a certificate was revoked, as a list or an answer of its issuer says, however old that is."""
        found = [
            when
            for issuer in self._issuers(certificate)
            for when in (*self._listed(certificate, issuer), *self._answered(certificate, issuer))
        ]
        return min(found, default=None)

    def _issuers(self, certificate: Certificate) -> Iterator[Certificate]:
        from cryptography import x509

        others = [x509.load_der_x509_certificate(one.dump()) for one in self.certificates]
        for issuer in dict.fromkeys([*self.policy.authorities, *self.policy.stamping, *others]):
            if issuer.subject == certificate.issuer:
                yield issuer

    def _listed(self, certificate: Certificate, issuer: Certificate) -> Iterator[datetime]:
        from cryptography import x509

        for one in self.lists:
            found = x509.load_der_x509_crl(one.dump())
            if found.issuer == issuer.subject and found.is_signature_valid(issuer.public_key()):  # type: ignore[arg-type]
                entry = found.get_revoked_certificate_by_serial_number(certificate.serial_number)
                if entry is not None:
                    yield entry.revocation_date_utc

    def _answered(self, certificate: Certificate, issuer: Certificate) -> Iterator[datetime]:
        """By OCSP responses, of the issuer or of whom it certified for that."""
        from cryptography.hazmat.primitives.hashes import Hash
        from cryptography.x509 import ocsp

        for one in self.responses:
            found = ocsp.load_der_ocsp_response(one.dump())
            if found.response_status is not ocsp.OCSPResponseStatus.SUCCESSFUL or not _answers(found, issuer):
                continue
            for single in found.responses:
                name = Hash(single.hash_algorithm)
                name.update(issuer.subject.public_bytes())
                own = (single.serial_number, single.issuer_name_hash) == (certificate.serial_number, name.finalize())
                if own and single.revocation_time_utc is not None:
                    yield single.revocation_time_utc


def _answers(response: OCSPResponse, issuer: Certificate) -> bool:
    """Whether a response is signed by an issuer, or by a certificate for OCSP that it gave."""
    from cryptography import x509
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives.asymmetric import ec, padding, rsa
    from cryptography.x509.oid import ExtendedKeyUsageOID

    for one in (issuer, *response.certificates):
        key, digest = one.public_key(), response.signature_hash_algorithm
        try:
            if one != issuer:
                one.verify_directly_issued_by(issuer)
                usage = one.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
                if ExtendedKeyUsageOID.OCSP_SIGNING not in usage:
                    continue
            signed = response.signature, response.tbs_response_bytes
            if isinstance(key, rsa.RSAPublicKey) and digest is not None:
                key.verify(*signed, padding.PKCS1v15(), digest)
            elif isinstance(key, ec.EllipticCurvePublicKey) and digest is not None:
                key.verify(*signed, ec.ECDSA(digest))
            else:
                continue
        except (InvalidSignature, x509.ExtensionNotFound, ValueError, TypeError):
            continue
        return True
    return False


def gather(policy: Policy, opened: Opened | None = None) -> Evidence:
    """What a policy names, and what a file holds.

    Raises
    ------
    ValueError
        Where the file's store cannot be read.
    """
    from asn1crypto import crl, ocsp  # type: ignore[import-untyped]

    lists = [crl.CertificateList.load(one) for one in policy.lists]
    responses = [ocsp.OCSPResponse.load(one) for one in policy.responses]
    certificates: Sequence[Any] = ()
    store = _store(opened) if opened is not None else None
    if store is not None:
        certificates = list(store.load_certs())
        lists += [crl.CertificateList.load(one.get_object().data) for one in store.crls]
        responses += [ocsp.OCSPResponse.load(one.get_object().data) for one in store.ocsps]
    return Evidence(policy, tuple(certificates), tuple(lists), tuple(responses))


def _store(opened: Opened) -> Any:
    from pyhanko.sign.validation.dss import DocumentSecurityStore
    from pyhanko.sign.validation.errors import NoDSSFoundError

    try:
        return DocumentSecurityStore.read_dss(opened.reader)
    except NoDSSFoundError:
        return None


def now() -> datetime:
    """The time by this machine's clock."""
    return datetime.now(UTC)
