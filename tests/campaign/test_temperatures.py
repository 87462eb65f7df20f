"""Degrees Celsius of a difference are refused, those of a temperature are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError

HEAD = """\
format: metrology-campaign/1
id: warm
title: Temperatures
quantities:
  T: 70.0(5) degC
  T2: 20.0(5) degC
  drop: 2.0(1) K
derived:
"""


def written(folder: Path, derived: str, rest: str = "") -> Path:
    path = folder / "campaign.yaml"
    path.write_text(HEAD + f"  - {{quantity: y, {derived}}}\n" + rest, encoding="utf-8")
    return path


def limit(text: str) -> str:
    return f"requirements:\n  - {{id: R, quantity: y, limits: {{upper: {text}}}, decision: {{rule: guard band}}}}\n"


@pytest.mark.parametrize(
    ("derived", "rest", "place"),
    [
        ("expression: T - T2, unit: degC", "", "derived[0].unit"),
        ("expression: drop / 2, unit: degF", "", "derived[0].unit"),
        # 1 K passed a limit of 0.5 °C, which is 273.65 K.
        ("expression: drop / 2, unit: K", limit("0.5 degC"), "requirements[0].limits.upper"),
        ("expression: T - T2, unit: K", "comparisons:\n  - {between: [y, {value: 2 degC, source: s}]}\n",
         "comparisons[0].between[1]"),
    ],
)  # fmt: skip
def test_refusal_a_difference_in_a_unit_with_a_zero_of_its_own(derived, rest, place, tmp_path):
    with pytest.raises(MetrologyError) as caught:
        load(written(tmp_path, derived, rest))
    (fault,) = caught.value.faults
    assert place in fault.where
    assert "K" in fault.fix


@pytest.mark.parametrize(
    ("expression", "found"), [("(T + 3 * T2) / 4", 32.5), ("T + drop", 72.0), ("T2 + drop * (T - T2) / drop", 70.0)]
)
def test_law_a_temperature_is_judged_in_degrees(expression, found, tmp_path):
    path = written(tmp_path, f"expression: {expression}, unit: degC", limit("75 degC"))
    findings = chain.evaluate(load(path), coverage=False)
    assert findings.results[-1].value == pytest.approx(found + 273.15)
    assert findings.conformity[0].verdict == "pass"
