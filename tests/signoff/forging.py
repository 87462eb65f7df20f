"""What a forger or another program can do to a report: sign without any of our refusals, stamp, append, issue."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from io import BytesIO
from typing import Any

from asn1crypto import keys as asn1_keys
from asn1crypto import x509 as asn1_x509
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.x509 import ocsp
from cryptography.x509.oid import NameOID
from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
from pyhanko.sign import fields
from pyhanko.sign.signers import PdfSignatureMetadata, PdfSigner, PdfTimeStamper
from pyhanko.sign.timestamps import DummyTimeStamper
from pyhanko_certvalidator.registry import SimpleCertificateStore

from metrology import signoff
from metrology.signoff.keys import _signer, as_asn1

DAY = timedelta(days=1)
NOW = datetime.now(UTC).replace(microsecond=0)
Pair = tuple[Any, x509.Certificate]


def signed_by(content: bytes, role: str, signer: signoff.Signer, **options: Any) -> bytes:
    """The file with a signature that nobody refused, and with a change that comes with it."""
    writer = IncrementalPdfFileWriter(BytesIO(content))
    options.pop("change", lambda _: None)(writer)
    first = not [one for one in writer.prev.embedded_signatures if one.field_name != role]
    stamper, box = options.pop("timestamper", None), options.pop("box", None)
    metadata = PdfSignatureMetadata(
        field_name=role,
        **({
            "md_algorithm": "sha256",
            "subfilter": fields.SigSeedSubFilter.PADES,
            "certify": first,
            "docmdp_permissions": fields.MDPPerm.FILL_FORMS,
            "signer_key_usage": set(),
        } | options),
    )  # fmt: skip
    spec = fields.SigFieldSpec(sig_field_name=role, box=box)
    return bytes(
        PdfSigner(metadata, signer.pyhanko, timestamper=stamper, new_field_spec=spec).sign_pdf(writer).getvalue()
    )


def updated(content: bytes, change: Callable[[IncrementalPdfFileWriter], None]) -> bytes:
    """The file with a change appended, as PDF editors do it."""
    writer = IncrementalPdfFileWriter(BytesIO(content))
    change(writer)
    stream = BytesIO()
    writer.write(stream)
    return stream.getvalue()


def issued(
    name: str | Sequence[tuple[Any, str]],
    by: Pair | None = None,
    *,
    key: Any = None,
    days: tuple[float, float] = (-1, 365),
    extended: Sequence[str] = (),
    digest: Any = None,
    signs: bool = True,
) -> Pair:
    """A key and a certificate for it, of any strength, span and purpose; a root where nobody issues it."""
    key = key or ec.generate_private_key(ec.SECP256R1())
    parts = [(NameOID.COMMON_NAME, name)] if isinstance(name, str) else list(name)
    subject = x509.Name([x509.NameAttribute(oid, value) for oid, value in parts])
    usage = dict.fromkeys(
        ("key_encipherment", "data_encipherment", "key_agreement", "encipher_only", "decipher_only"), False
    )
    root = by is None
    issuer_key, issuer = (key, subject) if by is None else (by[0], by[1].subject)
    builder = (
        x509.CertificateBuilder(issuer, subject, key.public_key(), x509.random_serial_number())
        .not_valid_before(NOW + days[0] * DAY)
        .not_valid_after(NOW + days[1] * DAY)
        .add_extension(x509.BasicConstraints(ca=root, path_length=None), critical=True)
        .add_extension(
            x509.KeyUsage(digital_signature=signs and not root, content_commitment=signs and not root,
                          key_cert_sign=root, crl_sign=root, **usage), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(issuer_key.public_key()), critical=False)
    )  # fmt: skip
    if extended:
        purposes = x509.ExtendedKeyUsage([x509.ObjectIdentifier(one) for one in extended])
        builder = builder.add_extension(purposes, critical=True)
    return key, builder.sign(issuer_key, digest or hashes.SHA256())


def signer_of(pair: Pair, *chain: x509.Certificate) -> signoff.Signer:
    return signoff.Signer(_signer(pair[0], [pair[1], *chain]), pair[1])


def rsa_key(bits: int = 2048) -> Any:
    return rsa.generate_private_key(public_exponent=65537, key_size=bits)


def authority_of_stamps(root: Pair, *, days: tuple[float, float] = (-1, 365), name: str = "Clock") -> Pair:
    """A certificate for time stamps."""
    return issued(name, root, key=rsa_key(), days=days, extended=["1.3.6.1.5.5.7.3.8"])


def stamper(pair: Pair, root: Pair, at: datetime | None = None) -> DummyTimeStamper:
    """A time-stamping authority on this machine, whose clock stands still where a time is given."""
    store = SimpleCertificateStore()
    store.register(as_asn1(root[1]))
    der = pair[0].private_bytes(
        serialization.Encoding.DER, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    certificate = asn1_x509.Certificate.load(pair[1].public_bytes(serialization.Encoding.DER))
    return DummyTimeStamper(certificate, asn1_keys.PrivateKeyInfo.load(der), certs_to_embed=store, fixed_dt=at)


def stamped(content: bytes, by: DummyTimeStamper, context: Any = None) -> bytes:
    """The file with a time stamp of the whole, as an archive adds it."""
    writer = IncrementalPdfFileWriter(BytesIO(content))
    return bytes(PdfTimeStamper(by).timestamp_pdf(writer, "sha256", validation_context=context).getvalue())


def revoking(root: Pair, *certificates: x509.Certificate, days: tuple[float, float] = (-1, 30), at: float = 0) -> bytes:
    """A list of revoked certificates, in DER."""
    builder = x509.CertificateRevocationListBuilder(root[1].subject, NOW + days[0] * DAY, NOW + days[1] * DAY)
    for one in certificates:
        revoked = x509.RevokedCertificateBuilder(one.serial_number, NOW + at * DAY)
        builder = builder.add_revoked_certificate(revoked.build())
    builder = builder.add_extension(
        x509.AuthorityKeyIdentifier.from_issuer_public_key(root[0].public_key()), critical=False
    ).add_extension(x509.CRLNumber(1), critical=False)
    return builder.sign(root[0], hashes.SHA256()).public_bytes(serialization.Encoding.DER)


def answering(
    root: Pair,
    certificate: x509.Certificate,
    *,
    by: Pair | None = None,
    days: tuple[float, float] = (-1, 30),
    at: float = 0,
) -> bytes:
    """An OCSP response, in DER, that a certificate was revoked; by the root, or by whom it certified."""
    builder = ocsp.OCSPResponseBuilder().add_response(
        cert=certificate, issuer=root[1], algorithm=hashes.SHA256(), cert_status=ocsp.OCSPCertStatus.REVOKED,
        this_update=NOW + days[0] * DAY, next_update=NOW + days[1] * DAY, revocation_time=NOW + at * DAY,
        revocation_reason=None,
    )  # fmt: skip
    key, own = by or root
    builder = builder.responder_id(ocsp.OCSPResponderEncoding.HASH, own).certificates([own])
    return builder.sign(key, hashes.SHA256()).public_bytes(serialization.Encoding.DER)
