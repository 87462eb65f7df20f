"""The trust policy of a laboratory, time stamps over HTTP, and the audit trail, by the commands as they are used."""

from __future__ import annotations

import contextlib
import json
import shutil
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest
from asn1crypto import tsp
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID
from forging import Pair, answering, authority_of_stamps, issued, revoking, rsa_key, signed_by, signer_of, stamper

from metrology import audit_trail, cli, signoff
from metrology.errors import MetrologyError
from metrology.signoff.authority import ROLES
from metrology.signoff.certificates import fingerprint
from metrology.signoff.opened import open_report

NAMES = dict(zip(ROLES, ("T. Tester", "Q. Officer", "J. Doe"), strict=True))


class Lab:
    """Keys, certificates and `trust.yaml` in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.root, self.clock_root = issued("Lab CA"), issued("Clock CA")
        self.people = {role: issued(name, self.root) for role, name in NAMES.items()}
        self.clock = stamper(authority_of_stamps(self.clock_root), self.clock_root)
        for name, pair in {"ca": self.root, "clock": self.clock_root, **self.people}.items():
            self.write(name, pair)
        (folder / "ca.crl").write_bytes(revoking(self.root))
        (folder / "clock.crl").write_bytes(revoking(self.clock_root))

    def write(self, name: str, pair: Pair) -> Path:
        key = pair[0].private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        (self.folder / f"{name}.pem").write_bytes(pair[1].public_bytes(serialization.Encoding.PEM))
        (self.folder / f"{name}.key").write_bytes(key)
        return self.folder / f"{name}.pem"

    def policy(self, further: str = "") -> Path:
        lines = ["format: metrology-trust/1", "authorities: [ca.pem]", "roles:"]
        for role, pair in self.people.items():
            lines.append(f"  {role}: [{{name: {NAMES[role]}, certificates: [{fingerprint(pair[1])}]}}]")
        path = self.folder / "trust.yaml"
        path.write_text("\n".join([*lines, further]) + "\n", encoding="utf-8")
        return path


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Lab:
    return Lab(tmp_path_factory.mktemp("lab"))


@pytest.fixture
def made(written: Path, tmp_path: Path) -> Path:
    """The folder of a report, with its trail."""
    return Path(shutil.copytree(written.parent, tmp_path / "bridge"))


@pytest.fixture(scope="module")
def address(lab: Lab) -> Iterator[str]:
    """A time-stamping authority on this machine that answers over HTTP."""

    class Answer(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            request = tsp.TimeStampReq.load(self.rfile.read(int(self.headers["Content-Length"])))
            body = lab.clock.request_tsa_response(request).dump()
            self.send_response(200)
            self.send_header("Content-Type", "application/timestamp-reply")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            pass

    server = HTTPServer(("127.0.0.1", 0), Answer)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    thread.join()
    server.server_close()


def sign(lab: Lab, folder: Path, role: str, *options: str | Path) -> int:
    keys = ["--key", lab.folder / f"{role}.key", "--cert", lab.folder / f"{role}.pem"]
    return cli.main([str(one) for one in ["sign", folder, "--role", role, *keys, *options]])


STAMPS = (
    "time_stamps: {authorities: [clock.pem], required: true}\nrevocation: {files: [ca.crl, clock.crl], required: true}"
)


@pytest.mark.long
def test_law_long_term_signatures_by_a_policy_hold_offline(lab, made, address, capsys, monkeypatch) -> None:
    policy = lab.policy(f"require: [author, reviewer, approver]\n{STAMPS}")
    for role in ROLES:
        assert sign(lab, made, role, "--policy", policy, "--tsa", address, "--long-term") == 0
    monkeypatch.setattr("socket.socket.connect", lambda *_: pytest.fail("something was to be fetched"))
    capsys.readouterr()
    assert cli.main(["verify", str(made), "--policy", str(policy), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["outcome"], told["good"]) == ("good", True)
    sentences = [check["sentence"] for check in told["checks"]]
    assert sum("of Clock: all that was there existed on" in sentence for sentence in sentences) == 3
    assert "4 entries, each with the hash of the one before, as 3 signatures state it; the report is in it" in sentences
    assert open_report(made / "report.pdf").revisions > 6


def test_refusal_no_time_stamp_where_the_policy_asks_for_one(lab, made, capsys) -> None:
    assert sign(lab, made, "author", "--policy", lab.policy(STAMPS)) == 2
    assert "a time stamp, which the trust policy asks for. Fix: give --tsa" in capsys.readouterr().err
    assert sign(lab, made, "author", "--policy", lab.policy(), "--tsa", "http://127.0.0.1:9") == 2
    assert "--tsa: got no time stamp" in capsys.readouterr().err
    assert sign(lab, made, "author", "--tsa", "tsa.example") == 2
    assert "expected an address, such as https://tsa.example" in capsys.readouterr().err
    assert sign(lab, made, "author", "--long-term") == 2
    assert "--long-term" in capsys.readouterr().err


TLS, CLOCK = "1.3.6.1.5.5.7.3.1", "1.3.6.1.5.5.7.3.8"
WRONG = {
    "another person": (lambda lab: issued("A. Other", lab.root), "none that the trust policy gives to T. Tester"),
    "another certificate": (lambda lab: issued("T. Tester", lab.root), "none that the trust policy gives to T. Tester"),
    "weak key": (lambda lab: issued("T. Tester", lab.root, key=rsa_key(1024)), "a key of 1024 bits of RSA"),
    "TLS": (lambda lab: issued("T. Tester", lab.root, extended=[TLS]), "a certificate for TLS only"),
    "time stamps": (lambda lab: issued("T. Tester", lab.root, extended=[CLOCK]), "a certificate for time stamps only"),
    "expired": (lambda lab: issued("T. Tester", lab.root, days=(-9, -1)), "a certificate that expired on"),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_refusal_signs_nothing_that_verify_would_fail(name: str, lab, written: Path, tmp_path: Path) -> None:
    """The words of `sign` are those by which `verify` fails the same certificate."""
    make, words = WRONG[name]
    pair, report, policy = make(lab), tmp_path / "report.pdf", signoff.load_policy(lab.policy())
    shutil.copy(written, report)
    with pytest.raises(MetrologyError, match=words):
        signoff.sign(report, "author", signer_of(pair, lab.root[1]), policy=policy)
    assert report.read_bytes() == written.read_bytes()
    report.write_bytes(signed_by(report.read_bytes(), "author", signer_of(pair, lab.root[1])))
    author = signoff.verify(report, policy, again=None).checks[0]
    assert (author.subject, author.state) == ("author", "failed")
    assert words.partition(";")[0] in author.sentence


def test_refusal_revoked_certificate_foreign_authority_and_one_person_twice(lab, written: Path, tmp_path: Path) -> None:
    report = Path(shutil.copy(written, tmp_path / "report.pdf"))
    (lab.folder / "revoked.crl").write_bytes(revoking(lab.root, lab.people["author"][1], at=-0.5))
    revoked = signoff.load_policy(lab.policy("revocation: {files: [revoked.crl]}"))
    with pytest.raises(MetrologyError, match="one that was revoked on"):
        signoff.sign(report, "author", signer_of(lab.people["author"], lab.root[1]), policy=revoked)
    other = issued("T. Tester", issued("Else CA"))
    foreign = signoff.Policy(authorities=(lab.root[1],))
    with pytest.raises(MetrologyError, match="leads to no authority of the trust policy"):
        signoff.sign(report, "author", signer_of(other), policy=foreign)
    signoff.sign(report, "author", signer_of(lab.people["author"], lab.root[1]), policy=foreign)
    twice = issued("Q. Officer", lab.root, key=lab.people["author"][0])
    with pytest.raises(MetrologyError, match="the certificate that signed as author, or another one of that person"):
        signoff.sign(report, "reviewer", signer_of(twice, lab.root[1]), policy=foreign)


def test_refusal_certificate_with_the_names_of_two(lab, written: Path, tmp_path: Path) -> None:
    """By the first of its names one person signed in the roles of both."""
    report = Path(shutil.copy(written, tmp_path / "report.pdf"))
    names = [(NameOID.COMMON_NAME, "T. Tester"), (NameOID.COMMON_NAME, "Q. Officer")]
    both = signer_of(issued(names, lab.root), lab.root[1])
    with pytest.raises(MetrologyError, match=r"who is not T\. Tester"):
        signoff.sign(report, "author", both, policy=signoff.Policy(authorities=(lab.root[1],)))


def test_law_subject_with_its_authority_is_as_good_as_a_fingerprint(lab, made) -> None:
    person = "{name: T. Tester, subject: CN=T. Tester, authority: ca.pem}"
    path = lab.folder / "by-subject.yaml"
    path.write_text(f"format: metrology-trust/1\nroles:\n  author: [{person}]\n", encoding="utf-8")
    policy = signoff.load_policy(path)
    signer = signer_of(issued("T. Tester", lab.root), lab.root[1])
    signoff.sign(made / "report.pdf", "author", signer, policy=policy)
    assert signoff.verify(made / "report.pdf", policy, again=None).checks[0].state == "good"


@pytest.mark.parametrize(("name", "good"), [("T. Tester", True), ("A. Other", False)])
def test_law_without_roles_the_certificate_has_the_name_that_the_campaign_gives(
    lab, made, name: str, good: bool
) -> None:
    path = lab.folder / "no-roles.yaml"
    path.write_text("format: metrology-trust/1\nauthorities: [ca.pem]\n", encoding="utf-8")
    policy, signer = signoff.load_policy(path), signer_of(issued(name, lab.root), lab.root[1])
    with contextlib.nullcontext() if good else pytest.raises(MetrologyError, match="who is not T"):
        signoff.sign(made / "report.pdf", "author", signer, policy=policy)
    if good:
        assert signoff.verify(made / "report.pdf", policy, again=None).checks[0].state == "good"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("format: metrology-trust/2", "got 'metrology-trust/2'; expected 'metrology-trust/1'"),
        ("format: metrology-trust/1\nkeyz: {}", "'keyz', an unknown key"),
        ("format: metrology-trust/1\nauthorities: [none.pem]", "no such file"),
        ("format: metrology-trust/1\nroles: {author: [{name: A}]}", "neither 'certificates' nor 'subject'"),
        ("format: metrology-trust/1\nroles: {author: [{name: A, subject: CN=A}]}", "anybody can write a subject"),
        ("format: metrology-trust/1\nroles: {author: [{name: A, certificates: [12]}]}", "the SHA-256 of a certificate"),
        ("format: metrology-trust/1\nkeys: {rsa: many}", "a whole number"),
        ("format: metrology-trust/1\nrevocation: {files: [trust.yaml]}", "a CRL or an OCSP response"),
    ],
)
def test_refusal_policy_that_is_wrong(text: str, words: str, tmp_path: Path, capsys) -> None:
    (tmp_path / "trust.yaml").write_text(text + "\n", encoding="utf-8")
    assert cli.main(["verify", str(tmp_path / "x.pdf"), "--policy", str(tmp_path / "trust.yaml")]) == 2
    assert words in capsys.readouterr().err


# -- the audit trail


def trail_checks(folder: Path) -> list[tuple[str, str]]:
    verdict = signoff.verify(folder / "report.pdf", again=None)
    return [(check.state, check.sentence) for check in verdict.checks if check.subject == "audit trail"]


def lines(folder: Path) -> list[bytes]:
    return (folder / audit_trail.NAME).read_bytes().splitlines(keepends=True)


@pytest.mark.long
def test_law_every_command_adds_a_line_and_none_is_changed(campaign: Path, tmp_path: Path, lab) -> None:
    text = campaign.read_text("utf-8").replace(
        "laboratory: {name", "customer: {name: C}\nlaboratory: {country: IT, name"
    )
    campaign = Path(shutil.copytree(campaign.parent, tmp_path / "campaign")) / "campaign.yaml"
    campaign.write_text(text.replace("  number:", "  authorised_by: J. Doe\n  number:"), encoding="utf-8")
    out, seen = tmp_path / "reports", []
    folder = out / "bridge"
    where = ["--output", str(out)]
    export = ["export", "dcc", str(folder / "results.json"), "--output", str(tmp_path / "dcc.xml")]
    for command in (*([name, str(campaign), *where] for name in ("report", "check", "run")), export):
        assert cli.main(command) == 0
        assert lines(folder)[:-1] == seen
        seen = lines(folder)
    assert sign(lab, folder, "author", "--policy", lab.policy()) == 0
    assert lines(folder)[:-1] == seen
    entries = audit_trail.read(folder / audit_trail.NAME)
    assert [entry.command for entry in entries] == ["report", "check", "run", "export", "sign"]
    assert entries[-1].detail.startswith("author: T. Tester, ")
    ((state, sentence),) = trail_checks(folder)
    assert (state, sentence[:9]) == ("good", "5 entries")


@pytest.fixture
def signed(lab, made: Path) -> Path:
    """A folder whose report the author signed: two lines, one of them stated by the signature."""
    signoff.sign(made / "report.pdf", "author", signer_of(lab.people["author"], lab.root[1]))
    return made


def test_planted_line_that_was_changed(signed: Path) -> None:
    content = (signed / audit_trail.NAME).read_bytes()
    (signed / audit_trail.NAME).write_bytes(content.replace(b'"command": "report"', b'"command": "Report"'))
    assert trail_checks(signed) == [("failed", "audit.jsonl: a chain that breaks at line 2")]


def test_planted_trail_that_was_cut(signed: Path) -> None:
    (signed / audit_trail.NAME).write_bytes(b"")
    assert [state for state, _ in trail_checks(signed)] == ["failed", "failed"]
    assert "it has 0 entries, and had 1 when the author signed: it was shortened" in trail_checks(signed)[1][1]


def test_planted_trail_written_anew(signed: Path) -> None:
    """Every hash fits, and yet it is not the one that the author signed."""
    report = (signed / "report.pdf").read_bytes()
    anew = audit_trail.extended(b"", "report", {"report.pdf": report})
    (signed / audit_trail.NAME).write_bytes(anew)
    assert trail_checks(signed) == [
        ("failed", "its first 1 entries are not those that were there when the author signed")
    ]


def test_planted_report_that_the_trail_does_not_know(signed: Path, lab) -> None:
    other = signed_by((signed / "report.pdf").read_bytes(), "reviewer", signer_of(lab.people["reviewer"]))
    (signed / "report.pdf").write_bytes(other)
    assert [state for state, _ in trail_checks(signed)] == ["failed"]


def test_law_report_that_was_sent_alone_is_not_worse_for_it(signed: Path) -> None:
    (signed / audit_trail.NAME).unlink()
    assert [state for state, _ in trail_checks(signed)] == ["note"]


def test_refusal_nothing_is_added_to_a_broken_trail(campaign: Path, signed: Path, capsys) -> None:
    (signed / audit_trail.NAME).write_bytes(b"{}\n")
    assert cli.main(["run", str(campaign), "--output", str(signed.parent)]) == 2
    assert "a chain that breaks at line 1" in capsys.readouterr().err


OCSP_SIGNING = "1.3.6.1.5.5.7.3.9"


@pytest.mark.parametrize("days", [(-1, 30), (-90, -60)])
@pytest.mark.parametrize("by", ["root", "responder", "stranger"])
def test_refusal_certificate_that_an_ocsp_response_names_as_revoked(lab, made, capsys, by: str, days) -> None:
    """However old the response is, and only where the authority gave it, or one that it certified for that."""
    whose = {
        "root": None,
        "responder": issued("Answers", lab.root, extended=[OCSP_SIGNING]),
        "stranger": issued("Answers", lab.root),
    }
    content = answering(lab.root, lab.people["author"][1], by=whose[by], days=days, at=days[0])
    (lab.folder / "author.ocsp").write_bytes(content)
    policy = lab.policy("revocation: {files: [author.ocsp]}")
    assert sign(lab, made, "author") == 0
    capsys.readouterr()
    cli.main(["verify", str(made), "--policy", str(policy), "--signatures-only", "--json"])
    author = json.loads(capsys.readouterr().out)["checks"][0]
    assert ("the certificate was revoked on" in author["sentence"]) == (by != "stranger")
    assert author["state"] == ("good" if by == "stranger" else "failed")


def test_refusal_to_sign_with_a_certificate_that_an_ocsp_response_names_as_revoked(lab, made, capsys) -> None:
    (lab.folder / "author.ocsp").write_bytes(answering(lab.root, lab.people["author"][1], days=(-90, -60), at=-70))
    assert sign(lab, made, "author", "--policy", lab.policy("revocation: {files: [author.ocsp]}")) == 2
    assert "got one that was revoked on" in capsys.readouterr().err


def test_refusal_to_sign_a_report_that_the_trail_does_not_know(lab, made, capsys) -> None:
    """The line of the signature would make it known, and `verify` find nothing wrong any more."""
    other = made.parent / "other"
    shutil.copytree(made, other)
    lines = (other / audit_trail.NAME).read_bytes()
    (other / audit_trail.NAME).write_bytes(audit_trail.extended(b"", "report", {"report.pdf": b"another"}))
    assert sign(lab, other, "author") == 2
    assert "audit trail: no entry knows this report" in capsys.readouterr().err
    (other / audit_trail.NAME).write_bytes(lines)
    assert sign(lab, other, "author") == 0
