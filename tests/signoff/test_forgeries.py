"""Forgeries, careless signatures and genuine reports that look odd: each gives the right one of three outcomes."""

# ruff: noqa: E501  (a table, one case a line)
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from asn1crypto import tsp
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from forging import (
    DAY,
    NOW,
    Pair,
    authority_of_stamps,
    issued,
    revoking,
    rsa_key,
    signed_by,
    signer_of,
    stamped,
    stamper,
    updated,
)
from pyhanko.pdf_utils import generic
from pyhanko.sign.timestamps import DummyTimeStamper
from pypdf import PdfReader, PdfWriter
from pypdf.generic import ArrayObject, DecodedStreamObject, DictionaryObject, FloatObject, NameObject, TextStringObject

from metrology import chain, signoff
from metrology import report as reports
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources
from metrology.findings import Findings, InputFile, to_json
from metrology.report import attachments, crate, document, figures, html, pdf, results
from metrology.signoff.authority import ROLES
from metrology.signoff.keys import read_certificates
from metrology.signoff.opened import open_report
from metrology.signoff.policy import Policy
from metrology.signoff.verification import checks

pytestmark = pytest.mark.study
"""Minutes of signing and rebuilding: with the long studies."""

NAMES = dict(zip(ROLES, ("T. Tester", "Q. Officer", "J. Doe"), strict=True))
TLS, STAMPS, CODE = "1.3.6.1.5.5.7.3.1", "1.3.6.1.5.5.7.3.8", "1.3.6.1.5.5.7.3.3"


@dataclass(eq=False)
class Lab:
    """A laboratory with its authority, its people and one report."""

    folder: Path
    base: bytes
    findings: Findings
    sources: dict[str, bytes]
    test_authority: Path
    root: Pair = field(default_factory=lambda: issued("Lab CA"))
    clock_root: Pair = field(default_factory=lambda: issued("Clock CA"))

    def __post_init__(self) -> None:
        self.people = {role: issued(name, self.root) for role, name in NAMES.items()}
        self.clock = stamper(authority_of_stamps(self.clock_root), self.clock_root)
        self.lists = (revoking(self.root), revoking(self.clock_root))
        self.policy = Policy(authorities=(self.root[1],), stamping=(self.clock_root[1],))
        self.stages = [self.base]
        for role in ROLES:
            self.stages.append(self.sign(self.stages[-1], role))

    def sign(self, content: bytes, role: str, pair: Pair | None = None, **options: Any) -> bytes:
        return signed_by(content, role, signer_of(pair or self.people[role], self.root[1]), **options)

    def all_sign(self, content: bytes, roles: Sequence[str] = ROLES, **options: Any) -> bytes:
        for role in roles:
            content = self.sign(content, role, **options)
        return content

    def with_one(self, role: str, pair: Pair, **options: Any) -> bytes:
        """Signed by all, one of them with another certificate."""
        at = ROLES.index(role)
        return self.all_sign(self.sign(self.stages[at], role, pair, **options), ROLES[at + 1 :])

    def stating(self, **changes: Any) -> bytes:
        """The report with the results.json of other findings, as if it had been made so."""
        return attaching(self.base, {"results.json": to_json(replace(self.findings, **changes))})

    def worth(self, factor: float) -> tuple[Any, ...]:
        """Results of which that of page 1 is multiplied, by the GUM framework, whose value is printed, too."""
        return tuple(
            replace(one, value=one.value * factor, framework=replace(one.framework, value=one.framework.value * factor))
            if one.headline
            else one
            for one in self.findings.results
        )

    def older(self) -> dict[str, str]:
        return {**self.findings.software, "metrology": "0.0.9"}


@pytest.fixture(scope="session")
def lab(campaign: Path, written: Path, authority: Path, tmp_path_factory: pytest.TempPathFactory) -> Lab:
    loaded = load(campaign)
    findings, sources = chain.evaluate(loaded), read_sources(loaded)
    return Lab(tmp_path_factory.mktemp("lab"), written.read_bytes(), findings, sources, authority)


@dataclass(frozen=True)
class Case:
    """What a forger did, and what has to come of it.

    `words`: what the checks that are not good have to say among them. `again`: make the report again from its inputs.
    """

    make: Callable[[Lab], bytes]
    outcome: str
    words: str = ""
    policy: Callable[[Lab], Policy] = lambda lab: lab.policy
    require: tuple[str, ...] = ()
    again: bool = False


CASES: dict[str, Case] = {}


def case(outcome: str, words: str = "", **options: Any) -> Callable[[Callable[[Lab], bytes]], Callable[[Lab], bytes]]:
    def keep(make: Callable[[Lab], bytes]) -> Callable[[Lab], bytes]:
        CASES[make.__name__] = Case(make, outcome, words, **options)
        return make

    return keep


def add(name: str, make: Callable[[Lab], bytes], outcome: str, words: str = "", **options: Any) -> None:
    CASES[name] = Case(make, outcome, words, **options)


# -- genuine

add("genuine", lambda lab: lab.stages[3], "good", again=True)
add("genuine_with_time_stamps", lambda lab: lab.all_sign(lab.base, timestamper=lab.clock), "good")
add("genuine_stamped_by_an_archive", lambda lab: stamped(lab.stages[3], lab.clock), "good", again=True)
add("genuine_stamped_twice", lambda lab: stamped(stamped(lab.stages[3], lab.clock), lab.clock), "good")
add("genuine_between_stamps", lambda lab: lab.all_sign(stamped(lab.stages[1], lab.clock), ROLES[1:]), "good")
add(
    "stamp_of_an_unknown_authority_counts_for_nothing",
    lambda lab: lab.all_sign(lab.base, timestamper=foreign()),
    "good",
)


def foreign(**options: Any) -> DummyTimeStamper:
    root = issued("Other Clock CA")
    return stamper(authority_of_stamps(root, name="Other Clock"), root, **options)


# -- unsigned, or less signed

add("unsigned", lambda lab: lab.base, "failed", "T. Tester, test engineer, has not signed")
add(
    "cut_back_to_the_author",
    lambda lab: lab.stages[3][: len(lab.stages[1])],
    "failed",
    "J. Doe, head of laboratory, has not",
)
add(
    "cut_back_to_the_reviewer",
    lambda lab: lab.stages[3][: len(lab.stages[2])],
    "failed",
    "J. Doe, head of laboratory, has not",
)


@cache
def nobody(lab: Lab, *, everywhere: bool) -> bytes:
    """Who signs is deleted from results.json, and from the campaign file too."""
    alone = replace(lab.findings.campaign, signatures=())
    if not everywhere:
        return lab.stating(campaign=alone)
    text = lab.sources["campaign.yaml"].decode()
    kept = text[: text.index("  signatures:")] + text[text.index("laboratory:") :]
    path = lab.folder / "nobody"
    (path / "readings").mkdir(parents=True, exist_ok=True)
    (path / "campaign.yaml").write_text(kept, encoding="utf-8")
    (path / "readings" / "bridge.csv").write_bytes(lab.sources["readings/bridge.csv"])
    loaded = load(path / "campaign.yaml")
    return reports.make(chain.evaluate(loaded), sources=read_sources(loaded))["report.pdf"]


add("signatories_deleted_from_the_results", partial(nobody, everywhere=False), "failed", "names others who sign")
add(
    "signatories_deleted_everywhere",
    partial(nobody, everywhere=True),
    "incomplete",
    "names nobody who signs",
    again=True,
)
add("signatories_deleted_and_required", partial(nobody, everywhere=True), "failed", "for which the campaign names nobody",
    require=("author",))  # fmt: skip


@case("failed", "the campaign names nobody", require=ROLES)
def own_report_signed_by_its_author_alone(lab: Lab) -> bytes:
    campaign = replace(lab.findings.campaign, signatures=lab.findings.campaign.signatures[:1])
    return lab.sign(lab.stating(campaign=campaign), "author")


# -- other versions, results that the inputs do not give, pages that do not show the results

add(
    "unsigned_of_another_version",
    lambda lab: lab.stating(software=lab.older(), results=lab.worth(1.1)),
    "failed",
    "has not signed",
)
add(
    "another_version",
    lambda lab: lab.all_sign(lab.stating(software=lab.older())),
    "incomplete",
    "other versions here",
    again=True,
)
add("value_of_another_version", lambda lab: lab.all_sign(lab.stating(software=lab.older(), results=lab.worth(1e9))), "failed",
    "does not hold what the attached inputs give", again=True)  # fmt: skip
add("another_schema", lambda lab: lab.all_sign(lab.stating(schema="metrology-results/99")), "incomplete",
    "schema metrology-results/1 for metrology-results/99", again=True)  # fmt: skip
add("value_of_another_schema", lambda lab: lab.all_sign(lab.stating(schema="metrology-results/99", results=lab.worth(2))),
    "failed", "does not hold what the attached inputs give", again=True)  # fmt: skip
add(
    "value",
    lambda lab: lab.all_sign(lab.stating(results=lab.worth(1.0001))),
    "failed",
    "does not hold what",
    again=True,
)
add(
    "sentence",
    lambda lab: lab.all_sign(lab.stating(warnings=("All is well.",))),
    "failed",
    "does not hold what",
    again=True,
)


@case("failed", "does not hold what the attached inputs give", again=True)
def correlation(lab: Lab) -> bytes:
    first, *rest = lab.findings.correlations
    return lab.all_sign(lab.stating(correlations=(replace(first, coefficient=first.coefficient / 2), *rest)))


def shown(lab: Lab, printed: Findings, attached: Findings) -> bytes:
    """Pages of some findings, with the results.json of others."""
    made = results.files(attached)
    made[crate.NAME] = crate.metadata(attached, made)
    files = attachments.gather(attached, made, lab.sources)
    page = html.render(printed, figures.draw(printed, lambda _: None, traces={}), files)
    return pdf.render(page, files, issued=document.issued(printed))


@case("failed", "no page prints value and u", again=True)
def other_number_on_page_1(lab: Lab) -> bytes:
    return lab.all_sign(shown(lab, replace(lab.findings, results=lab.worth(1.1)), lab.findings))


@case("failed", "no page prints value and u", again=True)
def other_number_on_page_1_of_another_version(lab: Lab) -> bytes:
    older = replace(lab.findings, software=lab.older())
    return lab.all_sign(shown(lab, replace(older, results=lab.worth(1.1)), older))


def rewritten(content: bytes, change: Callable[[PdfWriter], None]) -> bytes:
    """The file written anew with a change, as if it had been made so."""
    writer = PdfWriter(clone_from=PdfReader(BytesIO(content)))
    change(writer)
    stream = BytesIO()
    writer.write(stream)
    return stream.getvalue().rstrip() + b"\n"


def attaching(content: bytes, files: dict[str, bytes]) -> bytes:
    """The file with other content of some of its attachments."""

    def change(writer: PdfWriter) -> None:
        names = writer._root_object["/Names"]["/EmbeddedFiles"]["/Names"]
        for name, content in files.items():
            stream = DecodedStreamObject()
            stream.set_data(content)
            names[names.index(name) + 1].get_object()["/EF"][NameObject("/F")] = writer._add_object(stream)

    return rewritten(content, change)


def painted(writer: PdfWriter) -> None:
    page = writer.pages[0]
    more = DecodedStreamObject()
    more.set_data(b"q 1 1 1 rg 100 300 300 100 re f Q")
    page[NameObject("/Contents")] = ArrayObject([page.raw_get("/Contents"), writer._add_object(more)])


def noted(writer: PdfWriter) -> None:
    box = ArrayObject([FloatObject(x) for x in (100, 300, 400, 400)])
    note = DictionaryObject(
        {NameObject("/Type"): NameObject("/Annot"), NameObject("/Subtype"): NameObject("/FreeText"),
         NameObject("/Rect"): box, NameObject("/Contents"): TextStringObject("R = 1 ohm")})  # fmt: skip
    page = writer.pages[0]
    page[NameObject("/Annots")] = ArrayObject([*page.get("/Annots", []), writer._add_object(note)])


def scripted(writer: PdfWriter) -> None:
    script = {NameObject("/S"): NameObject("/JavaScript"), NameObject("/JS"): TextStringObject("app.alert('good')")}
    writer._root_object[NameObject("/OpenAction")] = DictionaryObject(script)


def covered(writer: PdfWriter) -> None:
    """A place for a signature that nobody gives, drawn over page 1."""
    form = DecodedStreamObject()
    form.set_data(b"1 1 1 rg 0 0 300 100 re f")
    form.update(
        {
            NameObject("/Subtype"): NameObject("/Form"),
            NameObject("/BBox"): ArrayObject([FloatObject(x) for x in (0, 0, 300, 100)]),
        }
    )
    drawn = DictionaryObject({NameObject("/N"): writer._add_object(form)})
    box = ArrayObject([FloatObject(x) for x in (100, 300, 400, 400)])
    field = DictionaryObject({NameObject("/Subtype"): NameObject("/Widget"), NameObject("/FT"): NameObject("/Sig"), NameObject("/Rect"): box,
                              NameObject("/T"): TextStringObject("cover"), NameObject("/AP"): drawn})  # fmt: skip
    page = writer.pages[0]
    page[NameObject("/Annots")] = ArrayObject([*page.get("/Annots", []), writer._add_object(field)])


def relinked(writer: PdfWriter) -> None:
    """A link becomes a text: as many annotations as before."""
    note = writer.pages[0]["/Annots"][0].get_object()
    note[NameObject("/Subtype")], note[NameObject("/Contents")] = NameObject("/FreeText"), TextStringObject("R = 1 ohm")


def two_faced(writer: PdfWriter) -> None:
    """An attached file of two contents: one viewer shows this one, another that."""
    names = writer._root_object["/Names"]["/EmbeddedFiles"]["/Names"]
    other = DecodedStreamObject()
    other.set_data(b"quantity,value\nR,1\n")
    names[names.index("results.csv") + 1].get_object()["/EF"][NameObject("/F")] = writer._add_object(other)


for name, change, words in (("painted", painted, "something else is drawn"), ("noted", noted, "something else is drawn"),
                            ("covered", covered, "something else is drawn"), ("relinked", relinked, "something else is drawn"),
                            ("two_faced", two_faced, "the attached results.csv is another one"),
                            ("scripted", scripted, "the file has")):  # fmt: skip
    add(
        f"{name}_before_signing",
        lambda lab, c=change: lab.all_sign(rewritten(lab.base, c)),
        "failed",
        words,
        again=True,
    )
add("painted_by_another_version", lambda lab: lab.all_sign(rewritten(lab.stating(software=lab.older()), painted)), "incomplete",
    "other versions", again=True)  # fmt: skip
add(
    "code_of_its_own", lambda lab: coded(lab), "incomplete", "read what is attached, then give --allow-code", again=True
)


def coded(lab: Lab) -> bytes:
    code = b"raise SystemExit\n"
    digest = hashes.Hash(hashes.SHA256())
    digest.update(code)
    more = InputFile("effect.py", digest.finalize().hex(), len(code))
    changed = replace(lab.findings, inputs=(*lab.findings.inputs, more))
    return lab.all_sign(reports.make(changed, sources={**lab.sources, "effect.py": code})["report.pdf"])


# -- changed before or after the signatures


def hidden(writer: Any) -> None:
    page = writer.root["/Pages"]["/Kids"][0]
    page["/Contents"] = writer.add_object(generic.StreamObject(stream_data=b"% nothing to be seen"))
    writer.update_container(page)


def names_of(writer: Any) -> Any:
    return writer.root["/Names"]["/EmbeddedFiles"]["/Names"]


def swapped(writer: Any) -> None:
    names = names_of(writer)
    place = next(i for i in range(0, len(names), 2) if names[i] == "readings-bridge.csv")
    other = generic.StreamObject(stream_data=b"V / V,I / mA\n1,1\n2,1\n3,1\n")
    names[place + 1]["/EF"]["/F"] = writer.add_object(other)
    writer.update_container(names[place + 1]["/EF"])


def dropped(writer: Any) -> None:
    names = names_of(writer)
    del names[0:2]
    writer.update_container(names)


def stamp_on_page(writer: Any) -> None:
    page = writer.root["/Pages"]["/Kids"][0]
    box = generic.ArrayObject([generic.NumberObject(x) for x in (100, 300, 400, 400)])
    note = {"/Type": "/Annot", "/Subtype": "/Stamp"}
    made = generic.DictionaryObject({generic.pdf_name(k): generic.pdf_name(v) for k, v in note.items()})
    made["/Rect"] = box
    page["/Annots"] = generic.ArrayObject([*page.get("/Annots", []), writer.add_object(made)])
    writer.update_container(page)


def titled(writer: Any) -> None:
    writer.root["/OpenAction"] = generic.DictionaryObject({generic.pdf_name("/S"): generic.pdf_name("/JavaScript")})
    writer.update_root()


def repainted(writer: Any) -> None:
    page = writer.root["/Pages"]["/Kids"][0]
    more = generic.StreamObject(stream_data=b"q 1 1 1 rg 100 300 300 100 re f Q")
    page["/Contents"] = generic.ArrayObject([page.raw_get("/Contents"), writer.add_object(more)])
    writer.update_container(page)


def field_of_text(writer: Any) -> None:
    """A field that shows a text over page 1."""
    page = writer.root["/Pages"]["/Kids"][0]
    field = {"/Subtype": generic.pdf_name("/Widget"), "/FT": generic.pdf_name("/Tx"), "/T": generic.pdf_string("R"),
             "/V": generic.pdf_string("R = 1 ohm"), "/Rect": generic.ArrayObject([generic.NumberObject(x) for x in (100, 300, 400, 400)])}  # fmt: skip
    made = writer.add_object(generic.DictionaryObject({generic.pdf_name(k): v for k, v in field.items()}))
    page["/Annots"] = generic.ArrayObject([*page.get("/Annots", []), made])
    writer.update_container(page)
    writer.root["/AcroForm"] = generic.DictionaryObject({generic.pdf_name("/Fields"): generic.ArrayObject([made])})
    writer.update_root()


for change in (hidden, swapped, dropped, stamp_on_page, titled, repainted, field_of_text):
    name = change.__name__
    add(
        f"{name}_with_the_first_signature",
        lambda lab, c=change: lab.all_sign(lab.sign(lab.base, "author", change=c), ROLES[1:]),
        "failed",
        "something else was added together with the first signature",
    )
for change in (hidden, swapped, dropped, stamp_on_page, titled):
    name = change.__name__
    add(f"{name}_after_signing", lambda lab, c=change: updated(lab.stages[3], c), "failed", "were changed after it")
    add(
        f"{name}_between",
        lambda lab, c=change: lab.all_sign(updated(lab.stages[1], c), ROLES[1:]),
        "failed",
        "something else",
    )
    add(
        f"{name}_before",
        lambda lab, c=change: lab.all_sign(updated(lab.base, c)),
        "failed",
        "something else than signatures",
    )
add(
    "stamped_over_a_change",
    lambda lab: stamped(updated(lab.stages[3], hidden), lab.clock),
    "failed",
    "were changed after it",
)
add("bytes_behind_the_end", lambda lab: lab.stages[3] + b"% more", "failed", "it goes on behind the last signature")


@case("failed", "the bytes that it covers are not those that were signed")
def flipped_bit(lab: Lab) -> bytes:
    damaged = bytearray(lab.stages[3])
    damaged[damaged.index(b"stream", 20_000) + 40] ^= 4
    return bytes(damaged)


@case("failed", "is filled with something")
def room_behind_a_signature_filled(lab: Lab) -> bytes:
    damaged = bytearray(lab.stages[3])
    start = damaged.index(b"/Contents <", len(lab.stages[2]))
    place = damaged.index(b">", start) - 7
    damaged[place] = ord("1")
    return bytes(damaged)


add("drawn_signature", lambda lab: lab.all_sign(lab.sign(lab.base, "author", box=(100, 300, 400, 400)), ROLES[1:]), "failed",
    "a signature is drawn on a page")  # fmt: skip

# -- who signed


def two_persons(lab: Lab) -> Policy:
    return policy_of(lab, reviewer=reviewer_two)


def policy_of(lab: Lab, **roles: Pair) -> Policy:
    """A trust policy by fingerprints, in which some certificate is that of the person named."""
    from metrology.signoff import policy
    from metrology.signoff.certificates import fingerprint

    pairs = lab.people | roles
    declared = {
        "format": "metrology-trust/1",
        "roles": {role: [{"name": NAMES[role], "certificates": [fingerprint(pairs[role][1])]}] for role in ROLES},
    }
    return replace(lab.policy, declared=policy.Declared.model_validate(declared))


twice = ec.generate_private_key(ec.SECP256R1())
reviewer_two: Pair = issued("nobody yet")


@case("failed", "author and reviewer were signed by one person", policy=lambda lab: two_persons(lab))
def one_person_by_two_certificates(lab: Lab) -> bytes:
    global reviewer_two
    reviewer_two = issued("T. Tester", lab.root)
    return lab.with_one("reviewer", reviewer_two)


@case("failed", "author and reviewer were signed by one person")
def one_key_by_two_names(lab: Lab) -> bytes:
    one, other = (issued(NAMES[role], lab.root, key=twice) for role in ("author", "reviewer"))
    return lab.all_sign(lab.sign(lab.sign(lab.base, "author", one), "reviewer", other), ROLES[2:])


add("another_person", lambda lab: lab.with_one("reviewer", issued("A. Other", lab.root)), "failed",
    "the certificate of A. Other, who is not Q. Officer")  # fmt: skip
add("right_name_unknown_certificate", lambda lab: lab.with_one("reviewer", issued("Q. Officer", lab.root)), "failed",
    "none that the trust policy gives to Q. Officer", policy=policy_of)  # fmt: skip
add("genuine_by_policy", lambda lab: lab.stages[3], "good", policy=policy_of)
add("other_authority", lambda lab: lab.with_one("reviewer", issued("Q. Officer", issued("Else CA"))), "failed",
    "leads to no authority that you trust")  # fmt: skip
add("self_signed", lambda lab: lab.with_one("reviewer", issued("Q. Officer")), "failed", "signature of Q. Officer")
add("nobody_trusted", lambda lab: lab.stages[3], "failed", "leads to no authority", policy=lambda _: Policy())
add("role_that_nobody_named", lambda lab: lab.sign(lab.stages[3], "witness", issued("W. Itness", lab.root)), "failed",
    "in a role that the campaign does not name")  # fmt: skip
add(
    "out_of_order", lambda lab: lab.all_sign(lab.base, ("reviewer", "author", "approver")), "failed", "not in the order"
)
add(
    "not_certified",
    lambda lab: lab.all_sign(lab.sign(lab.base, "author", certify=False), ROLES[1:]),
    "failed",
    "does not certify",
)
add(
    "stamp_in_the_place_of_a_signature",
    lambda lab: stamped_as(lab.stages[2], "approver", lab.clock),
    "failed",
    "has not signed",
)
add("test_authority", lambda lab: by_test_authority(lab, "reviewer", "reviewer"), "failed", "leads to no authority")
add("role_of_a_test_authority", lambda lab: by_test_authority(lab, "author", "reviewer"), "failed", "the certificate of TEST author, who is not Q. Officer",
    policy=lambda lab: replace(lab.policy, authorities=(*lab.policy.authorities, *trusting_tests(lab))))  # fmt: skip


def stamped_as(content: bytes, name: str, by: DummyTimeStamper) -> bytes:
    from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
    from pyhanko.sign.signers import PdfTimeStamper

    writer = IncrementalPdfFileWriter(BytesIO(content))
    return bytes(PdfTimeStamper(by, field_name=name).timestamp_pdf(writer, "sha256").getvalue())


def trusting_tests(lab: Lab) -> Sequence[Any]:
    return read_certificates(lab.test_authority / "authority.pem")


def by_test_authority(lab: Lab, key: str, role: str) -> bytes:
    signer = signoff.from_file(lab.test_authority / f"{key}.p12", None, lambda: b"test")
    at = ROLES.index(role)
    return lab.all_sign(signed_by(lab.stages[at], role, signer), ROLES[at + 1 :])


# -- certificates that do not hold


def of(**options: Any) -> Callable[[Lab], bytes]:
    """Signed by all, the reviewer with a certificate of his own name and other properties."""
    return lambda lab: lab.with_one("reviewer", issued("Q. Officer", lab.root, **options))


add("rsa_1024", of(key=rsa_key(1024)), "failed", "a key of 1024 bits of RSA")
add("tls_only", of(extended=[TLS]), "failed", "a certificate for TLS only")
add("time_stamping_only", of(extended=[STAMPS]), "failed", "a certificate for time stamps only")
add("code_signing_only", of(extended=[CODE]), "failed", "a certificate for other purposes only")
add("not_for_signing", of(signs=False), "failed", "not for signing documents")
add("expired", of(days=(-30, -1)), "failed", "a certificate that expired on")
add("not_yet_valid", of(days=(1, 30)), "failed", "not valid before")
add(
    "sha_1_signature",
    lambda lab: lab.with_one("reviewer", lab.people["reviewer"], md_algorithm="sha1"),
    "failed",
    "SHA1",
)


def with_lists(*days: Any, role: str = "reviewer", at: float = 0) -> Callable[[Lab], Policy]:
    span = days or (-1, 30)

    def policy(lab: Lab) -> Policy:
        return replace(lab.policy, lists=(revoking(lab.root, lab.people[role][1], days=span, at=at),))

    return policy


def strict(lab: Lab) -> Policy:
    """Every certificate has to be covered by a list of revoked ones."""
    return asks(lab, revocation={"required": "true"})


def asks(lab: Lab, **further: Any) -> Policy:
    from metrology.signoff import policy

    roles = {
        role: [{"name": NAMES[role], "certificates": list(policy_of(lab).persons(role)[0].certificates)}]
        for role in ROLES
    }
    declared = policy.Declared.model_validate({"format": "metrology-trust/1", "roles": roles, **further})
    return replace(lab.policy, declared=declared)


add("revoked", lambda lab: lab.stages[3], "failed", "the certificate was revoked on", policy=with_lists(at=-0.5))
add(
    "revoked_later_and_no_stamp",
    lambda lab: lab.stages[3],
    "failed",
    "and no time stamp proves",
    policy=with_lists(at=0.0),
)
add(
    "revoked_by_a_list_long_out_of_date",
    lambda lab: lab.stages[3],
    "failed",
    "was revoked on",
    policy=with_lists(-90, -60, at=-70),
)
add("revoked_before_the_stamp", lambda lab: lab.all_sign(lab.base, timestamper=lab.clock), "failed", "was revoked on",
    policy=with_lists(at=-0.5))  # fmt: skip
add("genuine_revoked_after_the_stamp", lambda lab: lab.all_sign(lab.base, timestamper=lab.clock), "good",
    policy=with_lists(-1, 30, at=0.5))  # fmt: skip
add(
    "no_list_of_revoked_ones", lambda lab: lab.stages[3], "incomplete", "no list of revoked certificates", policy=strict
)
add("genuine_with_lists", lambda lab: lab.stages[3], "good", policy=lambda lab: replace(strict(lab), lists=lab.lists))

# -- time stamps

stamps_needed = partial(asks, time_stamps={"required": "true"})
add("no_stamp", lambda lab: lab.stages[3], "incomplete", "it has no time stamp", policy=stamps_needed)
add("stamp_of_nobody_known", lambda lab: lab.all_sign(lab.base, timestamper=foreign()), "incomplete", "counts for nothing",
    policy=stamps_needed)  # fmt: skip
add("archive_of_nobody_known", lambda lab: stamped(lab.stages[3], foreign()), "incomplete", "counts for nothing")
add(
    "stamp_by_a_certificate_for_documents",
    lambda lab: stamped(lab.stages[3], plain_clock(lab)),
    "incomplete",
    "counts for nothing",
)
add(
    "stamp_of_a_day_to_come",
    lambda lab: lab.all_sign(lab.base, timestamper=clock_at(lab, 3)),
    "failed",
    "a time to come",
)
add(
    "stamp_of_other_bytes",
    lambda lab: lab.all_sign(lab.base, timestamper=lying(lab)),
    "failed",
    "its time stamp: it does not belong",
)


def plain_clock(lab: Lab) -> DummyTimeStamper:
    return stamper(issued("Clock", lab.clock_root, key=rsa_key()), lab.clock_root)


def clock_at(lab: Lab, days: float, *, valid: tuple[float, float] = (-400, 365)) -> DummyTimeStamper:
    return stamper(authority_of_stamps(lab.clock_root, days=valid), lab.clock_root, NOW + days * DAY)


class Lying(DummyTimeStamper):
    """Stamps other bytes than it is asked to."""

    def request_tsa_response(self, req: tsp.TimeStampReq) -> tsp.TimeStampResp:
        req["message_imprint"]["hashed_message"] = b"\1" * 32
        return super().request_tsa_response(req)


def lying(lab: Lab) -> DummyTimeStamper:
    honest = lab.clock
    return Lying(honest.tsa_cert, honest.tsa_key)


def long_ago(lab: Lab) -> Policy:
    return replace(lab.policy, authorities=(old_root[1],), stamping=(old_root[1],))


old_root = issued("Old CA", days=(-900, 900))
old_people = {role: issued(name, old_root, days=(-500, -20)) for role, name in NAMES.items()}


def old(days: float, valid: tuple[float, float]) -> DummyTimeStamper:
    return stamper(authority_of_stamps(old_root, days=valid), old_root, NOW + days * DAY)


def signed_long_ago(lab: Lab, **options: Any) -> bytes:
    content = lab.base
    for role in ROLES:
        content = signed_by(content, role, signer_of(old_people[role], old_root[1]), **options)
    return content


add(
    "expired_since_and_stamped",
    lambda lab: signed_long_ago(lab, timestamper=old(-100, (-400, 300))),
    "good",
    policy=long_ago,
)
add("expired_before_the_stamp", lambda lab: signed_long_ago(lab, timestamper=old(-10, (-400, 300))), "failed", "expired on",
    policy=long_ago)  # fmt: skip
add("clock_expired_too", lambda lab: signed_long_ago(lab, timestamper=old(-100, (-400, -30))), "failed", "expired on",
    policy=long_ago)  # fmt: skip
add(
    "genuine_renewed_by_an_archive",
    lambda lab: stamped(signed_long_ago(lab, timestamper=old(-100, (-400, -30))), old(-50, (-400, 300))),
    "good",
    policy=long_ago,
)
add("renewed_too_late", lambda lab: stamped(signed_long_ago(lab, timestamper=old(-100, (-400, -30))), old(-10, (-400, 300))),
    "failed", "expired on", policy=long_ago)  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_planted_forgery_has_the_right_outcome(name: str, lab: Lab, tmp_path: Path) -> None:
    """Where the report is not made again, that alone keeps it from being good: nothing else may."""
    one = CASES[name]
    path = tmp_path / "report.pdf"
    path.write_bytes(one.make(lab))
    sentences = []
    states = []
    again = signoff.Again() if one.again else None
    for check in checks(open_report(path), one.policy(lab), require=one.require, again=again):
        if check.state in ("failed", "not checked") and (again or check.subject != "results"):
            sentences.append(f"{check.subject}: {check.sentence}")
            states.append(check.state)
            if check.state == "failed" and one.words in check.sentence:
                break
    outcome = "failed" if "failed" in states else "incomplete" if states else "good"
    assert outcome == one.outcome, sentences
    assert one.words in " | ".join(sentences), sentences
    assert bool(one.words) == (one.outcome != "good")


def test_limit_there_are_sixty_forgeries() -> None:
    assert sum(one.outcome != "good" for one in CASES.values()) >= 60
