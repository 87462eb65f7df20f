"""A cause of uncertainty that several quantities share, as a campaign file states it."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError

HEAD = "format: metrology-campaign/1\nid: causes\ntitle: Shared causes\n"
SHARED = """\
causes:
  gauge: {description: one gauge for both, standard: 1 %, source: certificate M-1}
quantities:
  a: {value: 2.00 mm, uncertainty: [{cause: gauge}, {standard: 0.01 mm, source: unevenness}]}
  b: {value: 5.00 mm, uncertainty: [{cause: gauge}]}
derived:
  - {quantity: ratio, expression: a/b, unit: "1"}
  - {quantity: total, expression: a + b, unit: mm}
"""
ELONGATION = """\
instruments:
  indicator:
    kind: dial indicator
    resolution: 0.001 mm
    uncertainty: [{more}]
samples:
  line: {{length: 1.000 m}}
tests:
  pull:
    method: elongation
    sample: line
    instruments: {{extension: indicator}}
    loads: {{A: {{force: 5.00 N}}, B: {{force: 10.00 N}}, C: {{force: 15.00 N}}}}
    readings: pull.csv
"""
READINGS = "load,repeat,direction,reading / mm\n" + "".join(
    f"{load},{repeat},loading,{0.5 * size + 0.003 * ((repeat * 7 + size) % 3 - 1):.3f}\n"
    for load, size in zip("ABC", (1, 2, 3), strict=True)
    for repeat in (1, 2, 3)
)


def campaign(folder: Path, text: str):
    (folder / "pull.csv").write_text(READINGS, encoding="utf-8")
    (folder / "campaign.yaml").write_text(HEAD + text, encoding="utf-8")
    return load(folder / "campaign.yaml")


def results(folder: Path, text: str):
    findings = chain.evaluate(campaign(folder, text))
    return {one.name: one for one in findings.results}, findings


def test_closed_form_a_ratio_is_free_of_the_gauge_and_a_sum_is_not(tmp_path: Path):
    found, findings = results(tmp_path, SHARED)
    assert found["ratio"].u == pytest.approx(0.4 * 0.01 / 2.00)
    assert found["total"].u == pytest.approx(1e-3 * sqrt(0.07**2 + 0.01**2))
    (pair,) = findings.input_correlations
    assert (pair.a, pair.b) == ("a", "b")
    assert pair.coefficient == pytest.approx(0.02 / sqrt(0.02**2 + 0.01**2))
    row = next(row for row in found["total"].budget if row.cause == "gauge")
    assert row.source == "certificate M-1"


def indicator(folder: Path, more: str):
    found, _ = results(folder, ELONGATION.format(more=more))
    rows = {row.component: row for row in found["pull.k"].budget if "indicator" in row.input}
    return found["pull.k"], rows


@pytest.mark.long
def test_law_an_offset_that_all_readings_share_does_not_move_the_slope(tmp_path: Path):
    apart, _ = indicator(tmp_path, "{name: offset, standard: 20 um, source: data sheet}")
    causes = "causes: {offset: {standard: 20 um, source: data sheet}}\n"
    together, _ = results(tmp_path, causes + ELONGATION.format(more="{cause: offset}"))
    none, _ = indicator(tmp_path, "{name: offset, standard: 1e-9 um, source: data sheet}")
    assert apart.u > 1.5 * none.u
    assert together["pull.k"].framework.u == pytest.approx(none.framework.u, rel=1e-6)


def test_closed_form_a_share_of_the_reading_moves_k_by_that_share(tmp_path: Path):
    k, rows = indicator(tmp_path, "{name: linearity, half_width: 0.6 %, distribution: rectangular, source: data sheet}")
    assert abs(rows["linearity"].contribution) == pytest.approx(k.framework.value * 0.006 / sqrt(3), rel=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("[{cause: gauge}]}", "[{cause: gage}]}", "campaign.yaml:8:45 quantities.b.uncertainty[0].cause: got 'gage'"),
        ("quantities:", "  tape: {standard: 1 um}\nquantities:", "causes.tape: got 'tape', which no component names"),
        (
            "[{cause: gauge}]}",
            "[{cause: gauge, half_width: 1 um, distribution: rectangular}]}",
            "got rectangular, where another component of 'gauge' is normal",
        ),
        ("standard: 1 %", "standard: 1 kg", "got '1 kg', a mass"),
        ("standard: 1 %, ", "", "no size"),
    ],
)
def test_refusal_of_causes_that_are_not_shared_or_not_one(tmp_path: Path, old: str, new: str, expected: str):
    with pytest.raises(MetrologyError) as caught:
        campaign(tmp_path, SHARED.replace(old, new))
    assert expected in str(caught.value)


def test_refusal_of_an_instrument_whose_uncertainty_has_no_size(tmp_path: Path):
    with pytest.raises(MetrologyError, match=r"indicator.uncertainty\[0\].standard: got '-1 um'"):
        campaign(tmp_path, ELONGATION.format(more="{standard: -1 um}"))
