"""The laboratory's trust policy, `trust.yaml`: whose certificates count in which role, how strong, how fresh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationError, model_validator

from metrology.declaration.document import Document
from metrology.declaration.document import read as read_document
from metrology.declaration.entry import Entry, Refusal, one_of, refusals, refuse
from metrology.declaration.scalars import Filled, Flag, Integer, matching, ranged
from metrology.errors import Fault, MetrologyError, own_text

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

FORMAT = "metrology-trust/1"
Role = Literal["author", "reviewer", "approver"]
RSA, ECDSA = 2048, 224
"""Least bits of a key where a policy states none: 112 bits of strength (NIST SP 800-57 part 1, table 2), allowed on."""
USAGES = {
    "any": "2.5.29.37.0",
    "email": "1.3.6.1.5.5.7.3.4",
    "documents": "1.3.6.1.5.5.7.3.36",
    "microsoft documents": "1.3.6.1.4.1.311.10.3.12",
    "adobe documents": "1.2.840.113583.1.1.5",
}
"""Extended key usages with which a person signs documents (RFC 5280 4.2.1.12, RFC 9336), as a policy may name them."""


def _bare(text: str) -> str:
    return text.replace(":", "").replace(" ", "").lower()


Fingerprint = Annotated[
    Filled, AfterValidator(_bare), AfterValidator(matching("[0-9a-f]{64}", "the SHA-256 of a certificate, 64 digits"))
]
Bits = Annotated[Integer, ranged(100, 100_000, "bits of a key, such as '3072'")]


class Person(Entry):
    """Somebody who may sign in a role, and by what his certificate is known."""

    name: Filled = Field(description="Name, as campaigns write it.", examples=["J. Doe"])
    certificates: tuple[Fingerprint, ...] | None = Field(None, description="SHA-256 of each certificate of the person.")
    subject: Filled | None = Field(None, description="Subject of the certificates (RFC 4514).", examples=["CN=J. Doe"])
    authority: Filled | None = Field(None, description="File of the authority that issues them; with `subject`.")

    @model_validator(mode="after")
    def _known(self) -> Person:
        one_of(self, "certificates", "subject", "'certificates', or 'subject' with 'authority'")
        if (self.subject is None) != (self.authority is None):
            raise refuse(Refusal((), "one of 'subject' and 'authority'", "both, as anybody can write a subject"))
        return self


class Roles(Entry):
    """Who may sign in which role."""

    author: tuple[Person, ...] = Field((), description="Who may write reports.")
    reviewer: tuple[Person, ...] = Field((), description="Who may check them.")
    approver: tuple[Person, ...] = Field((), description="Who may release them.")


class Keys(Entry):
    """Least bits of keys."""

    rsa: Bits = Field(RSA, description="Of RSA.")
    ecdsa: Bits = Field(ECDSA, description="Of elliptic curves.")


class Revocation(Entry):
    """What says which certificates were revoked."""

    files: tuple[Filled, ...] = Field((), description="CRLs and OCSP responses, in PEM or DER.", examples=["[ca.crl]"])
    required: Flag = Field(False, description="Whether every certificate has to be covered by one.")


class TimeStamps(Entry):
    """Whose time stamps count."""

    url: Filled | None = Field(None, description="Address of the time-stamping authority, for `metrology sign`.")
    authorities: tuple[Filled, ...] = Field((), description="Certificates behind time stamps.", examples=["[tsa.pem]"])
    required: Flag = Field(False, description="Whether every signature needs one.")


class Declared(Entry):
    """`trust.yaml`."""

    format: Literal["metrology-trust/1"] = Field(description="Kind of file.", examples=[FORMAT])
    authorities: tuple[Filled, ...] = Field((), description="Certificates of authorities behind signers.")
    require: tuple[Role, ...] = Field((), description="Roles without which no report is good.")
    roles: Roles | None = Field(None, description="Who may sign in which role; left out, whom the campaign names.")
    keys: Keys = Field(default_factory=lambda: Keys.model_validate({}), description="Least bits of keys.")
    usages: tuple[Filled, ...] = Field(
        tuple(USAGES), description="Extended key usages that are accepted, by name or number."
    )
    revocation: Revocation = Field(
        default_factory=lambda: Revocation.model_validate({}), description="Revoked certificates."
    )
    time_stamps: TimeStamps = Field(default_factory=lambda: TimeStamps.model_validate({}), description="Time stamps.")


@dataclass(frozen=True)
class Policy:
    """What a laboratory accepts; `declared` is None where only authorities were named, by ``--trust``.

    Parameters
    ----------
    authorities, stamping : tuple of Certificate
        Behind signers, and behind time stamps.
    lists, responses : tuple of bytes
        CRLs and OCSP responses, in DER.
    issuers : mapping
        File of an authority that a person's entry names to its certificates.
    """

    declared: Declared | None = None
    authorities: tuple[Certificate, ...] = ()
    stamping: tuple[Certificate, ...] = ()
    lists: tuple[bytes, ...] = ()
    responses: tuple[bytes, ...] = ()
    issuers: tuple[tuple[str, tuple[Certificate, ...]], ...] = ()

    @property
    def keys(self) -> Keys:
        """Least bits of keys."""
        return self.declared.keys if self.declared else Keys.model_validate({})

    @property
    def usages(self) -> frozenset[str]:
        """Accepted extended key usages, as numbers."""
        named = self.declared.usages if self.declared else tuple(USAGES)
        return frozenset(USAGES.get(name, name) for name in named)

    @property
    def strict(self) -> bool:
        """Whether a certificate whose revocation is unknown is not relied on."""
        return self.declared is not None and bool(self.declared.revocation.required)

    @property
    def stamped(self) -> bool:
        """Whether every signature needs a time stamp."""
        return self.declared is not None and bool(self.declared.time_stamps.required)

    def persons(self, role: str) -> tuple[Person, ...] | None:
        """Who may sign in a role; None where no policy says."""
        return getattr(self.declared.roles, role, ()) if self.declared and self.declared.roles else None


def load(path: Path) -> Policy:
    """Read a trust policy and the files that it names, which lie where it lies.

    Raises
    ------
    MetrologyError
        Every fault of the file; files that cannot be read or hold something else.
    """
    from metrology.signoff.keys import read_certificates

    document = read_document(path)
    declared = _declared(document)

    def certificates(names: Sequence[str]) -> tuple[Certificate, ...]:
        return tuple(found for name in names for found in read_certificates(path.parent / name))

    lists, responses = _revocation(path.parent / name for name in declared.revocation.files)
    roles = declared.roles
    people = (*roles.author, *roles.reviewer, *roles.approver) if roles else ()
    named = dict.fromkeys(person.authority for person in people if person.authority)
    issuers = tuple((name, certificates([name])) for name in named)
    roots = tuple(dict.fromkeys([*certificates(declared.authorities), *(one for _, many in issuers for one in many)]))
    stamping = certificates(declared.time_stamps.authorities)
    return Policy(declared, roots, stamping, lists, responses, issuers)


def _declared(document: Document) -> Declared:
    try:
        found = Declared.model_validate(document.data)
        wrong = []
    except ValidationError as error:
        wrong = refusals(error, Declared.model_fields)
    faults = [fault for _, fault in document.faults]
    faults += [Fault(document.at(*one.loc, key=one.of_key), one.got, one.expected, one.fix) for one in wrong]
    if faults:
        raise MetrologyError(*faults)
    return found


def _revocation(paths: Any) -> tuple[tuple[bytes, ...], tuple[bytes, ...]]:
    """CRLs and OCSP responses in DER."""
    from cryptography import x509
    from cryptography.hazmat.primitives.serialization import Encoding
    from cryptography.x509 import ocsp

    lists, responses = [], []
    for path in paths:
        try:
            data = path.read_bytes()
        except OSError as error:
            raise MetrologyError(Fault(str(path), own_text(error), "a CRL or an OCSP response")) from None
        try:
            pem = data.lstrip().startswith(b"-----BEGIN")
            found = x509.load_pem_x509_crl(data) if pem else x509.load_der_x509_crl(data)
            lists.append(found.public_bytes(Encoding.DER))
        except ValueError:
            try:
                responses.append(ocsp.load_der_ocsp_response(data).public_bytes(Encoding.DER))
            except ValueError:
                raise MetrologyError(Fault(str(path), "neither", "a CRL or an OCSP response")) from None
    return tuple(lists), tuple(responses)
