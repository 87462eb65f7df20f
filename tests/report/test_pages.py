"""How long reports are, how full their pages, and that every figure and table is numbered and cited."""

from __future__ import annotations

from pathlib import Path

import pages
import pytest
import response_sample

from metrology import chain
from metrology.campaign.load import load
from metrology.campaign.starter import create
from metrology.findings import Findings

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Findings:
    return chain.evaluate(load(create("small", tmp_path_factory.mktemp("starter"))))


@pytest.mark.long
def test_limit_one_elongation_is_a_certificate_and_a_full_annex_of_five_pages_together(small: Findings) -> None:
    certificate = len(pages.printed(small, "certificate"))
    both = pages.printed(small, "certificate", "annex")
    assert certificate <= 2
    assert len(both) <= 5
    assert all(pages.filled(page) >= 0.6 for page in both[certificate:-1])


@pytest.mark.long
def test_law_figures_and_tables_are_numbered_in_order_and_cited(small: Findings, findings: Findings) -> None:
    for one in (small, findings):
        whole = pages.printed(one, "certificate", "annex", "quality")
        for word in ("Figure", "Table"):
            captions, cited = pages.numbers(whole, word)
            assert captions
            assert captions == cited == list(range(1, len(captions) + 1))


@pytest.mark.long
def test_law_no_row_of_a_table_is_split_and_no_prose_is_narrow(small: Findings, findings: Findings) -> None:
    for one in (small, response_sample.add(findings)):
        pages.assert_whole_rows_and_wide_columns(one)


@pytest.mark.study
@pytest.mark.parametrize(("name", "most"), [("nylon", 12), ("spectra", 12), ("peek", 12), ("al-1100", 12)])
def test_limit_a_shipped_response_report_has_a_certificate_of_two_pages_at_most_and_a_short_annex(
    name: str, most: int
) -> None:
    pages.assert_short(chain.evaluate(load(CAMPAIGNS / name / "campaign.yaml")), most)
