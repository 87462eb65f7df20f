"""A test authority, for trying out: a root and a certificate a role, each marked as proving nothing."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from metrology.errors import Fault, MetrologyError, own_text, without

MARK = "TEST AUTHORITY"
"""Stands in the name of every certificate that a test authority issues; `metrology verify` looks for it."""

ROLES = ("author", "reviewer", "approver")
PASSWORD = "test"  # noqa: S105  (of keys that prove nothing)
VALID = timedelta(days=365)


def create(folder: Path) -> tuple[Path, ...]:
    """Write a test authority into a new folder: its root, a PKCS#12 file a role, and their password.

    Returns
    -------
    tuple of Path
        The files; the root, `authority.pem`, first.

    Raises
    ------
    MetrologyError
        Where the folder holds one already, or cannot be written.
    """
    if (folder / "authority.pem").exists():
        raise MetrologyError(Fault(str(folder), "a test authority", "a folder without one", "use it, or name another"))
    files = {**_made(), "password.txt": f"{PASSWORD}\n".encode()}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            path = folder / name
            path.touch(mode=0o644 if name == "authority.pem" else 0o600)
            path.write_bytes(content)
    except OSError as error:
        raise MetrologyError(Fault(str(folder), own_text(error), "a folder that can be written")) from error
    return tuple(folder / name for name in files)


def _made() -> dict[str, bytes]:
    try:
        from cryptography.hazmat.primitives import serialization
        from cryptography.hazmat.primitives.serialization import pkcs12
    except ImportError:
        raise without("cryptography", "sign", "metrology authority") from None
    root_key, root = issue(f"{MARK} (proves nothing)")
    lock = serialization.BestAvailableEncryption(PASSWORD.encode())
    files = {"authority.pem": root.public_bytes(serialization.Encoding.PEM)}
    for role in ROLES:
        key, certificate = issue(f"TEST {role}", (root_key, root))
        content = pkcs12.serialize_key_and_certificates(role.encode(), key, certificate, [root], lock)
        files[f"{role}.p12"] = content
    return files


def issue(name: str, by: tuple[Any, Any] | None = None, *, start: datetime | None = None) -> tuple[Any, Any]:
    """A fresh key and a certificate for it: a root of its own, or one that signs documents, issued by a root.

    Parameters
    ----------
    name : str
        Common name.
    by : tuple of key and certificate, optional
        The root that issues it; without one it is a root itself.
    start : datetime, optional
        When it becomes valid, for a year; today where nothing is said.
    """
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes
    from cryptography.hazmat.primitives.asymmetric import ec

    key = ec.generate_private_key(ec.SECP256R1())
    start = start or datetime.now(UTC) - timedelta(minutes=5)
    subject = _name(name)
    issuer_key, issuer = (key, subject) if by is None else (by[0], by[1].subject)
    builder = (
        x509.CertificateBuilder(subject_name=subject, issuer_name=issuer, public_key=key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(start)
        .not_valid_after(start + VALID)
        .add_extension(x509.BasicConstraints(ca=by is None, path_length=0 if by is None else None), critical=True)
        .add_extension(_usage(root=by is None), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(issuer_key.public_key()), critical=False)
    )
    return key, builder.sign(issuer_key, hashes.SHA256())


def _name(name: str) -> Any:
    from cryptography import x509
    from cryptography.x509.oid import NameOID

    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])


def _usage(*, root: bool) -> Any:
    from cryptography import x509

    return x509.KeyUsage(
        digital_signature=not root,
        content_commitment=not root,
        key_cert_sign=root,
        crl_sign=root,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        encipher_only=False,
        decipher_only=False,
    )
