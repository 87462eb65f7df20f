"""The certificate: two pages that stand alone, on which nothing that a reader must know is left out or cut."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from io import BytesIO
from pathlib import Path

import pytest
from pypdf import PdfReader

from metrology.findings import Anomaly, AuditRow, Findings, Withheld
from metrology.language.attention import attention
from metrology.language.notices import ORDER, brief
from metrology.report import make
from metrology.report.limits import stated_limits

LONG = "a text that is long enough for several lines of any column of the tables that stand on page 1, " * 3


def pages(findings: Findings) -> list[str]:
    return texts(PdfReader(BytesIO(make(findings)["report.pdf"])))


def texts(reader: PdfReader) -> list[str]:
    return [re.sub(r"\s+", " ", page.extract_text()) for page in reader.pages]


def only(findings: Findings, *parts: str) -> Findings:
    return replace(findings, campaign=replace(findings.campaign, parts=parts))


@pytest.fixture(scope="module")
def crowded(findings: Findings) -> Findings:
    """A short report with many items, requirements and notices, all with long texts."""
    judged, test, item = findings.conformity[0], findings.tests[0], findings.samples[0]
    anomalies = tuple(Anomaly(f"NCR-{i}", f"{LONG} {i}", "open", "") for i in range(100, 106))
    return replace(
        findings,
        campaign=replace(
            findings.campaign,
            parts=("certificate",),
            remarks=LONG,
            anomalies=anomalies,
            deviations=tuple(f"deviation {i}: {LONG}" for i in range(12)),
        ),
        samples=(item, *(replace(item, id=f"S-{i}", name=f"{item.name}, {LONG[:120]}") for i in range(30))),
        tests=(replace(test, exclusions=tuple(f"reading {i} left out: {LONG}" for i in range(3))), *findings.tests[1:]),
        conformity=(
            *(replace(judged, requirement=f"R-{i}", text=LONG[:200]) for i in range(100, 124)),
            replace(judged, requirement="R-124", verdict="fail"),
        ),
    )


@pytest.fixture(scope="module")
def certificate(findings: Findings) -> list[str]:
    return pages(only(findings, "certificate"))


@pytest.fixture(scope="module")
def whole(report: Path) -> list[str]:
    return texts(PdfReader(report / "report.pdf"))


@pytest.mark.long
def test_law_the_certificate_has_two_pages_and_the_annex_begins_a_third(
    certificate: list[str], whole: list[str]
) -> None:
    assert len(certificate) == 2
    assert "Contents of the annex" in whole[2]


@pytest.mark.long
def test_law_the_parts_that_are_wanted_are_printed_and_no_others(
    findings: Findings, certificate: list[str], whole: list[str]
) -> None:
    annex = pages(only(findings, "certificate", "annex"))
    assert len(certificate) < len(annex) < len(whole)
    assert "Uncertainty budget" not in " ".join(certificate)
    assert "Uncertainty budget" in " ".join(annex)
    assert "SHA-256" not in " ".join(annex)
    assert "SHA-256" in " ".join(whole)
    assert "End of report" in certificate[-1]


@pytest.mark.long
def test_law_nothing_that_is_grave_is_left_out_or_cut_on_a_crowded_certificate(crowded: Findings) -> None:
    text = " ".join(pages(crowded))
    due = [item.kind[1:] for item in crowded.instruments if item.state != "valid"]
    assert due
    for words in (*due, *(f"NCR-{i}, open" for i in range(100, 106)), "3 readings or records are excluded"):
        assert words in text, words
    for _, sentence in brief(crowded):
        assert "…" not in sentence
    assert "12 deviations" in text
    assert "more in Items tested" in text
    assert "Remarks. a text" in text
    assert text.index("R-124") < text.index("R-100")
    assert "✗ fail" in text
    assert "R-123" in text


def test_law_every_kind_of_notice_is_on_the_certificate_the_gravest_first(crowded: Findings) -> None:
    for found in (attention(crowded), brief(crowded)):
        kinds = [ORDER.index(kind) for kind, _ in found]
        assert kinds == sorted(kinds)
    assert {kind for kind, _ in attention(crowded)} == {kind for kind, _ in brief(crowded)}


def test_planted_failed_checks_withheld_verdicts_and_poor_fits_are_each_one_sentence(findings: Findings) -> None:
    held = Withheld("R9", "k at least 1 N/m", "al-1100-elongation.k", ("A check failed. It is explained below.",))
    fits = tuple(replace(fit, p_value=1e-9) for fit in findings.fits)
    planted = replace(findings, withheld=(held,), unjudged=("R9", "R8"), fits=fits)
    sentences = [sentence for _, sentence in brief(planted)]
    assert "No verdict on R9: A check failed." in sentences
    assert "No verdict on R8: there is no result with an interval." in sentences
    assert any(sentence.startswith("Not passed: zero shift between repeats") for sentence in sentences)
    assert [sentence for sentence in sentences if "scatter more than stated (p < 10⁻⁶)" in sentence]


@pytest.mark.long
def test_law_a_requirement_that_is_not_judged_shows_its_limits(findings: Findings) -> None:
    judged = next(one for one in findings.conformity if one.lower is not None and one.upper is None)
    same = {each.name: getattr(judged, each.name) for each in fields(Withheld) if each.name != "reasons"}
    held = Withheld(**same, reasons=("A check failed.",))
    others = tuple(one for one in findings.conformity if one is not judged)
    texts = pages(replace(findings, withheld=(held,), unjudged=(held.requirement,), conformity=others))
    low, _ = stated_limits(judged)
    assert f"≥ {low}" in texts[0]
    assert any(f"Limits: {judged.quantity} ≥ {low}." in text for text in texts[1:])


def test_planted_equal_notices_are_one(findings: Findings) -> None:
    row = AuditRow("figure 1", "paper", "1 N", "2 N", "+1 N", agrees=False, sentence="it differs")
    many = replace(findings, audit=tuple(replace(row, figure=f"figure {i}") for i in range(3)))
    (audit,) = [sentence for kind, sentence in brief(many) if kind == "Audit"]
    assert audit == "3 of 3 figures differ from the published or expected one: figure 0; figure 1; figure 2."


@pytest.mark.long
def test_law_anomalies_that_the_evaluation_found_stand_beside_none_during_the_tests(findings: Findings) -> None:
    none = replace(findings.campaign, anomalies=(), stated=("anomalies",))
    text = " ".join(pages(replace(findings, campaign=none)))
    assert "None during the tests. The evaluation found: " in text
