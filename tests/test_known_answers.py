"""Probabilities and comparisons of skewed results and of few readings, where a normal distribution would be wrong."""

from __future__ import annotations

from dataclasses import replace
from math import exp, log, sqrt
from pathlib import Path

import pytest
from scipy.integrate import quad
from scipy.stats import expon, lognorm, norm, t

from metrology import chain
from metrology.campaign.load import load
from metrology.findings import Conformity, Findings
from metrology.language.display import chance
from metrology.report import html
from metrology.report.figures import conformity
from metrology.report.lines import main_results

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


FLAT = """\
quantities: {a: {value: 0.0 um, uncertainty: [{half_width: 4 um, distribution: rectangular, source: x}]}}
derived: [{quantity: d, expression: 1*a, unit: um}]
requirements:
  - {id: R1, quantity: d, limits: {lower: -3.9 um, upper: 3.9 um}, decision: {rule: guard band, binary: true}}
"""


@pytest.mark.parametrize("seed", range(1, 7))
def test_closed_form_a_rectangular_distribution_is_judged_alike_whatever_the_seed(tmp_path: Path, seed: int):
    """±4 µm: U = 0.95·4 µm = 3.8 µm on both sides, so that 0 lies within ±0.1 µm and passes."""
    (tmp_path / "campaign.yaml").write_text(HEAD.replace("seed: 5", f"seed: {seed}") + FLAT, encoding="utf-8")
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"))
    (result,), (verdict,) = findings.results, findings.conformity
    assert (result.monte_carlo.reported, result.monte_carlo.converged) == ("symmetric", True)
    assert result.interval == pytest.approx((-3.8e-6, 3.8e-6), abs=0.02e-6)
    assert verdict.verdict == "pass"
    assert (verdict.low, verdict.high) == result.interval
    assert verdict.guard_band == pytest.approx((result.interval[1] - result.interval[0]) / 2, rel=1e-12)
    assert main_results(findings)[0].expanded == "3.8"


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_closed_form_an_exponential_distribution_is_reported_by_its_shortest_interval(tmp_path: Path, seed: int):
    """0.5 mm + 0.5 mm·Exp(1): from 0.5 mm to 0.5 mm·(1 + ln 20) = 1.998 mm, and w = 0.5 mm at a lower limit."""
    text = "quantities: {x: {value: 1.00 mm, uncertainty: [{standard: 0.50 mm, distribution: exponential}]}}\n"
    text += "derived: [{quantity: X, expression: 1*x, unit: mm}]\n"
    text += REQUIREMENT.format(name="X", side="lower", limit="0.49 mm", rule="guard band")
    (tmp_path / "campaign.yaml").write_text(HEAD.replace("seed: 5", f"seed: {seed}") + text, encoding="utf-8")
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"))
    (result,), (verdict,) = findings.results, findings.conformity
    assert result.monte_carlo.reported == "shortest"
    assert result.interval == pytest.approx((0.5e-3, 0.5e-3 * (1 + log(20))), abs=0.01e-3)
    assert (verdict.verdict, main_results(findings)[0].expanded) == ("pass", "–")
    assert verdict.guard_band == pytest.approx(0.5e-3, rel=5e-3)


GLOBAL = """\
requirements:
  - {id: R1, quantity: X, limits: {lower: 0.6 mm}, decision: {rule: simple acceptance},
     prior: {distribution: lognormal, median: 1 mm, sigma: 0.3}}
"""


def test_twice_global_risks_of_an_exponential_result_are_those_of_exponential_errors(tmp_path: Path):
    """η gives the result η + 0.5 − 0.5·Exp(1) mm; with normal errors of the same u 1.98 % and 20.3 % came out."""
    text = "quantities: {x: {value: 1.00 mm, uncertainty: [{standard: 0.50 mm, distribution: exponential}]}}\n"
    text += "derived: [{quantity: X, expression: 1*x, unit: mm}]\n" + GLOBAL

    def rate(eta: float) -> float:
        return expon.cdf((eta - 0.1) / 0.5) * lognorm.pdf(eta, 0.3)

    consumer = quad(rate, 0.1, 0.6)[0]
    producer = lognorm.sf(0.6, 0.3) - quad(rate, 0.6, 2.0)[0] - quad(rate, 2.0, 20.0)[0]
    (verdict,) = evaluated(tmp_path, text).conformity
    assert (consumer, producer) == pytest.approx((0.02557, 0.16051), abs=1e-5)
    assert (verdict.global_consumer_risk, verdict.global_producer_risk) == pytest.approx((consumer, producer), rel=5e-3)


UNSEEN = """\
quantities:
  x: {value: 1 mm, uncertainty: [{half_width: 0.5 mm, distribution: rectangular}, {standard: 0.1 mm}]}
derived: [{quantity: X, expression: 1*x, unit: mm}]
requirements:
  - {id: R1, quantity: X, limits: {lower: 0.1461 mm}, decision: {rule: specific risk, risk: 0.000001}}
  - {id: R2, quantity: X, limits: {lower: 0.25 mm}, decision: {rule: specific risk, risk: 0.001}}
"""


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_limit_a_risk_that_the_draws_cannot_show_is_told_alike_everywhere(tmp_path: Path, seed: int):
    """P(X < 0.1461 mm) is 5·10⁻⁶: 100 000 draws mostly show none, which passed by an agreed risk of 10⁻⁶."""
    (tmp_path / "campaign.yaml").write_text(HEAD.replace("seed: 5", f"seed: {seed}") + UNSEEN, encoding="utf-8")
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"))
    small, large = findings.conformity
    assert findings.results[0].monte_carlo.trials == 1_000_000  # of the 100/risk that are asked for what is allowed
    assert (small.verdict, small.acceptance_lower) == ("conditional pass", None)
    assert "The draws cannot show the agreed risk of 1×10⁻⁶" in small.sentence
    assert large.verdict == "pass"  # P(X < 0.25 mm) is 2.1·10⁻⁴
    assert large.specific_risk == pytest.approx(2.1e-4, rel=0.2)
    told = chance(small.specific_risk, small.resolution)
    assert f"conforming all the same is {told}." in small.sentence
    assert told in html.render(findings, {}).text.split("Contents")[0].replace("&lt;", "<")


HEAVY = """\
quantities:
  stiff: 2.96e6 N/m
  t: {value: 8 um, uncertainty: [{standard: 1 um, dof: 2, type: A}]}
derived: [{quantity: E, expression: stiff/t, unit: GPa}]
requirements:
  - {id: R1, quantity: E, limits: {lower: 200 GPa, upper: 600 GPa}, decision: {rule: guard band}}
"""


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_closed_form_a_quotient_without_moments_has_the_median_and_u_by_its_interval(tmp_path: Path, seed: int):
    """E = 2960/(8 + t₂): 1/E is Student's, so that every quantile is known; the mean of the draws does not exist."""
    (tmp_path / "campaign.yaml").write_text(HEAD.replace("seed: 5", f"seed: {seed}") + HEAVY, encoding="utf-8")
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"))
    (result,), (verdict,) = findings.results, findings.conformity
    low, high = result.interval
    # E is negative where the denominator is; of the others it is below e where that is above 2960/e.
    median = 2960e9 / (8 + t.isf(0.5 - t.cdf(-8, 2), 2))
    assert result.value == pytest.approx(median, rel=1e-3)
    assert result.u == pytest.approx((high - low) / 2 / norm.ppf(0.975), rel=1e-12)
    share = t.sf(2960e9 / high - 8, 2) - t.sf(2960e9 / low - 8, 2)
    assert share == pytest.approx(0.95, abs=2e-3)
    assert (verdict.value, verdict.u, verdict.low, verdict.high) == (result.value, result.u, low, high)
    told = "The draws of E have no standard deviation: the value is their median"
    assert any(told in one for one in findings.warnings)
    assert told in html.render(findings, {}).text.split("Contents")[0]


def test_law_the_plot_of_a_requirement_shows_the_reported_interval(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (verdict,) = evaluated(tmp_path, HEAVY).conformity
    bars: list[tuple[float, float]] = []
    monkeypatch.setattr(conformity.Sketch, "interval", lambda _self, low, high, *_rest: bars.append((low, high)))
    plot = conformity.draw(verdict)
    assert bars == [pytest.approx((verdict.low / 1e9, verdict.high / 1e9))]
    assert "coverage interval" in plot.caption
    assert "coverage interval" in plot.alt
    conformity.draw(replace(verdict, low=None, high=None))  # of results of an earlier version
    assert len(bars) == 1
