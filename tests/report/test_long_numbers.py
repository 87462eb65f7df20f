"""Numbers of many digits: limits as they are stated, no uncertainty dropped, and columns that hold them."""

from __future__ import annotations

import json
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import pages
import pytest
from pypdf import PdfReader

from metrology import chain, report
from metrology.campaign.load import load
from metrology.findings import Findings, to_json
from metrology.language.catalogue import Language
from metrology.report import limits, lines, quality
from metrology.signoff import printed

CAMPAIGN = """
format: metrology-campaign/1
id: long
title: Long numbers
quantities:
  gb: {value: 100.00012 mm, uncertainty: [{standard: 25 nm, source: interferometer}]}
  fr: {value: 10000000.0012 Hz, uncertainty: [{standard: 0.0010 Hz, source: counter}]}
  fo: {value: 12345.6789 N, uncertainty: [{standard: 0.0012 N, source: cell}]}
  m1: {value: 1000.00123 g, uncertainty: [{standard: 0.000025 g, source: balance}]}
  d: {value: 1 N, uncertainty: [{standard: 1e-12 N, source: s}]}
  c: {value: 123456789.123 N, uncertainty: [{standard: 0.002 N, source: s}]}
  a: {value: 1.5e-30 kg, uncertainty: [{standard: 2e-31 kg, source: s}]}
  f: 1.23456789(95) N
derived:
  - {quantity: L1, expression: 1*gb, unit: mm}
  - {quantity: f1, expression: 1*fr, unit: Hz}
  - {quantity: F1, expression: 1*fo, unit: N}
  - {quantity: M1, expression: 1*m1, unit: g}
  - {quantity: D, expression: 1*d, unit: N}
  - {quantity: C, expression: 1*c, unit: N}
  - {quantity: A, expression: 1*a, unit: kg}
  - {quantity: F, expression: 1*f, unit: N}
requirements:
  - {id: R1, quantity: L1, limits: {lower: 100.0000 mm, upper: 0.1000002 m}, decision: {rule: guard band}}
  - {id: R2, quantity: f1, limits: {lower: 9999999.999 Hz}, decision: {rule: guard band}}
  - {id: R4, quantity: F1, limits: {upper: 12345.6 N}, decision: {rule: simple acceptance}}
  - {id: R5, quantity: M1, limits: {lower: 1000.001 g, upper: 1000.002 g}, decision: {rule: guard band}}
  - {id: R6, quantity: D, limits: {lower: 0.9999999999985 N}, decision: {rule: specific risk}}
  - {id: R7, quantity: A, limits: {lower: 1.0e-30 kg}, decision: {rule: guard band}}
"""
STATED = {
    "R1": "100.0000 mm to 0.1000002 m",
    "R2": "≥ 9999999.999 Hz",
    "R4": "≤ 12345.6 N",
    "R5": "1000.001 g to 1000.002 g",
    "R6": "≥ 0.9999999999985 N",
    "R7": "≥ 1.0×10⁻³⁰ kg",
}
ACCEPTED = {
    "R1": "100.000049 mm to 100.000151 mm",
    "R2": "10000000.0010 Hz",
    "R4": "12345.6 N",
    "R5": "1000.001049 g to 1000.001951 g",
}


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> Findings:
    path = tmp_path_factory.mktemp("long") / "campaign.yaml"
    path.write_text(CAMPAIGN, encoding="utf-8")
    return chain.evaluate(load(Path(path)))


def test_law_a_limit_is_printed_with_every_digit_and_the_unit_that_are_stated(long: Findings) -> None:
    assert {one.requirement: limits.limits(one) for one in long.conformity} == STATED
    german = Language("de", comma=True)
    assert limits.limits(long.conformity[1], german) == "≥ 9999999,999 Hz"


def test_law_an_acceptance_limit_has_the_digits_of_its_guard_band(long: Findings) -> None:
    found = {one.requirement: limits.acceptance(one) for one in long.conformity}
    assert {name: found[name] for name in ACCEPTED} == ACCEPTED


def test_law_guard_bands_that_differ_between_the_limits_are_both_printed(long: Findings) -> None:
    one = next(entry for entry in long.conformity if entry.requirement == "R5")
    assert one.lower is not None
    assert one.upper is not None
    alike, apart = (
        replace(one, acceptance_lower=one.lower + 1e-7, acceptance_upper=one.upper - w, guard_band=w)
        for w in (1e-7, 3e-7)
    )
    assert quality.band(alike) == "1.0×10⁻⁴ g"
    assert quality.band(apart) == "1.0×10⁻⁴ / 3.0×10⁻⁴ g"


def test_law_results_of_before_tell_a_limit_by_its_value(long: Findings) -> None:
    older = [replace(one, lower_stated="", upper_stated="") for one in long.conformity]
    assert [limits.limits(one) for one in older[1:4]] == [
        "≥ 9999999.999 Hz", "≤ 12345.6 N", "1000.001 g to 1000.002 g"
    ]  # fmt: skip


def test_law_no_uncertainty_is_dropped_beside_a_long_value(long: Findings) -> None:
    shown = {line.result.quantity: (line.value, line.u, line.expanded) for line in lines.main_results(long)}
    assert shown["f1"] == ("10000000.0012", "0.0010", "0.0020")
    assert shown["C"] == ("123456789.1230", "0.0020", "0.0039")
    assert shown["D"] == ("1.0000000000000", "1.0×10⁻¹²", "2.0×10⁻¹²")
    assert shown["F"][:2] == ("1.23456789", "9.5×10⁻⁷")


PRIOR = """
format: metrology-campaign/1
id: prior
title: A requirement with a prior
quantities:
  x: 10.0(1) mm
derived:
  - {quantity: X, expression: 1*x, unit: mm}
requirements:
  - id: R1
    quantity: X
    limits: {upper: 10.3 mm}
    decision: {rule: simple acceptance}
    prior: {distribution: normal, mean: 10.0 mm, standard: 0.2 mm}
  - {id: R2, quantity: X, limits: {upper: 10.300000000000 mm}, decision: {rule: guard band}}
"""


@pytest.mark.long
@pytest.mark.parametrize("last", [None, -1])
def test_limit_a_table_with_the_global_risk_is_no_wider_than_the_page(last: int | None, tmp_path: Path) -> None:
    path = tmp_path / "campaign.yaml"
    path.write_text("\n".join(PRIOR.splitlines()[:last]), encoding="utf-8")
    pages.assert_whole_rows_and_wide_columns(chain.evaluate(load(path)))


@pytest.mark.long
def test_law_long_numbers_stay_in_their_columns_and_are_read_back_from_the_pages(long: Findings) -> None:
    pages.assert_whole_rows_and_wide_columns(long)
    made = report.make(long)["report.pdf"]
    results = json.loads(to_json(long))["results"]
    assert printed.absent(results, printed.numbers(made)) == []
    first = PdfReader(BytesIO(made)).pages[0].extract_text()
    assert "F1 ≤ 12345.6 N" in " ".join(first.split())
