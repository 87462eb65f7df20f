"""Keys and certificates: PKCS#12 and PEM files, PKCS#11 tokens; what does not fit together is refused."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError, own_text

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

Password = Callable[[], bytes]


@dataclass(frozen=True)
class Signer:
    """Who signs, as pyHanko wants it, and the certificate."""

    pyhanko: Any
    certificate: Certificate


def from_file(key: Path, certificate: Path | None, password: Password) -> Signer:
    """Read a key with its certificate.

    Parameters
    ----------
    key : Path
        PKCS#12, which holds the certificate too, or a private key in PEM.
    certificate : Path, optional
        For a key in PEM: its certificate, and those that lead to the authority behind it.
    password : callable
        Asked only where the key is encrypted.

    Raises
    ------
    MetrologyError
        For files that cannot be read, a wrong password, a key that does not belong to the certificate, a certificate
        that is expired, not valid yet, or not for signing.
    """
    data = _read(key)
    if data.lstrip().startswith(b"-----BEGIN"):
        private, chain = _from_pem(key, data, certificate, password)
    elif certificate is not None:
        got = f"{certificate} together with {key}"
        raise MetrologyError(Fault("--cert", got, "a key in PEM with --cert, or PKCS#12 alone, which holds both"))
    else:
        private, chain = _from_pkcs12(key, data, password)
    _refuse_kind(private, key)
    check_certificate(chain[0], certificate or key)
    return Signer(_signer(private, chain), chain[0])


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise MetrologyError(Fault(str(path), own_text(error), "a file to read")) from None


def _from_pem(key: Path, data: bytes, certificate: Path | None, password: Password) -> tuple[Any, list[Certificate]]:
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    if b"PRIVATE KEY-----" not in data:
        raise MetrologyError(Fault(str(key), "no private key", "PKCS#12 with key and certificate, or a key in PEM"))
    if certificate is None:
        raise MetrologyError(Fault(str(key), "a key alone", "its certificate too, with --cert"))
    chain = read_certificates(certificate)
    private = _unlocked(key, lambda secret: load_pem_private_key(data, secret), password)
    if _public(private.public_key()) != _public(chain[0].public_key()):
        got = f"the key of another certificate than {certificate}"
        raise MetrologyError(Fault(str(key), got, "the key that belongs to it"))
    return private, chain


def _from_pkcs12(key: Path, data: bytes, password: Password) -> tuple[Any, list[Certificate]]:
    from cryptography.hazmat.primitives.serialization.pkcs12 import load_key_and_certificates

    private, own, others = _unlocked(key, lambda secret: load_key_and_certificates(data, secret), password)
    if private is None or own is None:
        raise MetrologyError(Fault(str(key), "PKCS#12 without a key and its certificate", "both of them"))
    if _public(private.public_key()) != _public(own.public_key()):
        raise MetrologyError(Fault(str(key), "a key that does not match its certificate", "the key that belongs to it"))
    return private, [own, *others]


def _unlocked(key: Path, load: Callable[[bytes | None], Any], password: Password) -> Any:
    """Load a key, with a password only where it wants one."""
    try:
        return load(None)
    except (TypeError, ValueError):
        pass
    try:
        return load(password())
    except (TypeError, ValueError) as error:
        raise MetrologyError(
            Fault(str(key), "a wrong password, or a file that is no key", "PKCS#12 or PEM, and its password")
        ) from error


def _refuse_kind(private: Any, key: Path) -> None:
    """Refuse keys that cannot sign with SHA-256, which Ed25519 and its like do not know."""
    from cryptography.hazmat.primitives.asymmetric import ec, rsa

    if not isinstance(private, ec.EllipticCurvePrivateKey | rsa.RSAPrivateKey):
        kind = type(private).__name__.removesuffix("PrivateKey").strip("_")
        raise MetrologyError(Fault(str(key), f"a key of the kind {kind}", "an RSA or an ECDSA key"))


def _public(key: Any) -> bytes:
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

    return bytes(key.public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo))


def read_certificates(path: Path) -> list[Certificate]:
    """Certificates of a PEM or DER file, one at least.

    Raises
    ------
    MetrologyError
        Where there is none.
    """
    from cryptography import x509

    data = _read(path)
    try:
        pem = data.lstrip().startswith(b"-----BEGIN")
        return x509.load_pem_x509_certificates(data) if pem else [x509.load_der_x509_certificate(data)]
    except ValueError:
        raise MetrologyError(Fault(str(path), "no certificate", "certificates in PEM, or one in DER")) from None


def check_certificate(certificate: Certificate, where: Path | str) -> None:
    """Refuse a certificate that cannot sign today, whoever it is of."""
    from metrology.signoff.certificates import objections
    from metrology.signoff.policy import Policy

    against = [Fault(str(where), one.got, one.expected) for one in objections(certificate, Policy(), datetime.now(UTC))]
    if against:
        raise MetrologyError(*against)


def _signer(private: Any, chain: Sequence[Certificate]) -> Any:
    from asn1crypto import keys  # type: ignore[import-untyped]
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
    from pyhanko.sign.signers import SimpleSigner
    from pyhanko_certvalidator.registry import SimpleCertificateStore

    own, *others = (as_asn1(certificate) for certificate in chain)
    store = SimpleCertificateStore()  # type: ignore[no-untyped-call]
    store.register_multiple(others)
    der = private.private_bytes(Encoding.DER, PrivateFormat.PKCS8, NoEncryption())
    return SimpleSigner(signing_cert=own, signing_key=keys.PrivateKeyInfo.load(der), cert_registry=store)


def as_asn1(certificate: Certificate) -> Any:
    """The certificate as pyHanko reads it."""
    from asn1crypto import x509
    from cryptography.hazmat.primitives.serialization import Encoding

    return x509.Certificate.load(certificate.public_bytes(Encoding.DER))


def from_token(module: Path, token: str, label: str, password: Password) -> Signer:
    """Use a key that stays on a PKCS#11 token.

    Parameters
    ----------
    module : Path
        The library of the token's maker.
    token : str
        Label of the token.
    label : str
        Label that key and certificate share on it.
    password : callable
        Asked for the PIN.

    Raises
    ------
    MetrologyError
        Where module, token, PIN or label are wrong, or the certificate cannot sign today.
    """
    from cryptography import x509
    from pyhanko.config.pkcs11 import TokenCriteria
    from pyhanko.sign import pkcs11

    where = f"{module}, token '{token}'"
    session = None
    try:
        session = pkcs11.open_pkcs11_session(
            str(module), token_criteria=TokenCriteria(label=token), user_pin=password().decode()
        )
        signer = pkcs11.PKCS11Signer(session, cert_label=label, key_label=label)
        own = x509.load_der_x509_certificate(signer.signing_cert.dump())
        signer.use_raw_mechanism = _wants_a_digest(session, signer.signing_cert.public_key.algorithm)
    except Exception as error:  # noqa: BLE001  (the token's library has errors of its own)
        if session is not None:
            session.close()
        got = f"{type(error).__name__}{f': {error}' if str(error) else ''}"
        raise MetrologyError(Fault(where, got, f"a token with key and certificate '{label}', and its PIN")) from None
    check_certificate(own, where)
    return Signer(signer, own)


def _wants_a_digest(session: Any, algorithm: str) -> bool:
    """Whether a token signs digests only: many, SoftHSM 2.6 too, have ECDSA, but not ECDSA with SHA-256."""
    from pkcs11 import Mechanism

    whole = {"ec": Mechanism.ECDSA_SHA256, "rsa": Mechanism.SHA256_RSA_PKCS}
    return algorithm in whole and whole[algorithm] not in session.token.slot.get_mechanisms()
