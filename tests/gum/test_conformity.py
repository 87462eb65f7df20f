"""Decisions on conformity: published digits, the four verdicts, risks against simulation, refusals."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import integrate, stats

from metrology.errors import MetrologyError
from metrology.gum.conformity import Limits, Prior, Rule, decide, global_risks, probability_of_conformity, rule_risk
from metrology.gum.risk import global_guard_band

BEARINGS = Prior.gamma(4, 0.25)


def test_reference_motor_oil_has_the_published_probability_of_conformity() -> None:
    # JCGM 106:2012, 7.4
    p, q = probability_of_conformity(13.6, 1.8, limits=Limits(12.5, 16.3))
    assert round(p, 2) == 0.66
    assert p + q == pytest.approx(1, abs=1e-15)


def test_reference_ball_bearings_have_the_published_risks() -> None:
    # JCGM 106:2012, 9.5.4
    limit = Limits(upper=2.0)
    consumer, producer = global_risks(BEARINGS, 0.25, limits=limit, acceptance=limit)
    assert round(consumer, 3) == 0.008
    assert producer == pytest.approx(0.0174445692297836, rel=1e-9)
    w = global_guard_band(BEARINGS, 0.25, limits=limit, risk=0.001)
    assert round(2.0 - w, 2) == 1.67
    decision = decide(1.7, 0.25, limits=limit, rule=Rule("global risk", risk=0.001), prior=BEARINGS)
    assert decision.acceptance_upper == pytest.approx(1.6718287715558942, abs=1e-8)
    assert decision.global_consumer_risk == pytest.approx(0.001, rel=1e-7)
    assert decision.global_producer_risk == pytest.approx(0.07549387610569092, rel=1e-7)
    assert decision.verdict == "conditional pass"


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        *((7.9, "pass"), (8.0, "pass"), (8.1, "conditional pass"), (10.0, "conditional pass")),
        *((10.1, "conditional fail"), (12.0, "conditional fail"), (12.1, "fail")),
        *((-7.9, "pass"), (-9.0, "conditional pass"), (-11.0, "conditional fail"), (-13.0, "fail")),
    ],
)
def test_closed_form_four_verdicts_of_a_guard_band(value: float, verdict: str) -> None:
    # ILAC-G8:09/2019, 4.2.3 with w = U = 2
    rule = Rule("guard band", coverage_factor=2.0)
    decision = decide(value, 1.0, limits=Limits(-10.0, 10.0), rule=rule)
    assert decision.verdict == verdict
    assert (decision.guard_band, decision.acceptance_lower, decision.acceptance_upper) == (2.0, -8.0, 8.0)
    binary = decide(value, 1.0, limits=Limits(-10.0, 10.0), rule=Rule(coverage_factor=2.0, binary=True))
    assert binary.verdict == ("pass" if verdict == "pass" else "fail")


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0, 1.5])
def test_closed_form_the_guard_band_is_a_multiple_of_the_expanded_uncertainty(factor: float) -> None:
    decision = decide(0.0, 1.0, limits=Limits(upper=10.0), rule=Rule(factor=factor), dof=4)
    assert decision.guard_band == pytest.approx(factor * stats.t.ppf(0.975, 4), rel=1e-12)
    assert decision.acceptance_lower is None


def test_closed_form_the_specific_risk_is_that_of_the_decision_taken() -> None:
    limit, rule = Limits(upper=10.0), Rule("simple acceptance")
    accepted, rejected = (decide(value, 1.0, limits=limit, rule=rule) for value in (9.0, 11.0))
    assert (accepted.verdict, rejected.verdict) == ("pass", "fail")
    assert accepted.specific_risk == rejected.specific_risk == pytest.approx(stats.norm.sf(1), rel=1e-14)
    assert accepted.probability == pytest.approx(stats.norm.cdf(1), rel=1e-14)
    assert "not conforming all the same is 0.16" in accepted.sentence


@pytest.mark.parametrize("dof", [2.5, 10.0, math.inf])
@pytest.mark.parametrize("risk", [0.001, 0.05, 0.5])
def test_closed_form_a_result_on_the_acceptance_limit_carries_the_stated_specific_risk(dof: float, risk: float) -> None:
    rule = Rule("specific risk", risk=risk)
    for limits in (Limits(upper=10.0), Limits(lower=10.0), Limits(-1e4, 10.0)):
        decision = decide(10.0, 1.0, limits=limits, rule=rule, dof=dof)
        at = decision.acceptance_upper if limits.upper is not None else decision.acceptance_lower
        assert at is not None
        outside = probability_of_conformity(at, 1.0, limits=limits, dof=dof)[1]
        assert outside == pytest.approx(risk, rel=1e-9)


def test_closed_form_narrow_limits_share_the_specific_risk() -> None:
    limits = Limits(-1.7, 1.7)
    decision = decide(0.0, 1.0, limits=limits, rule=Rule("specific risk", risk=0.1))
    assert decision.acceptance_upper is not None
    assert decision.guard_band > stats.norm.ppf(0.9)
    assert probability_of_conformity(decision.acceptance_upper, 1.0, limits=limits)[1] == pytest.approx(0.1, rel=1e-9)


def test_limit_an_uncertainty_too_large_for_the_limits_passes_nothing_and_says_so() -> None:
    narrow = Limits(-1.0, 1.0)
    by_risk = decide(0.0, 1.0, limits=narrow, rule=Rule("specific risk", risk=0.05))
    assert (by_risk.verdict, by_risk.acceptance_upper) == ("conditional pass", None)
    by_factor = decide(0.0, 1.0, limits=narrow, rule=Rule())
    assert by_factor.verdict == "conditional pass"
    out = decide(1.5, 1.0, limits=narrow, rule=Rule("specific risk", risk=0.05))
    assert out.verdict == "fail"
    for decision in (by_risk, by_factor):
        assert "no result would pass without condition" in decision.sentence


def test_limit_without_uncertainty_the_value_decides() -> None:
    prior = Prior.rectangular(0.0, 4.0)
    inside = decide(1.0, 0.0, limits=Limits(upper=1.0), rule=Rule(), prior=prior)
    outside = decide(1.1, 0.0, limits=Limits(upper=1.0), rule=Rule("specific risk"))
    assert (inside.verdict, inside.probability, inside.specific_risk) == ("pass", 1.0, 0.0)
    assert (outside.verdict, outside.probability, outside.specific_risk) == ("fail", 0.0, 0.0)
    assert (inside.global_consumer_risk, inside.global_producer_risk) == (0.0, 0.0)
    assert "takes the value as exact" in inside.sentence


def test_limit_tails_keep_their_relative_accuracy() -> None:
    inside, outside = probability_of_conformity(0.0, 1.0, limits=Limits(-30.0, 30.0))
    assert outside == pytest.approx(2 * stats.norm.sf(30), rel=1e-12, abs=0)
    assert inside == 1.0
    for value in (-40.0, 40.0):
        inside, outside = probability_of_conformity(value, 1.0, limits=Limits(-10.0, 10.0))
        assert inside == pytest.approx(stats.norm.sf(30), rel=1e-12, abs=0)
        assert outside == 1.0


@pytest.mark.parametrize(
    ("prior", "law"),
    [
        (Prior.normal(1.0, 0.4), stats.norm(1.0, 0.4)),
        (Prior.gamma(4, 0.25), stats.gamma(4, scale=0.25)),
        (Prior.lognormal(1.0, 0.5), stats.lognorm(0.5, scale=1.0)),
        (Prior.rectangular(0.2, 2.4), stats.uniform(0.2, 2.2)),
        (Prior.normal(1.0, 1e-3), stats.norm(1.0, 1e-3)),
        (Prior.normal(1.0, 300.0), stats.norm(1.0, 300.0)),
    ],
)
@pytest.mark.parametrize("limits", [Limits(0.5, 1.6), Limits(upper=1.6), Limits(lower=0.5)])
def test_twice_global_risks_by_adaptive_quadrature(prior: Prior, law: stats.rv_continuous, limits: Limits) -> None:
    u, accepted = 0.1, limits.shrunk(0.05)
    low = -math.inf if accepted.lower is None else accepted.lower
    high = math.inf if accepted.upper is None else accepted.upper

    def rate(eta: float) -> float:
        return float(stats.norm.cdf((high - eta) / u) - stats.norm.cdf((low - eta) / u))

    def integral(function: object, start: float, end: float) -> float:
        marks = np.unique(np.clip([start, 0.4, 0.5, 0.6, 0.99, 1.0, 1.01, 1.5, 1.6, 1.7, end], start, end))
        return sum(integrate.quad(function, a, b, epsabs=1e-14, limit=200)[0] for a, b in pairwise(marks))

    support = (max(law.ppf(0.0), law.ppf(1e-15), -20.0), min(law.ppf(1.0), law.isf(1e-15), 20.0))
    inside = (max(limits.lower or -20.0, support[0]), min(limits.upper or 20.0, support[1]))
    consumer = 0.0
    if limits.lower is not None:
        consumer += integral(lambda eta: law.pdf(eta) * rate(eta), support[0], max(limits.lower, support[0]))
    if limits.upper is not None:
        consumer += integral(lambda eta: law.pdf(eta) * rate(eta), min(limits.upper, support[1]), support[1])
    producer = integral(lambda eta: law.pdf(eta) * (1 - rate(eta)), *inside)
    ours = global_risks(prior, u, limits=limits, acceptance=accepted)
    assert ours[0] == pytest.approx(consumer, rel=1e-8, abs=1e-12)
    assert ours[1] == pytest.approx(producer, rel=1e-8, abs=1e-12)


def test_twice_global_risks_by_simulation() -> None:
    generator = np.random.Generator(np.random.PCG64(1))
    true = generator.normal(10.0, 1.0, 400_000)
    read = true + generator.normal(0.0, 0.5, true.size)
    limits, rule = Limits(8.0, 12.0), Rule(coverage_factor=2.0, factor=0.5)
    decision = decide(10.0, 0.5, limits=limits, rule=rule, prior=Prior.normal(10.0, 1.0))
    good, passed = (true >= 8) & (true <= 12), (read >= 8.5) & (read <= 11.5)
    for risk, events in [
        (decision.global_consumer_risk, passed & ~good),
        (decision.global_producer_risk, ~passed & good),
    ]:
        assert risk is not None
        assert abs(float(np.mean(events)) - risk) < 4 * math.sqrt(risk / true.size)


def test_law_a_wider_guard_band_shifts_risk_from_consumer_to_producer() -> None:
    limits = Limits(upper=2.0)
    risks = [global_risks(BEARINGS, 0.25, limits=limits, acceptance=limits.shrunk(w)) for w in (0.0, 0.2, 0.4, 0.8)]
    assert [risk[0] for risk in risks] == sorted((risk[0] for risk in risks), reverse=True)
    assert [risk[1] for risk in risks] == sorted(risk[1] for risk in risks)


def test_limit_a_harmless_production_needs_no_guard_band() -> None:
    decision = decide(
        0.0, 0.1, limits=Limits(upper=5.0), rule=Rule("global risk", risk=0.01), prior=Prior.normal(0.0, 1.0)
    )
    assert decision.guard_band == 0.0


@pytest.mark.parametrize("kind", ["simple acceptance", "guard band", "specific risk"])
def test_limit_scales_do_not_matter(kind: str) -> None:
    rule = Rule(kind, risk=0.01)  # type: ignore[arg-type]
    plain = decide(9.0, 1.0, limits=Limits(0.0, 10.0), rule=rule)
    for scale in (1e-12, 1e12):
        scaled = decide(9.0 * scale, scale, limits=Limits(0.0, 10.0 * scale), rule=rule)
        assert scaled.verdict == plain.verdict
        assert scaled.specific_risk == pytest.approx(plain.specific_risk, rel=1e-12)


def test_closed_form_the_rule_is_told_in_words() -> None:
    assert Rule("simple acceptance").text == "simple acceptance (w = 0)"
    assert Rule().text == "guard band, w = 1·U; pass, conditional pass, conditional fail or fail"
    assert Rule("specific risk", binary=True).text == "guard band, w for a specific risk of 0.025; pass or fail"


def test_refusal_of_a_decision_that_makes_no_sense_names_every_fault() -> None:
    rule = Rule("global risk", factor=-1, risk=0.7, probability=1.0, coverage_factor=-2.0)
    with pytest.raises(MetrologyError) as caught:
        decide(math.nan, -1.0, limits=Limits(upper=1.0), rule=rule, dof=0)
    assert [fault.where for fault in caught.value.faults] == [
        *("value", "u", "dof", "rule.factor", "rule.risk", "rule.probability", "rule.coverage_factor", "prior"),
    ]


@pytest.mark.parametrize("limits", [(None, None), (math.nan, 1.0), (2.0, 1.0)])
def test_refusal_of_limits_that_hold_nothing(limits: tuple[float | None, float | None]) -> None:
    with pytest.raises(MetrologyError, match="limits"):
        decide(1.0, 1.0, limits=Limits(*limits), rule=Rule())


def test_law_lognormal_prior_has_its_median() -> None:
    assert Prior.lognormal(3.0, 0.5).quantile(0.5) == pytest.approx(3.0, rel=1e-12)


def test_refusal_of_priors_without_width() -> None:
    with pytest.raises(MetrologyError, match=r"prior.standard_deviation: got 0"):
        Prior.normal(1.0, 0.0)
    with pytest.raises(MetrologyError) as caught:
        Prior.gamma(-1.0, math.inf)
    assert len(caught.value.faults) == 2
    with pytest.raises(MetrologyError, match=r"prior\.median: got -1"):
        Prior.lognormal(-1.0, 0.5)
    with pytest.raises(MetrologyError, match=r"prior\.width"):
        Prior.rectangular(2.0, 1.0)


@pytest.mark.parametrize("dof", [4.0, math.inf])
@pytest.mark.parametrize(
    "rule", [Rule(), Rule(factor=0.8, coverage_factor=2.0), Rule("specific risk", risk=0.01), Rule("simple acceptance")]
)
def test_twice_the_risk_of_a_rule_is_that_of_a_result_on_its_acceptance_limit(rule: Rule, dof: float) -> None:
    limits = Limits(lower=10.0)
    edge = decide(20.0, 0.3, limits=limits, rule=rule, dof=dof).acceptance_lower
    assert edge is not None
    _, outside = probability_of_conformity(edge, 0.3, limits=limits, dof=dof)
    assert rule_risk(rule, dof) == pytest.approx(outside, rel=1e-9)


def test_limit_a_global_risk_bounds_no_single_item() -> None:
    assert rule_risk(Rule("global risk")) is None
