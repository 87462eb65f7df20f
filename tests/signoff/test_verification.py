from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from forging import signed_by, updated
from pyhanko.pdf_utils import generic
from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter

from metrology import chain, report, signoff
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources
from metrology.errors import MetrologyError
from metrology.findings import Findings
from metrology.signoff import rebuild
from metrology.signoff.authority import ROLES, VALID, issue
from metrology.signoff.keys import _signer, read_certificates
from metrology.signoff.opened import open_report

Signers = Callable[[str], signoff.Signer]


@pytest.fixture
def judge(tmp_path: Path, authority: Path) -> Callable[..., dict[str, tuple[str, str]]]:
    """States and sentences of a report's checks by subject; of several on one subject the failed ones, joined."""

    def verdict(content: bytes, *, rebuild: bool = False, **options: object) -> dict[str, tuple[str, str]]:
        path = tmp_path / "judged.pdf"
        path.write_bytes(content)
        again = signoff.Again(options.pop("templates", None)) if rebuild else None
        options = {"trusted": read_certificates(authority / "authority.pem"), "again": again} | options
        found: dict[str, tuple[str, str]] = {}
        outcome = signoff.verify(path, **options)
        for check in outcome.checks:
            known = found.get(check.subject)
            found[check.subject] = (check.state, f"{known[1]}; {check.sentence}" if known else check.sentence)
        found["outcome"] = (outcome.outcome, "")
        return found

    return verdict


@pytest.fixture(scope="session")
def evaluated(campaign: Path) -> tuple[Findings, dict[str, bytes]]:
    loaded = load(campaign)
    return chain.evaluate(loaded), read_sources(loaded)


def states(found: dict[str, tuple[str, str]]) -> dict[str, str]:
    return {subject: state for subject, (state, _) in found.items()}


def hide_page(writer: IncrementalPdfFileWriter) -> None:
    page = writer.root["/Pages"]["/Kids"][0]
    page["/Contents"] = writer.add_object(generic.StreamObject(stream_data=b"% nothing to be seen"))
    writer.update_container(page)


def drop_attachment(writer: IncrementalPdfFileWriter) -> None:
    names = writer.root["/Names"]["/EmbeddedFiles"]["/Names"]
    place = next(i for i in range(0, len(names), 2) if names[i] == "readings-bridge.csv")
    del names[place : place + 2]
    writer.update_container(names)


def swap_attachment(writer: IncrementalPdfFileWriter) -> None:
    names = writer.root["/Names"]["/EmbeddedFiles"]["/Names"]
    place = next(i for i in range(0, len(names), 2) if names[i] == "readings-bridge.csv")
    other = generic.StreamObject(stream_data=b"V / V,I / mA\n1,1\n2,1\n3,1\n")
    names[place + 1]["/EF"]["/F"] = writer.add_object(other)
    writer.update_container(names[place + 1]["/EF"])


@pytest.mark.long
def test_law_signed_report_is_good_and_its_inputs_give_it(stages, judge):
    found = judge(stages[3], rebuild=True)
    assert set(states(found).values()) == {"good"}
    assert list(found) == [*ROLES, "file", "inputs", "results", "numbers", "pages", "outcome"]
    assert "Q. Officer, quality officer: signed 20" in found["reviewer"][1]
    assert "TEST AUTHORITY: for trying out, proves nothing" in found["author"][1]
    assert "to the last bit" in found["results"][1]
    assert "byte for byte" in found["pages"][1]


def test_law_unsigned_report_lacks_its_signatures(stages, judge):
    found = judge(stages[0])
    expected = {"author": "failed", "reviewer": "failed", "approver": "failed", "file": "not checked", "inputs": "good"}
    assert states(found) == expected | {"results": "not checked", "outcome": "failed"}
    assert found["author"][1] == "T. Tester, test engineer, has not signed"


@pytest.mark.parametrize("signed", [1, 2])
def test_planted_file_cut_back_to_an_earlier_signature(signed: int, stages, judge):
    found = judge(stages[3][: len(stages[signed])])
    assert [state for state, _ in found.values()][:3] == ["good"] * signed + ["failed"] * (3 - signed)
    assert "J. Doe, head of laboratory, has not signed" in found["approver"][1]


@pytest.mark.long
@pytest.mark.parametrize("place", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_planted_flipped_bit_is_found(place: float, stages, judge):
    damaged = bytearray(stages[3])
    damaged[int(place * len(stages[0]))] ^= 4
    try:
        found = judge(bytes(damaged))
    except MetrologyError as error:
        assert error.faults[0].expected.startswith("a whole PDF")  # noqa: PT017  (most flips can be read, some cannot)
    else:
        assert all(found[role][0] == "failed" for role in ("author", "reviewer", "approver"))
        assert "the bytes that it covers are not those that were signed" in found["author"][1]


@pytest.mark.long
@pytest.mark.parametrize("from_end", [False, True])
def test_planted_flipped_bit_in_the_last_signature_is_found(from_end: bool, stages, judge):
    damaged = bytearray(stages[3])
    start = damaged.index(b"/Contents <", len(stages[2]))
    place = damaged.index(b">", start) - 7 if from_end else start + 60
    damaged[place] = ord("1") if damaged[place] != ord("1") else ord("2")
    assert judge(bytes(damaged))["approver"][0] == "failed"


@pytest.mark.long
@pytest.mark.parametrize("change", [hide_page, drop_attachment, swap_attachment])
@pytest.mark.parametrize("signed", [1, 3])
def test_planted_change_after_signing_is_found(change, signed: int, stages, judge):
    found = judge(updated(stages[signed], change))
    assert found["author"] == ("failed", found["author"][1])
    assert "were changed after it" in found["author"][1]
    assert "something else than signatures was added" in found["file"][1]


@pytest.mark.parametrize("change", [hide_page, drop_attachment, swap_attachment])
def test_planted_change_that_comes_with_the_first_signature_is_found(change, report: Path, judge, signer: Signers):
    """All signatures cover it, and the bytes before them are those of the report."""
    found = judge(signed_by(report.read_bytes(), "author", signer("author"), change=change))
    assert found["author"][0] == "good"
    assert found["file"] == ("failed", "something else was added together with the first signature")


@pytest.mark.long
@pytest.mark.parametrize("change", [drop_attachment, swap_attachment])
def test_planted_attachment_that_is_not_the_one_evaluated(change, stages, judge, report: Path, signer: Signers):
    changed = updated(stages[0], change)
    assert judge(changed)["inputs"] == ("failed", "not attached as evaluated: readings/bridge.csv")
    report.write_bytes(changed)
    with pytest.raises(MetrologyError, match="is not attached as it was evaluated"):
        signoff.sign(report, "author", signer("author"))


@pytest.mark.long
def test_planted_foreign_certificate(stages, judge, report: Path):
    key, certificate = issue("Q. Officer", issue("Somebody's authority"))
    report.write_bytes(stages[1])
    signoff.sign(report, "reviewer", signoff.Signer(_signer(key, [certificate]), certificate))
    found = judge(report.read_bytes())
    assert found["reviewer"][0] == "failed"
    assert "leads to no authority that you trust (it was issued by Somebody's authority)" in found["reviewer"][1]
    assert found["author"][0] == "good"
    assert judge(stages[3], trusted=())["outcome"][0] == "failed"


def test_planted_certificate_that_had_expired(report: Path, judge):
    root = issue("root", start=datetime.now(UTC) - 2 * VALID)
    key, certificate = issue("T. Tester", root, start=datetime.now(UTC) - VALID - timedelta(days=1))
    forged = signed_by(report.read_bytes(), "author", signoff.Signer(_signer(key, [certificate, root[1]]), certificate))
    found = judge(forged, trusted=[root[1]])
    assert found["author"][0] == "failed"
    assert "a certificate that expired on" in found["author"][1]


def test_limit_certificate_that_expired_since_is_told(report: Path, judge):
    root = issue("root")
    key, certificate = issue("T. Tester", root, start=datetime.now(UTC) - VALID + timedelta(seconds=3))
    signoff.sign(report, "author", signoff.Signer(_signer(key, [certificate]), certificate))
    time.sleep(max(0.0, (certificate.not_valid_after_utc - datetime.now(UTC)).total_seconds()) + 0.1)
    found = judge(report.read_bytes(), trusted=[root[1]])
    assert found["author"][0] == "not checked"
    assert "and no time stamp proves that the signature is older" in found["author"][1]


def test_planted_certificate_of_another_person(report: Path, judge):
    root = issue("root")
    key, certificate = issue("Somebody Else", root)
    signer = signoff.Signer(_signer(key, [certificate]), certificate)
    with pytest.raises(MetrologyError, match=r"the certificate of Somebody Else, who is not T\. Tester"):
        signoff.sign(report, "author", signer)
    report.write_bytes(signed_by(report.read_bytes(), "author", signer))
    found = judge(report.read_bytes(), trusted=[root[1]])
    assert found["author"] == ("failed", "signed with the certificate of Somebody Else, who is not T. Tester")


@pytest.mark.long
def test_planted_results_that_the_inputs_do_not_give(evaluated, judge):
    findings, sources = evaluated
    better = replace(findings.results[0], value=findings.results[0].value * 1.01)
    made = report.make(replace(findings, results=(better, *findings.results[1:])), sources=sources)
    found = judge(made["report.pdf"], rebuild=True)
    assert found["results"][0] == "failed"
    assert f"{better.name}, value: {findings.results[0].value} for {better.value}" in found["results"][1]
    assert found["results"][1].startswith("the attached results.json does not hold what the attached inputs give: ")
    assert found["pages"][0] == "good"  # they print what results.json says


@pytest.mark.long
@pytest.mark.parametrize(("by", "state", "words"), [(0.0, "good", "to the last bit"), (1e-12, "good", "within 1e-09"),
                                                    (1e-8, "failed", "does not hold what")])  # fmt: skip
def test_limit_another_processor_rounds_and_does_not_change(by, state, words, evaluated, judge):
    """Same versions: a value that differs by rounding is the same result, one that differs by more is not."""
    findings, sources = evaluated
    moved = replace(findings.results[0], value=findings.results[0].value * (1 + by))
    made = report.make(replace(findings, results=(moved, *findings.results[1:])), sources=sources)
    found = judge(made["report.pdf"], rebuild=True)["results"]
    assert found[0] == state
    assert words in found[1]


@pytest.mark.long
def test_planted_sentence_that_the_inputs_do_not_give(evaluated, judge):
    findings, sources = evaluated
    made = report.make(replace(findings, warnings=("All is well.",)), sources=sources)
    found = judge(made["report.pdf"], rebuild=True)["results"]
    assert found[0] == "failed"
    assert "warnings" in found[1]


@pytest.mark.long
def test_planted_pages_of_other_templates(evaluated, judge, tmp_path: Path):
    findings, sources = evaluated
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "references.html").write_text("<p>As agreed.</p>", encoding="utf-8")
    made = report.make(findings, sources=sources, templates=mine)["report.pdf"]
    state, sentence = judge(made, rebuild=True)["pages"]
    assert state == "failed"
    assert sentence.startswith("what is printed is not what the attached results.json gives")
    assert judge(made, rebuild=True, templates=mine)["pages"][0] == "good"


@pytest.mark.long
def test_planted_other_versions_are_never_good(evaluated, judge):
    """What another version made cannot be made again: results that lie off fail, the rest is not checked."""
    findings, sources = evaluated
    older = replace(findings, software={**findings.software, "numpy": "0.1"})
    first = older.results[0]
    near = replace(first, value=first.value + 0.5 * rebuild.TOLERANCE * first.u)
    made = report.make(replace(older, results=(near, *older.results[1:])), sources=sources)
    found = judge(made["report.pdf"], rebuild=True)
    assert found["results"][0] == "not checked"
    assert "within 0.01 u, but 1 entry differs, the first: results[0].value" in found["results"][1]
    assert found["pages"] == ("not checked", "other versions are installed here than made the report (numpy)")
    assert found["numbers"][0] == "good"
    far = replace(first, value=first.value + 2 * rebuild.TOLERANCE * first.u)
    made = report.make(replace(older, results=(far, *older.results[1:])), sources=sources)
    assert judge(made["report.pdf"], rebuild=True)["results"][0] == "failed"


@pytest.mark.long
def test_law_report_from_results_alone_says_that_it_lacks_its_sources(evaluated, judge):
    findings, _ = evaluated
    found = judge(report.make(findings)["report.pdf"], rebuild=True)
    assert found["inputs"] == ("not checked", "none is attached: the report was made again from results.json alone")
    assert found["results"][0] == "not checked"
    assert found["pages"][0] == "good"


@pytest.mark.long
def test_law_a_report_with_the_hash_alone_of_a_file_says_so_and_is_incomplete(evaluated, judge):
    findings, sources = evaluated
    campaign, readings = findings.inputs
    made = report.make(replace(findings, inputs=(campaign, replace(readings, attached=False))), sources=sources)
    found = judge(made["report.pdf"], rebuild=True)
    assert found["inputs"] == (
        "not checked", "the hash alone is there of readings/bridge.csv, larger than the campaign attaches"
    )  # fmt: skip
    assert found["results"] == (
        "not checked",
        "of some inputs the hash alone is there, so nothing can be computed from them",
    )
    assert found["pages"][0] == "good"
    hidden = report.make(replace(findings, inputs=(replace(campaign, attached=False), readings)), sources=sources)
    assert judge(hidden["report.pdf"], rebuild=True)["inputs"][0] == "failed"


@pytest.mark.long
@pytest.mark.parametrize("path", ["../campaign.yaml", "/tmp/campaign.yaml", "a/../../x.yaml"])
def test_refusal_attached_path_that_leaves_the_folder(path: str, evaluated, judge, tmp_path: Path):
    findings, sources = evaluated
    first = replace(findings.inputs[0], path=path)
    renamed = {path: sources["campaign.yaml"], "readings/bridge.csv": sources["readings/bridge.csv"]}
    made = report.make(replace(findings, inputs=(first, *findings.inputs[1:])), sources=renamed)
    found = judge(made["report.pdf"], rebuild=True)
    assert found["results"][0] == "failed"
    assert "a path that leaves the campaign's folder" in found["results"][1]
    assert not list(tmp_path.parent.glob("campaign.yaml"))


def test_law_attachments_are_found_where_other_programs_keep_their_list(stages, tmp_path: Path):
    def moved(writer: IncrementalPdfFileWriter) -> None:
        files = writer.root["/Names"]["/EmbeddedFiles"]
        files["/Names"] = writer.add_object(files["/Names"])
        writer.root["/Names"] = writer.add_object(generic.DictionaryObject({"/EmbeddedFiles": files}))
        writer.update_root()

    found = []
    for number, content in enumerate((stages[0], updated(stages[0], moved))):
        path = tmp_path / f"{number}.pdf"
        path.write_bytes(content)
        found.append(open_report(path).attachments)
    assert found[0] == found[1]
    assert "readings-bridge.csv" in found[0]


@pytest.mark.long
def test_refusal_attachments_of_another_kind(evaluated, tmp_path: Path):
    findings, sources = evaluated
    made = report.make(replace(findings, schema="somebody-elses/1"), sources=sources)
    (tmp_path / "x.pdf").write_bytes(made["report.pdf"])
    with pytest.raises(MetrologyError, match="of another kind"):
        signoff.verify(tmp_path / "x.pdf")


def retitle(writer: IncrementalPdfFileWriter) -> None:
    writer.set_info(generic.DictionaryObject({generic.pdf_name("/Title"): generic.pdf_string("Another title")}))


def rename_author(writer: IncrementalPdfFileWriter) -> None:
    metadata = writer.root["/Metadata"]
    changed = metadata.data.replace(b"</rdf:Seq></dc:creator>", b"<rdf:li>A. Forger</rdf:li></rdf:Seq></dc:creator>")
    assert changed != metadata.data
    writer.root["/Metadata"] = writer.add_object(
        generic.StreamObject({generic.pdf_name("/Type"): generic.pdf_name("/Metadata")}, stream_data=changed)
    )
    writer.update_root()


@pytest.mark.long
@pytest.mark.parametrize("change", [retitle, rename_author])
def test_planted_another_title_or_author_of_the_file_behind_the_signatures(change, stages, judge) -> None:
    found = judge(updated(stages[3], change))
    assert found["file"][0] == "failed"
    assert "what the file says of itself, such as its title, was changed" in found["file"][1]
    assert found["outcome"][0] == "failed"
