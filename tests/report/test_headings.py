"""No heading of the table of requirements is broken within a word."""

from __future__ import annotations

from pathlib import Path

import pytest
from pages import printed

from metrology import chain
from metrology.campaign.load import load

TEXT = """\
format: metrology-campaign/1
id: head
title: Long limits, and a prior
report: {number: H-1, issued: 2026-11-20, language: %s}
quantities: {x: 24734(33) N/m}
derived: [{quantity: k, expression: x*1, unit: N/m}]
requirements:
  - id: R1
    quantity: k
    limits: {lower: 24600.12345678 N/m, upper: 24900.12345678 N/m}
    decision: {rule: global risk, risk: 0.01}
    prior: {distribution: normal, mean: 24700 N/m, standard: 100 N/m}
"""


@pytest.mark.long
@pytest.mark.parametrize(("language", "heading"), [("en", "Requirement"), ("de", "Anforderung"), ("fr", "Exigence")])
def test_law_the_heading_of_a_narrow_column_is_whole(language: str, heading: str, tmp_path: Path) -> None:
    (tmp_path / "campaign.yaml").write_text(TEXT % language)
    first, *_ = printed(chain.evaluate(load(tmp_path / "campaign.yaml"), coverage=False), "certificate")
    assert heading in first.extract_text().split()
