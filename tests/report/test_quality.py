"""What a quality officer looks for: state, verdicts and what is open on page 1; the draft; the filled checklist."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import findings_sample
import pytest
from pypdf import PdfReader

from metrology import checklist
from metrology.findings import Findings, Replaced
from metrology.identification import Signatory
from metrology.report import html, quality, write


def words(page: object) -> str:
    return re.sub(r"\s+", " ", page.extract_text())  # type: ignore[attr-defined]


def text(findings: Findings) -> str:
    """Text of the HTML page without its pictures: what the templates print."""
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", html.render(findings, {}).text))


@pytest.fixture(scope="module")
def drafted(findings: Findings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reports") / "draft"
    short = replace(findings_sample.empty(), campaign=replace(findings.campaign, place="", issued=""))
    write(short, folder)
    return folder


@pytest.mark.long
def test_law_page_one_has_state_verdict_risks_and_what_is_open(report: Path) -> None:
    first = words(PdfReader(report / "report.pdf").pages[0])
    for said in (
        "Complete, but not to be issued",
        "pass",
        "guard band",
        "670 N/m",
        "1.20 %",
        "3.40 %",
        "NCR-7, open",
        "overdue",
    ):
        assert said in first or said in first.replace("0.67 kN/m", "670 N/m"), said
    assert "Linear density of the tape, from Tether Programme Office" in first


@pytest.mark.long
def test_law_a_complete_report_is_no_draft(report: Path) -> None:
    assert "DRAFT" not in " ".join(words(page) for page in PdfReader(report / "report.pdf").pages)
    page = (report / "report.html").read_text("utf-8")
    assert "<body>" in page
    assert 'class="draft-banner"' not in page


@pytest.mark.long
def test_limit_a_report_that_nobody_signs_does_not_promise_to_be_issued(findings: Findings) -> None:
    said = "Complete, but not to be issued: the campaign names nobody who signs"
    assert said in text(findings)
    head = (Signatory("approver", "J. Doe", "head of laboratory"),)
    named = text(replace(findings, campaign=replace(findings.campaign, signatures=head)))
    assert "Complete, to be signed; it is issued once signed" in named
    assert said not in named


@pytest.mark.long
def test_planted_a_draft_says_so_on_every_page_and_in_the_html(drafted: Path) -> None:
    pages = PdfReader(drafted / "report.pdf").pages
    for page in pages:
        assert "DRAFT of test report TR-2026-001" in words(page)
    assert re.search(r"Draft: \d items of the checklist are missing", words(pages[0]))
    assert "not stated: place" in " ".join(words(page) for page in pages)
    assert '<body class="draft">' in (drafted / "report.html").read_text("utf-8")


def test_planted_the_watermark_is_drawn_on_every_page_of_a_draft(drafted: Path, report: Path) -> None:
    def filled(page: object) -> int:
        # A picture of its own, an artifact for those who listen; its letters are filled with the one grey.
        drawn = re.findall(rb"/Artifact\nBMC\n[^B]*?(/x\d+) Do", page.get_contents().get_data())  # type: ignore[attr-defined]
        forms = page["/Resources"].get("/XObject", {})  # type: ignore[index]
        return sum(b"0.92549 0.933333 0.945098 rg" in forms[name.decode()].get_object().get_data() for name in drawn)

    marked = [filled(page) for page in PdfReader(drafted / "report.pdf").pages]
    assert marked == [1] * len(marked)
    assert max(filled(page) for page in PdfReader(report / "report.pdf").pages) == 0


@pytest.mark.parametrize(
    ("verdicts", "unjudged", "expected"),
    [
        ((), (), ""),
        (("pass", "pass"), (), "pass"),
        (("pass", "conditional pass"), (), "conditional pass"),
        (("conditional fail", "conditional pass"), (), "conditional fail"),
        (("pass", "fail", "conditional pass"), (), "fail"),
        (("pass",), ("R9",), "not judged"),
        (("fail",), ("R9",), "fail"),
        ((), ("R9",), "not judged"),
    ],
)
def test_reference_the_overall_verdict_is_the_worst(
    verdicts: tuple[str, ...], unjudged: tuple[str, ...], expected: str, findings: Findings
) -> None:
    entries = tuple(replace(findings.conformity[0], verdict=verdict) for verdict in verdicts)  # type: ignore[arg-type]
    assert quality.overall(replace(findings, conformity=entries, unjudged=unjudged)) == expected


@pytest.mark.long
def test_law_an_amended_report_names_the_one_that_it_replaces(findings: Findings) -> None:
    older = Replaced("TR-2026-000", "2026-11-01", "mass of the plate corrected")
    page = text(replace(findings, campaign=replace(findings.campaign, replaces=older)))
    assert "It replaces TR-2026-000 of 2026-11-01: mass of the plate corrected" in page
    assert "Amended report." not in text(findings)


def test_law_opinions_stand_apart_with_their_person(findings: Findings) -> None:
    page = text(findings)
    apart = page.index("They are no results of tests.")
    assert page.index("The tape is fit for a second deployment.") > apart
    assert page.count("The tape is fit for a second deployment.") == 1
    assert "Opinion of J. Doe, head of laboratory" in page


def test_law_the_annex_shows_every_item_and_where_it_is_shown(findings: Findings) -> None:
    page = html.render(findings, {}).text
    record = checklist.of_findings(findings)
    for standard in checklist.CHECKLISTS:
        for row in checklist.rows(record, standard):
            assert row.clause.replace("<", "&lt;").replace(">", "&gt;") in page
            assert row.state != "missing"
    annex = page[page.index('id="checklist"') :]
    assert annex.count("<tr>") == 2 + sum(map(len, checklist.CHECKLISTS.values()))
    numbers = dict(re.findall(r'<a href="#(\w+)"><span class="count">(\d+)</span>', page))
    for anchor, number in re.findall(r'<a href="#(\w+)">section (\d+)</a>', annex):
        assert numbers[anchor] == number


def test_law_what_is_not_stated_is_not_claimed(findings: Findings) -> None:
    silent = replace(findings.campaign, stated=(), provided=(), deviations=(), anomalies=(), sampling="")
    page = text(replace(findings, campaign=silent))
    assert "every figure is the laboratory" not in page
    assert "as received." not in page
    assert page.count("None stated.") == 2


def test_law_trials_that_are_not_stable_are_told_once(findings: Findings) -> None:
    first = findings.results[0]
    said = "After 1000000 trials the Monte Carlo figures are not stable to the digits asked for."
    trials = replace(first.monte_carlo, converged=False, verdict=f"{first.monte_carlo.verdict} {said}")
    page = text(replace(findings, results=(replace(first, monte_carlo=trials),)))
    assert page.count("stable to the digits") == 1
