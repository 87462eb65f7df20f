"""Page 1 of the PDF: what is grave stands there, however long the campaign's names, texts and tables are."""

from __future__ import annotations

import re
from dataclasses import replace
from io import BytesIO

import pytest
from pypdf import PdfReader

from metrology import report
from metrology.findings import Anomaly, Findings
from metrology.report.notices import GRAVE, attention, noted

LONG = "a text that is long enough for several lines of any column of the tables that stand on page 1, " * 3


def pages(findings: Findings) -> list[str]:
    reader = PdfReader(BytesIO(report.make(findings)["report.pdf"]))
    return [re.sub(r"\s+", " ", page.extract_text()) for page in reader.pages]


@pytest.fixture(scope="module")
def crowded(findings: Findings) -> Findings:
    """A short report with many items, requirements and notices, all with long texts."""
    judged, test, item = findings.conformity[0], findings.tests[0], findings.samples[0]
    anomalies = tuple(Anomaly(f"NCR-{i}", f"{LONG} {i}", "open", "") for i in range(100, 106))
    return replace(
        findings,
        campaign=replace(
            findings.campaign,
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


def test_law_all_that_is_grave_stands_on_page_one_of_a_crowded_report(crowded: Findings) -> None:
    first, second, *_ = pages(crowded)
    due = [f"{item.kind} {item.id}: " for item in crowded.instruments if item.state != "valid"]
    assert due
    said = [*due, *(f"NCR-{i}, open" for i in range(100, 106)), *(f"reading {i} left out" for i in range(3))]
    for words in said:
        assert words in first, words
    assert re.search(r"\d+ further: .*\d+ deviation", first)
    assert "more in Items tested" in first
    assert "Remarks. a text" in first
    assert first.index("R-124") < first.index("R-100")
    assert "✗ fail" in first
    assert "R-123" in first + second


def test_limit_more_grave_notices_than_a_page_holds_are_counted_there(findings: Findings) -> None:
    anomalies = tuple(Anomaly(f"NCR-{i}", "W" * 200, "open", "") for i in range(100, 200))
    many = replace(findings, campaign=replace(findings.campaign, anomalies=anomalies))
    first = pages(many)[0]
    told = sum(f"NCR-{i}, open" in first for i in range(100, 200))
    counted = re.search(r"(\d+) anomaly", first)
    assert counted
    assert told + int(counted[1]) == 100
    assert told > 20


def test_law_the_gravest_come_first(crowded: Findings) -> None:
    kinds = [kind in GRAVE for kind, _ in attention(crowded)]
    assert kinds == sorted(kinds, reverse=True)
    assert sum(kinds) <= len(noted(crowded).short)
