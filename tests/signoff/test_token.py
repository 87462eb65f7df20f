"""A key that never leaves its token: signed through PKCS#11, by a software token."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from metrology import signoff
from metrology.errors import MetrologyError
from metrology.signoff.keys import read_certificates

MODULES = [path for folder in ("/usr/lib", "/usr/lib64", "/usr/local/lib", "/opt/homebrew/lib")
           for path in sorted(Path(folder).glob("**/libsofthsm2.so"))]  # fmt: skip
TOOL = shutil.which("softhsm2-util")
pytestmark = pytest.mark.skipif(not MODULES or not TOOL, reason="no SoftHSM")
TOKEN, LABEL, PIN = "Staff card", "signature", "5678"


@pytest.fixture(scope="module")
def token(authority: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The module of a token that holds key and certificate of the author."""
    home = tmp_path_factory.mktemp("token")
    (home / "tokens").mkdir()
    (home / "softhsm2.conf").write_text(f"directories.tokendir = {home / 'tokens'}\n", encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOFTHSM2_CONF", str(home / "softhsm2.conf"))
        _store(authority / "author.p12", home)
        yield MODULES[0]


def _store(source: Path, home: Path) -> None:
    import pkcs11
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
    from cryptography.hazmat.primitives.serialization.pkcs12 import load_key_and_certificates
    from pkcs11.util.x509 import decode_x509_certificate

    key, own, _ = load_key_and_certificates(source.read_bytes(), b"test")
    assert key is not None
    assert own is not None
    (home / "key.pem").write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    named = ["--label", TOKEN, "--pin", PIN]
    for command in (
        [TOOL, "--init-token", "--free", "--so-pin", "1234", *named],
        [TOOL, "--import", str(home / "key.pem"), "--token", TOKEN, "--label", LABEL, "--id", "01", "--pin", PIN],
    ):
        subprocess.run(command, check=True, capture_output=True)
    with pkcs11.lib(str(MODULES[0])).get_token(token_label=TOKEN).open(rw=True, user_pin=PIN) as session:
        stated = decode_x509_certificate(own.public_bytes(Encoding.DER))
        session.create_object({**stated, pkcs11.Attribute.LABEL: LABEL, pkcs11.Attribute.ID: b"\x01",
                               pkcs11.Attribute.TOKEN: True})  # fmt: skip


@pytest.mark.long
def test_law_a_report_signed_by_a_token_is_verified(token: Path, report: Path, authority: Path, tmp_path: Path) -> None:
    pin = tmp_path / "pin.txt"
    pin.write_text(f"{PIN}\n", encoding="utf-8")
    before = report.read_bytes()
    command = [sys.executable, "-m", "metrology", "sign", str(report), "--role", "author", "--pkcs11", str(token)]
    command += ["--token", TOKEN, "--label", LABEL, "--password-file", str(pin)]
    answer = subprocess.run(command, check=False, capture_output=True, text=True)
    assert "signed as author; to sign: reviewer, approver" in answer.stdout, answer.stderr
    assert report.read_bytes().startswith(before)
    verdict = signoff.verify(report, read_certificates(authority / "authority.pem"), again=None)
    (author,) = [check for check in verdict.checks if check.subject == "author"]
    assert author.state == "good", author.sentence
    assert [check.state for check in verdict.checks if check.subject == "file"] == ["good"]


@pytest.mark.parametrize(
    ("label", "name", "pin", "told"),
    [
        (TOKEN, LABEL, "0000", "PinIncorrect"),
        ("Other card", LABEL, PIN, "token"),
        (TOKEN, "other", PIN, "certificate"),
    ],
)
def test_refusal_wrong_token_label_or_pin(token: Path, label: str, name: str, pin: str, told: str) -> None:
    with pytest.raises(MetrologyError, match=rf"(?i){told}.*expected a token with key and certificate"):
        signoff.from_token(token, label, name, pin.encode)
