from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from datetime import UTC, date, datetime, timedelta
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ed25519, rsa
from pyhanko.pdf_utils import generic
from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
from pyhanko.pdf_utils.reader import PdfFileReader
from pypdf import PdfReader, PdfWriter

from metrology import chain, cli, signoff
from metrology.campaign import days
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources
from metrology.errors import MetrologyError
from metrology.report import write
from metrology.signoff.authority import issue

Signers = Callable[[str], signoff.Signer]


def refusal(report: Path, role: str, signer: signoff.Signer) -> str:
    """Message of a refused signature; the file must be what it was."""
    before = report.read_bytes()
    with pytest.raises(MetrologyError) as caught:
        signoff.sign(report, role, signer)
    assert report.read_bytes() == before
    assert [path.name for path in report.parent.iterdir() if path.name.startswith(".")] == []
    return str(caught.value)


def pem(folder: Path, key: object, certificate: object, password: bytes | None = None) -> tuple[Path, Path]:
    lock = serialization.BestAvailableEncryption(password) if password else serialization.NoEncryption()
    formats = (serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, lock)
    (folder / "key.pem").write_bytes(key.private_bytes(*formats))
    (folder / "cert.pem").write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    return folder / "key.pem", folder / "cert.pem"


def test_law_every_signature_leaves_what_was_there_before(stages):
    for before, after in pairwise(stages):
        assert after.startswith(before)
        assert len(after) > len(before)


def test_law_first_signature_certifies_and_all_are_pades(stages):
    found = PdfFileReader(BytesIO(stages[-1])).embedded_signatures
    assert [one.field_name for one in found] == ["author", "reviewer", "approver"]
    assert {str(one.sig_object["/SubFilter"]) for one in found} == {"/ETSI.CAdES.detached"}
    assert [one.docmdp_level.name if one.docmdp_level else "" for one in found] == ["FILL_FORMS", "", ""]
    assert found[0].sig_object["/Name"] == "T. Tester"
    assert "TEST AUTHORITY" in found[0].sig_object["/Reason"]


def test_refusal_role_twice_out_of_turn_and_not_named(report: Path, stages, signer: Signers):
    message = "without the signature of the author; expected signatures in the order author, reviewer, approver"
    assert message in refusal(report, "reviewer", signer("reviewer"))
    assert "the role 'witness'; expected one of author, reviewer, approver" in refusal(
        report, "witness", signer("author")
    )
    report.write_bytes(stages[1])
    assert "a report that is signed as author" in refusal(report, "author", signer("author"))
    message = (
        "the certificate that signed as author, or another one of that person; expected a certificate of Q. Officer"
    )
    assert message in refusal(report, "reviewer", signer("author"))


def test_refusal_campaign_names_nobody(campaign: Path, signer: Signers, tmp_path: Path):
    folder = tmp_path / "campaign"
    shutil.copytree(campaign.parent, folder)
    text = re.sub(r"  signatures:\n(    .*\n)+", "", campaign.read_text("utf-8"))
    (folder / "campaign.yaml").write_text(text, encoding="utf-8")
    loaded = load(folder / "campaign.yaml")
    write(chain.evaluate(loaded), tmp_path / "out", sources=read_sources(loaded))
    assert "name the person under `report.signatures`" in refusal(
        tmp_path / "out" / "report.pdf", "author", signer("author")
    )


@pytest.mark.long
def test_refusal_of_a_report_that_is_dated_after_today(report: Path, signer: Signers, monkeypatch):
    monkeypatch.setattr(days, "today", lambda: date(2026, 11, 19))
    assert "got a report of 2026-11-20; expected one that is not dated after today" in refusal(
        report, "author", signer("author")
    )


@pytest.mark.long
def test_refusal_draft(campaign: Path, signer: Signers, tmp_path: Path):
    folder = tmp_path / "campaign"
    shutil.copytree(campaign.parent, folder)
    text = campaign.read_text("utf-8").replace("checklists: []", "checklists: [17025]")
    (folder / "campaign.yaml").write_text(text, encoding="utf-8")
    loaded = load(folder / "campaign.yaml")
    write(chain.evaluate(loaded), tmp_path / "out", sources=read_sources(loaded))
    message = refusal(tmp_path / "out" / "report.pdf", "author", signer("author"))
    assert message.count("a draft: ") > 3  # everything that is missing, at once
    assert "customer" in message
    told = signoff.verify(tmp_path / "out" / "report.pdf", again=None)
    (state,) = (check for check in told.checks if check.subject == "state")
    assert (state.state, told.good) == ("failed", False)
    assert "7.8.2.1 e" in state.sentence  # the customer


def test_refusal_changed_before_signing(report: Path, signer: Signers):
    with report.open("rb+") as stream:
        writer = IncrementalPdfFileWriter(stream)
        page = writer.root["/Pages"]["/Kids"][0]
        page["/Rotate"] = generic.NumberObject(90)
        writer.update_container(page)
        writer.write_in_place()
    assert "something else than signatures was added" in refusal(report, "author", signer("author"))


def test_refusal_changed_after_a_signature(report: Path, stages, signer: Signers):
    damaged = bytearray(stages[1])
    damaged[len(stages[0]) // 2] ^= 1
    report.write_bytes(bytes(damaged))
    message = refusal(report, "reviewer", signer("reviewer"))
    assert "does not hold" in message or "damaged" in message


@pytest.mark.parametrize("kind", ["text", "foreign", "truncated", "encrypted", "empty", "missing"])
def test_refusal_what_is_no_report_of_ours(kind: str, report: Path, signer: Signers):
    content = report.read_bytes()
    if kind == "encrypted":
        writer = PdfWriter(clone_from=report)
        writer.encrypt("secret")
        writer.write(report)
    elif kind == "foreign":
        writer = PdfWriter()
        writer.add_blank_page(100, 100)
        writer.write(report)
    elif kind == "missing":
        with pytest.raises(MetrologyError, match="no such file"):
            signoff.sign(report.parent / "other.pdf", "author", signer("author"))
        return
    else:
        report.write_bytes({"text": b"Dear all,", "empty": b"", "truncated": content[: len(content) // 2]}[kind])
    expected = {"text": "no PDF", "empty": "no PDF", "foreign": "without results.json", "encrypted": "encrypted PDF"}
    assert expected.get(kind, "a damaged or truncated PDF") in refusal(report, "author", signer("author"))


def test_refusal_wrong_password(authority: Path, tmp_path: Path):
    with pytest.raises(MetrologyError, match="a wrong password"):
        signoff.from_file(authority / "author.p12", None, lambda: b"guess")
    key, certificate = pem(tmp_path, *issue("A"), password=b"right")
    with pytest.raises(MetrologyError, match="a wrong password"):
        signoff.from_file(key, certificate, lambda: b"wrong")


def test_refusal_key_of_another_certificate(tmp_path: Path):
    root = issue("root")
    key, _ = issue("A", root)
    _, other = issue("B", root)
    with pytest.raises(MetrologyError, match="the key of another certificate"):
        signoff.from_file(*pem(tmp_path, key, other), lambda: b"")


@pytest.mark.parametrize(("start", "message"), [(-400, "expired on"), (30, "not valid before")])
def test_refusal_certificate_that_is_not_valid_today(start: int, message: str, tmp_path: Path):
    key, certificate = issue("A", issue("root"), start=datetime.now(UTC) + timedelta(days=start))
    with pytest.raises(MetrologyError, match=message):
        signoff.from_file(*pem(tmp_path, key, certificate), lambda: b"")


def test_refusal_certificate_that_is_not_for_signing(tmp_path: Path):
    with pytest.raises(MetrologyError, match="not for signing"):
        signoff.from_file(*pem(tmp_path, *issue("root")), lambda: b"")


def test_refusal_files_that_are_no_keys(tmp_path: Path, authority: Path):
    (tmp_path / "x").write_text("no key", encoding="utf-8")
    with pytest.raises(MetrologyError, match="a file that is no key"):
        signoff.from_file(tmp_path / "x", None, lambda: b"")
    with pytest.raises(MetrologyError, match="a key alone"):
        signoff.from_file(pem(tmp_path, *issue("A"))[0], None, lambda: b"")
    with pytest.raises(MetrologyError, match="PKCS#12 alone"):
        signoff.from_file(authority / "author.p12", authority / "authority.pem", lambda: b"test")
    with pytest.raises(MetrologyError, match="no certificate"):
        signoff.from_file(tmp_path / "key.pem", tmp_path / "x", lambda: b"")
    with pytest.raises(MetrologyError, match="a test authority"):
        signoff.create_authority(authority)


def test_refusal_certificate_in_the_place_of_a_key_asks_for_no_password(tmp_path: Path):
    _, certificate = pem(tmp_path, *issue("A"))
    for beside in (certificate, None):
        with pytest.raises(MetrologyError, match="no private key"):
            signoff.from_file(certificate, beside, lambda: pytest.fail("asked for a password that nothing needs"))


def test_refusal_key_that_cannot_sign_with_sha_256(tmp_path: Path):
    key, certificate = ed25519.Ed25519PrivateKey.generate(), issue("A")[1]
    builder = x509.CertificateBuilder(certificate.issuer, certificate.subject, key.public_key(), 1)
    builder = builder.not_valid_before(certificate.not_valid_before_utc)
    own = builder.not_valid_after(certificate.not_valid_after_utc).sign(key, None)
    with pytest.raises(MetrologyError, match="a key of the kind Ed25519; expected an RSA or an ECDSA key"):
        signoff.from_file(*pem(tmp_path, key, own), lambda: b"")


def test_refusal_locked_key_where_nobody_can_be_asked(report: Path, tmp_path: Path):
    key, certificate = pem(tmp_path, *issue("A"), password=b"lock")
    command = [sys.executable, "-m", "metrology", "sign", str(report), "--role", "author", "--key", str(key)]
    told = subprocess.run(
        [*command, "--cert", str(certificate)],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        start_new_session=True,
        check=False,
    )
    assert told.returncode == 2
    assert "expected a terminal to ask for it, or --password-file" in told.stderr
    assert "Traceback" not in told.stderr


def test_law_password_is_asked_only_where_the_key_is_locked(tmp_path: Path):
    root = issue("root")
    key, certificate = issue("A", root)

    def never() -> bytes:
        raise AssertionError("asked for a password that nothing needs")

    signoff.from_file(*pem(tmp_path, key, certificate), never)
    asked = signoff.from_file(*pem(tmp_path, key, certificate, b"lock"), lambda: b"lock")
    assert asked.certificate == certificate


def test_law_rsa_keys_sign_too(report: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "cryptography.hazmat.primitives.asymmetric.ec.generate_private_key",
        lambda _curve: rsa.generate_private_key(public_exponent=65537, key_size=2048),
    )
    root = issue("root")
    signoff.sign(report, "author", signoff.from_file(*pem(tmp_path, *issue("T. Tester", root)), lambda: b""))
    author = signoff.verify(report, [root[1]], again=None).checks[0]
    assert author.state == "good"
    assert author.sentence.endswith("with the certificate of T. Tester")


def test_refusal_folder_that_is_closed(report: Path, signer: Signers):
    report.parent.chmod(0o555)
    try:
        told = refusal(report, "author", signer("author"))
        assert "write-protected" in told
        assert "--output" not in told  # sign has no such option
    finally:
        report.parent.chmod(0o755)


@pytest.mark.long
def test_law_signed_report_is_not_overwritten(campaign: Path, stages, tmp_path: Path):
    loaded = load(campaign)
    findings, sources = chain.evaluate(loaded), read_sources(loaded)
    folder = tmp_path / "bridge"
    folder.mkdir()
    (folder / "report.pdf").write_bytes(stages[1])
    write(findings, folder, sources=sources)  # the same report: the signature stays
    assert (folder / "report.pdf").read_bytes() == stages[1]
    with pytest.raises(MetrologyError, match="a signed report of other content"):
        write(findings, folder)
    assert (folder / "report.pdf").read_bytes() == stages[1]
    assert PdfReader(folder / "report.pdf").attachments


@pytest.mark.long
def test_law_commands_sign_and_verify(report: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    keys = tmp_path / "keys"
    assert cli.main(["authority", str(keys)]) == 0
    assert "TEST AUTHORITY" in capsys.readouterr().out
    for role in ("author", "reviewer", "approver"):
        password = ["--password-file", str(keys / "password.txt")]
        assert (
            cli.main(["sign", str(report.parent), "--role", role, "--key", str(keys / f"{role}.p12"), *password]) == 0
        )
    assert capsys.readouterr().out.splitlines()[-1].endswith("signed as approver; all have signed")
    trust = ["--trust", str(keys / "authority.pem")]
    assert cli.main(["verify", str(report), *trust]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "good"
    assert cli.main(["verify", str(report), *trust, "--signatures-only"]) == 3
    assert capsys.readouterr().out.splitlines()[-1] == "INCOMPLETE: 1 of 6 checks could not be made"
    assert cli.main(["verify", str(report), "--signatures-only"]) == 1
    assert cli.main(["verify", str(tmp_path / "nothing.pdf")]) == 2
    assert cli.main(["sign", str(report), "--role", "author", "--pkcs11", "/nowhere.so"]) == 2
    assert "--token" in capsys.readouterr().err
    key = ["--key", str(keys / "author.p12")]
    assert cli.main(["sign", str(report), "--role", "author", *key, "--label", "x"]) == 2
    assert "with --pkcs11 only" in capsys.readouterr().err
    assert cli.main(["sign", str(report), "--role", "author", "--pkcs11", "/nowhere.so", "--cert", "x"]) == 2
    assert "the token holds the certificate" in capsys.readouterr().err
    own, other = (["--trust", str(tmp_path / f"{name}.pem")] for name in ("own", "other"))
    (tmp_path / "own.pem").write_bytes((keys / "authority.pem").read_bytes())
    (tmp_path / "other.pem").write_bytes(issue("other")[1].public_bytes(serialization.Encoding.PEM))
    assert cli.main(["verify", str(report), *own, *other, "--signatures-only"]) == 3
