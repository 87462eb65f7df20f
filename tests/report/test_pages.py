"""How long reports are, how full their pages, and that every figure and table is numbered and cited."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pages
import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.campaign.starter import create
from metrology.findings import Findings

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"


@cache
def shipped(name: str) -> Findings:
    return chain.evaluate(load(CAMPAIGNS / name / "campaign.yaml"))


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Findings:
    return chain.evaluate(load(create("small", tmp_path_factory.mktemp("starter"))))


def test_limit_one_elongation_is_a_certificate_and_an_annex_of_five_pages_together(small: Findings) -> None:
    assert len(pages.printed(small, "certificate")) <= 2
    assert len(pages.printed(small, "certificate", "annex")) <= 5


@pytest.mark.parametrize("word", ["Figure", "Table"])
def test_law_figures_and_tables_are_numbered_in_order_and_cited(word: str, small: Findings, findings: Findings) -> None:
    for one in (small, findings):
        captions, cited = pages.numbers(pages.printed(one, "certificate", "annex", "quality"), word)
        assert captions == list(range(1, len(captions) + 1))
        assert captions
        assert cited == captions


def test_law_no_page_of_the_annex_is_nearly_empty_but_the_last(small: Findings) -> None:
    found = [pages.filled(page) for page in pages.printed(small, "certificate", "annex")]
    certificate = len(pages.printed(small, "certificate"))
    assert all(part >= 0.6 for part in found[certificate:-1])


@pytest.mark.parametrize(("name", "most"), [("tapes", 16), ("nylon", 12)])
def test_limit_a_shipped_report_is_a_certificate_of_two_pages_and_a_short_annex(name: str, most: int) -> None:
    findings = shipped(name)
    assert len(pages.printed(findings, "certificate")) == 2
    both = pages.printed(findings, "certificate", "annex")
    assert len(both) <= most
    assert all(pages.filled(page) >= 0.6 for page in both[2:-1])
    for word in ("Figure", "Table"):
        captions, cited = pages.numbers(both, word)
        assert captions == cited == list(range(1, len(captions) + 1))
