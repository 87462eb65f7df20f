"""Probabilities and comparisons of skewed results and of few readings, where a normal distribution would be wrong."""

from __future__ import annotations

from math import exp, log, sqrt
from pathlib import Path

import pytest
from scipy.stats import norm, t

from metrology import chain
from metrology.campaign.load import load
from metrology.findings import Conformity, Findings

HEAD = "format: metrology-campaign/1\nid: known\ntitle: Known answers\nseed: 5\n"
REQUIREMENT = """\
requirements:
  - {{id: R1, text: a limit, quantity: {name}, limits: {{{side}: {limit}}}, decision: {{rule: {rule}}}}}
"""


def evaluated(folder: Path, text: str) -> Findings:
    (folder / "campaign.yaml").write_text(HEAD + text, encoding="utf-8")
    return chain.evaluate(load(folder / "campaign.yaml"))


def judged(
    folder: Path, text: str, name: str, limit: str, side: str = "upper", rule: str = "simple acceptance"
) -> Conformity:
    (verdict,) = evaluated(folder, text + REQUIREMENT.format(name=name, side=side, limit=limit, rule=rule)).conformity
    return verdict


MODULUS = """\
quantities:
  k: 24734.25 N/m
  L: 2.990 m
  w: 25.00 mm
  t: {value: 0.0500 mm, uncertainty: [{standard: 10 %}]}
derived:
  - {quantity: E, expression: k*L/(w*t), unit: GPa}
"""


def test_closed_form_a_quotient_exceeds_its_limit_three_times_as_often_as_a_normal_distribution_says(tmp_path: Path):
    """E > 73 GPa where t < t₀·E₀/73 GPa: Φ((E₀/73 − 1)/0.1) = 2.9 %; with u(E) = 0.1·E₀ a normal one says 1.0 %."""
    nominal = 24734.25 * 2.990 / (25e-3 * 0.05e-3) / 1e9
    expected = norm.cdf((nominal / 73 - 1) / 0.1)
    assert norm.sf((73 - nominal) / (0.1 * nominal)) == pytest.approx(0.0098, abs=2e-4)
    verdict = judged(tmp_path, MODULUS, "E", "73 GPa")
    assert 1 - verdict.probability == pytest.approx(expected, rel=0.03)
    assert verdict.specific_risk == pytest.approx(expected, rel=0.03)


def test_closed_form_a_limit_beyond_every_possible_value_is_met_for_certain(tmp_path: Path):
    text = "quantities: {a: {value: 10 mm, uncertainty: [{half_width: 1 mm, distribution: rectangular}]}}\n"
    text += "derived: [{quantity: twice, expression: 2*a, unit: mm}]\n"
    verdict = judged(tmp_path, text, "twice", "22.1 mm")
    assert (verdict.verdict, verdict.probability, verdict.specific_risk) == ("pass", 1.0, 0.0)


def test_closed_form_a_square_at_zero_has_the_distribution_of_chi_squared(tmp_path: Path):
    """Y = X² with X standard normal: P(Y < 3) = 2Φ(√3) − 1 = 0.917; the framework has u(Y) = 0 and would say 1."""
    text = "quantities: {x: 0.0(10)}\nderived: [{quantity: y, expression: x**2}]\n"
    verdict = judged(tmp_path, text, "y", "3")
    assert verdict.probability == pytest.approx(2 * norm.cdf(sqrt(3)) - 1, abs=2e-3)


def test_closed_form_the_risk_of_a_lognormal_result_is_that_of_its_own_tail(tmp_path: Path):
    """Y = exp(X), X normal with σ = 0.5: at ln-distance z below the limit the risk is Φ(−z), twice the normal one."""
    text = "quantities: {x: 0.0(5)}\nderived: [{quantity: y, expression: exp(x)}]\n"
    limit = exp(0.5 * 1.7)
    mean, sd = exp(0.125), sqrt((exp(0.25) - 1) * exp(0.25))
    verdict = judged(tmp_path, text, "y", f"{limit!r}")
    assert verdict.specific_risk == pytest.approx(norm.sf(1.7), rel=0.05)
    assert log(limit) / 0.5 == pytest.approx(1.7)
    assert norm.sf(1.7) > 1.9 * norm.sf((limit - mean) / sd)


def test_closed_form_en_of_three_readings_takes_the_expanded_uncertainty_of_three_readings(tmp_path: Path):
    """U = t(2 dof)·u = 4.30 u, not 2 u: a difference of 2.44 u is E_n = 0.57, not 1.22."""
    readings = [9.9, 10.0, 10.1]
    u = 0.1 / sqrt(3)
    other = 10.0 + 2.44 * u
    text = f"""\
quantities: {{a: {{value: 10.0 mm, uncertainty: [{{standard: {u!r} mm, dof: {len(readings) - 1}}}]}}}}
derived: [{{quantity: same, expression: a, unit: mm}}]
comparisons:
  - {{title: against a value, between: [same, {{value: {other!r} mm, source: handbook}}]}}
"""
    (compared,) = evaluated(tmp_path, text).comparisons
    assert abs(compared.en) == pytest.approx(2.44 / t.ppf(0.975, 2), rel=0.03)
    assert compared.agrees
