"""Decisions on conformity: published digits, the four verdicts, risks against simulation, refusals."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import integrate, stats

from metrology.errors import MetrologyError
from metrology.gum.conformity import Decision, decide
from metrology.gum.conformity_probability import probability_of_conformity
from metrology.gum.guard_bands import Rule, rule_risk
from metrology.gum.output import Analytic, Empirical, expanded
from metrology.gum.printed_probability import probability
from metrology.gum.risk import Limits, Prior, global_guard_band, global_risks

BEARINGS = Prior.gamma(4, 0.25)


def judged(value: float, u: float, *, dof: float = math.inf, **asked: object) -> Decision:
    """Decision on a result of a normal or t distribution."""
    return decide(Analytic(value, u, dof), **asked)  # type: ignore[arg-type]


def conforming(value: float, u: float, *, limits: Limits, dof: float = math.inf) -> tuple[float, float]:
    return probability_of_conformity(Analytic(value, u, dof), limits)


def test_reference_motor_oil_has_the_published_conforming() -> None:
    # JCGM 106:2012, 7.4
    p, q = conforming(13.6, 1.8, limits=Limits(12.5, 16.3))
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
    decision = judged(1.7, 0.25, limits=limit, rule=Rule("global risk", risk=0.001), prior=BEARINGS)
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
    decision = judged(value, 1.0, limits=Limits(-10.0, 10.0), rule=rule)
    assert decision.verdict == verdict
    assert (decision.guard_band, decision.acceptance_lower, decision.acceptance_upper) == (2.0, -8.0, 8.0)
    binary = judged(value, 1.0, limits=Limits(-10.0, 10.0), rule=Rule(coverage_factor=2.0, binary=True))
    assert binary.verdict == ("pass" if verdict == "pass" else "fail")


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0, 1.5])
def test_closed_form_the_guard_band_is_a_multiple_of_the_expanded_uncertainty(factor: float) -> None:
    decision = judged(0.0, 1.0, limits=Limits(upper=10.0), rule=Rule(factor=factor), dof=4)
    assert decision.guard_band == pytest.approx(factor * stats.t.ppf(0.975, 4), rel=1e-12)
    assert decision.acceptance_lower is None


def test_closed_form_the_specific_risk_is_that_of_the_decision_taken() -> None:
    limit, rule = Limits(upper=10.0), Rule("simple acceptance")
    accepted, rejected = (judged(value, 1.0, limits=limit, rule=rule) for value in (9.0, 11.0))
    assert (accepted.verdict, rejected.verdict) == ("pass", "fail")
    assert accepted.specific_risk == rejected.specific_risk == pytest.approx(stats.norm.sf(1), rel=1e-14)
    assert accepted.probability == pytest.approx(stats.norm.cdf(1), rel=1e-14)
    assert "not conforming all the same is 0.16" in accepted.sentence


@pytest.mark.parametrize("dof", [2.5, 10.0, math.inf])
@pytest.mark.parametrize("risk", [0.001, 0.05, 0.5])
def test_closed_form_a_result_on_the_acceptance_limit_carries_the_stated_specific_risk(dof: float, risk: float) -> None:
    rule = Rule("specific risk", risk=risk)
    for limits in (Limits(upper=10.0), Limits(lower=10.0), Limits(-1e4, 10.0)):
        decision = judged(10.0, 1.0, limits=limits, rule=rule, dof=dof)
        at = decision.acceptance_upper if limits.upper is not None else decision.acceptance_lower
        assert at is not None
        outside = conforming(at, 1.0, limits=limits, dof=dof)[1]
        assert outside == pytest.approx(risk, rel=1e-9)


def test_closed_form_narrow_limits_share_the_specific_risk() -> None:
    limits = Limits(-1.7, 1.7)
    decision = judged(0.0, 1.0, limits=limits, rule=Rule("specific risk", risk=0.1))
    assert decision.acceptance_upper is not None
    assert decision.guard_band > stats.norm.ppf(0.9)
    assert conforming(decision.acceptance_upper, 1.0, limits=limits)[1] == pytest.approx(0.1, rel=1e-9)


def test_limit_an_uncertainty_too_large_for_the_limits_passes_nothing_and_says_so() -> None:
    narrow = Limits(-1.0, 1.0)
    by_risk = judged(0.0, 1.0, limits=narrow, rule=Rule("specific risk", risk=0.05))
    assert (by_risk.verdict, by_risk.acceptance_upper) == ("conditional pass", None)
    by_factor = judged(0.0, 1.0, limits=narrow, rule=Rule())
    assert by_factor.verdict == "conditional pass"
    out = [judged(at, 1.0, limits=narrow, rule=Rule("specific risk", risk=0.05)).verdict for at in (1.5, 2.6, 2.7)]
    assert out == ["conditional fail", "conditional fail", "fail"]
    for decision in (by_risk, by_factor):
        assert "no result would pass without condition" in decision.sentence


@pytest.mark.parametrize("rule", [Rule(), Rule("specific risk", risk=0.025)])
def test_law_of_a_skewed_result_fails_where_hardly_any_of_it_conforms(rule: Rule) -> None:
    """A fail of a lower limit rests on the tail above the result: exponential, 13 % of it conformed where it failed."""
    draws = 7.0 + stats.expon.ppf((np.arange(100_000) + 0.5) / 100_000, scale=3.0)
    output = Empirical(10.0, 3.0, draws)
    for shift in np.linspace(-4.0, 12.0, 33):
        lower = decide(output, limits=Limits(lower=10.0 + shift), rule=rule)
        upper = decide(output, limits=Limits(upper=10.0 - shift), rule=rule)
        for decision in (lower, upper):
            assert decision.verdict not in ("pass", "fail") or decision.specific_risk <= 0.051
    assert decide(output, limits=Limits(lower=13.2), rule=rule).verdict == "conditional fail"
    assert decide(output, limits=Limits(lower=19.0), rule=rule).verdict == "fail"
    assert decide(output, limits=Limits(upper=6.9), rule=rule).verdict == "fail"


def test_limit_without_uncertainty_the_value_decides() -> None:
    prior = Prior.rectangular(0.0, 4.0)
    inside = judged(1.0, 0.0, limits=Limits(upper=1.0), rule=Rule(), prior=prior)
    outside = judged(1.1, 0.0, limits=Limits(upper=1.0), rule=Rule("specific risk"))
    assert (inside.verdict, inside.probability, inside.specific_risk) == ("pass", 1.0, 0.0)
    assert (outside.verdict, outside.probability, outside.specific_risk) == ("fail", 0.0, 0.0)
    assert (inside.global_consumer_risk, inside.global_producer_risk) == (0.0, 0.0)
    assert "takes the value as exact" in inside.sentence


def test_limit_tails_keep_their_relative_accuracy() -> None:
    inside, outside = conforming(0.0, 1.0, limits=Limits(-30.0, 30.0))
    assert outside == pytest.approx(2 * stats.norm.sf(30), rel=1e-12, abs=0)
    assert inside == 1.0
    for value in (-40.0, 40.0):
        inside, outside = conforming(value, 1.0, limits=Limits(-10.0, 10.0))
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
    decision = judged(10.0, 0.5, limits=limits, rule=rule, prior=Prior.normal(10.0, 1.0))
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
    decision = judged(
        0.0, 0.1, limits=Limits(upper=5.0), rule=Rule("global risk", risk=0.01), prior=Prior.normal(0.0, 1.0)
    )
    assert decision.guard_band == 0.0


@pytest.mark.parametrize("kind", ["simple acceptance", "guard band", "specific risk"])
def test_limit_scales_do_not_matter(kind: str) -> None:
    rule = Rule(kind, risk=0.01)  # type: ignore[arg-type]
    plain = judged(9.0, 1.0, limits=Limits(0.0, 10.0), rule=rule)
    for scale in (1e-12, 1e12):
        scaled = judged(9.0 * scale, scale, limits=Limits(0.0, 10.0 * scale), rule=rule)
        assert scaled.verdict == plain.verdict
        assert scaled.specific_risk == pytest.approx(plain.specific_risk, rel=1e-12)


def test_closed_form_the_rule_is_told_in_words() -> None:
    assert Rule("simple acceptance").text == "simple acceptance (w = 0)"
    assert Rule().text == "guard band, w = 1·U; pass, conditional pass, conditional fail or fail"
    by_k = Rule(factor=0.5, coverage_factor=2.0, binary=True)
    assert by_k.text == "guard band, w = 0.5·2·u; pass or fail"
    assert Rule("specific risk", binary=True).text == "guard band, w for a specific risk of 0.025; pass or fail"


def test_refusal_of_a_decision_that_makes_no_sense_names_every_fault() -> None:
    rule = Rule("global risk", factor=-1, risk=0.7, probability=1.0, coverage_factor=-2.0)
    with pytest.raises(MetrologyError) as caught:
        judged(math.nan, -1.0, limits=Limits(upper=1.0), rule=rule, dof=0)
    assert [fault.where for fault in caught.value.faults] == [
        *("value", "u", "dof", "rule.factor", "rule.risk", "rule.probability", "rule.coverage_factor", "prior"),
    ]


@pytest.mark.parametrize("limits", [(None, None), (math.nan, 1.0), (2.0, 1.0)])
def test_refusal_of_limits_that_hold_nothing(limits: tuple[float | None, float | None]) -> None:
    with pytest.raises(MetrologyError, match="limits"):
        judged(1.0, 1.0, limits=Limits(*limits), rule=Rule())


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
    edge = judged(20.0, 0.3, limits=limits, rule=rule, dof=dof).acceptance_lower
    assert edge is not None
    _, outside = conforming(edge, 0.3, limits=limits, dof=dof)
    assert rule_risk(rule, Analytic(20.0, 0.3, dof)) == pytest.approx(outside, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("dof", [4.0, math.inf])
@pytest.mark.parametrize("prior", [None, Prior.normal(20.0, 0.5)])
@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0])
def test_no_pass_is_wrong_more_often_than_the_risk_of_the_rule(dof: float, prior: Prior | None, factor: float) -> None:
    # Hardly wider than two guard bands: what lies beyond the other limit doubles the risk of one limit.
    output = Analytic(20.0, 0.1, dof)
    rule, half = Rule("guard band", factor=factor), 1.01 * (output.interval(0.95)[1] - 20.0)
    limits = Limits(20.0 - half, 20.0 + half)
    most = rule_risk(rule, output, limits, prior)
    assert most is not None
    for value in np.linspace(limits.lower, limits.upper, 41):
        decision = decide(Analytic(float(value), 0.1, dof), limits=limits, rule=rule, prior=prior)
        assert decision.verdict != "pass" or decision.specific_risk <= most * (1 + 1e-9)
    if prior is None and factor == 1.0:
        assert most == pytest.approx(0.05, rel=0.06)


def test_limit_the_risk_of_the_rule_is_that_of_results_which_the_prior_allows() -> None:
    limits, prior = Limits(10.0, 30.0), Prior.rectangular(19.9, 20.1)
    assert rule_risk(Rule(), Analytic(20.0, 0.001), limits, prior) == 0.0


def test_limit_a_global_risk_bounds_no_single_item() -> None:
    assert rule_risk(Rule("global risk"), Analytic(0.0, 1.0)) is None


# ---- one distribution: probabilities, risks and verdicts from what the interval comes from --------------------------
def drawn(values: np.ndarray) -> Empirical:
    return Empirical(float(values.mean()), float(values.std(ddof=1)), np.sort(values))


def evaluated(function, **inputs):
    """Distribution of an equation, as a campaign has it."""
    from metrology.gum.engine import evaluate
    from metrology.gum.evaluation import Measurand
    from metrology.gum.inputs import Component, Input, Knowledge

    known = {name: Input(name, mean, (Component("stated", law),)) for name, (mean, law) in inputs.items()}
    found = evaluate([Measurand("Y", function)], Knowledge(known), seed=3).estimates["Y"]
    assert found.output is not None
    return found


def test_closed_form_a_quotient_fails_its_limit_as_often_as_it_does() -> None:
    """E = a/t with u(t) = 10 %: P(E > 73) = P(t < a/73) = 2.97 %, where a normal distribution says 1.0 %."""
    from metrology.gum.distributions import Normal

    a = 73 * (1 - 1.885 * 0.1)
    found = evaluated(lambda q: a / q["t"], t=(1.0, Normal(0.1)))
    assert isinstance(found.output, Empirical)
    decision = decide(found.output, limits=Limits(upper=73.0), rule=Rule("simple acceptance"))
    assert decision.specific_risk == pytest.approx(stats.norm.cdf(-1.885), abs=6e-4)
    assert conforming(found.value, found.u, limits=Limits(upper=73.0))[1] == pytest.approx(0.0101, abs=2e-4)
    assert "those of the Monte Carlo draws" in decision.sentence


def test_closed_form_a_square_at_zero_conforms_as_often_as_it_does() -> None:
    """Y = X² at x = 0, u(X) = 1: P(Y ≤ 3) = P(|X| ≤ √3) = 0.917; the law has u = 0 there, and would say 1."""
    from metrology.gum.distributions import Normal

    found = evaluated(lambda q: q["X"] * q["X"], X=(0.0, Normal(1.0)))
    inside, _ = probability_of_conformity(found.output, Limits(upper=3.0))
    assert inside == pytest.approx(2 * stats.norm.cdf(math.sqrt(3)) - 1, abs=2e-3)


def test_limit_beyond_every_possible_value_conforms_with_probability_one() -> None:
    from metrology.gum.bounded import Rectangular

    found = evaluated(lambda q: q["X"], X=(0.0, Rectangular(1.0)))
    assert isinstance(found.output, Empirical)
    assert probability_of_conformity(found.output, Limits(upper=1.0001)) == (1.0, 0.0)
    assert decide(found.output, limits=Limits(upper=1.0001), rule=Rule()).verdict == "pass"


def test_law_a_skewed_result_passes_only_while_its_own_risk_is_allowed() -> None:
    """A lognormal whose upper tail beyond the limit is 4.8 %: a rule of 4 % must not pass it, one of 5 % must."""
    values = np.exp(0.5 * np.random.default_rng(5).standard_normal(400_000))
    limit = math.exp(0.5 * stats.norm.isf(0.048))
    for risk, verdict in ((0.04, "conditional pass"), (0.05, "pass")):
        decision = decide(drawn(values), limits=Limits(upper=limit), rule=Rule("specific risk", risk=risk))
        assert decision.verdict == verdict
        assert decision.specific_risk == pytest.approx(0.048, abs=0.0015)
        assert decision.acceptance_upper is not None
        # A result on the acceptance limit carries the risk of the rule.
        shifted = drawn(values + decision.acceptance_upper - values.mean())
        assert probability_of_conformity(shifted, Limits(upper=limit))[1] == pytest.approx(risk, rel=1e-2)


def test_closed_form_of_a_skewed_result_the_middle_between_the_limits_is_not_the_safest() -> None:
    """Exponential from 0 on about its mean 1: at the middle 1.5 a part exp(-2.5) lies beyond 3, at 1 one of exp(-3)."""
    values = -np.log(stats.qmc.Sobol(1, rng=1).random(2**18)[:, 0])
    limits, rule = Limits(lower=0.0, upper=3.0), Rule("specific risk", risk=0.06)
    decision = decide(drawn(values), limits=limits, rule=rule)
    assert decision.verdict == "pass"
    assert decision.specific_risk == pytest.approx(math.exp(-3), rel=1e-2)
    # Below 1 the part 1 - y lies below 0 where the density is 1 there: 1 - exp(-(1 - y)) + exp(-(4 - y)) = 0.06.
    below = math.log((1 - 0.06) / (math.exp(-1) - math.exp(-4)))
    assert decision.acceptance_lower == pytest.approx(below, abs=2e-3)
    assert decision.acceptance_upper == pytest.approx(4 + math.log(0.06), abs=5e-3)
    none = decide(drawn(values), limits=limits, rule=Rule("specific risk", risk=0.04))
    assert none.verdict == "conditional pass"
    assert "no result would pass without condition" in none.sentence


def test_law_the_guard_band_is_where_the_interval_ends() -> None:
    """A skewed interval reaches further up than down, and so do the guard bands: it passes while it lies inside."""
    values = np.random.default_rng(6).gamma(4.0, 0.25, 200_000)
    output = drawn(values)
    low, high = output.interval(0.95)
    for ends, verdict in (((low - 1e-9, high + 1e-9), "pass"), ((low - 1e-9, high - 1e-3), "conditional pass"),
                          ((low + 1e-3, high + 1e-9), "conditional pass")):  # fmt: skip
        assert decide(output, limits=Limits(*ends), rule=Rule()).verdict == verdict
    assert rule_risk(Rule(), output) == pytest.approx(max(np.mean(values < low), np.mean(values > high)), abs=1e-4)
    assert expanded(output, 0.95) == pytest.approx((high - low) / 2)


@pytest.mark.parametrize("dof", [5.0, math.inf])
def test_twice_the_draws_of_a_t_distribution_decide_as_the_t_distribution(dof: float) -> None:
    rng = np.random.default_rng(7)
    values = 9.0 + (rng.standard_t(dof, 1_000_000) if dof < math.inf else rng.standard_normal(1_000_000))
    limits = Limits(7.0, 12.0)
    for rule in (Rule(), Rule("specific risk", risk=0.02), Rule("simple acceptance")):
        exact, counted = (
            decide(output, limits=limits, rule=rule) for output in (Analytic(9.0, 1.0, dof), drawn(values))
        )
        assert counted.verdict == exact.verdict
        assert counted.probability == pytest.approx(exact.probability, abs=2e-3)
        if exact.acceptance_upper is not None:
            assert counted.acceptance_upper == pytest.approx(exact.acceptance_upper, abs=0.03)


@pytest.mark.parametrize("output", [Analytic(13.0, 1.0), "drawn"])
def test_closed_form_posterior_of_a_normal_prior_and_a_normal_result(output: object) -> None:
    """Prior N(10, 1), result 13 with u = 1: posterior N(11.5, 1/√2), p_c below 12 is Φ(0.5·√2) (JCGM 106, 6.2)."""
    if output == "drawn":
        output = drawn(13.0 + np.random.default_rng(8).standard_normal(1_000_000))
    inside, outside = probability_of_conformity(output, Limits(upper=12.0), Prior.normal(10.0, 1.0))
    assert inside == pytest.approx(
        stats.norm.cdf(0.5 * math.sqrt(2)), abs=3e-3 if isinstance(output, Empirical) else 1e-9
    )
    assert inside + outside == pytest.approx(1.0, abs=1e-12)
    decision = decide(output, limits=Limits(upper=12.0), rule=Rule("simple acceptance"), prior=Prior.normal(10.0, 1.0))
    assert (decision.verdict, decision.probability) == ("fail", inside)


def test_refusal_a_result_that_its_prior_excludes() -> None:
    with pytest.raises(MetrologyError, match="where the prior has no probability"):
        probability_of_conformity(Analytic(100.0, 0.1), Limits(upper=99.0), Prior.rectangular(0.0, 1.0))


def test_closed_form_a_probability_is_printed_as_far_as_it_is_known() -> None:
    assert [probability(p) for p in (0.0228, 2.7e-15, 1.0, 0.99995)] == ["0.023", "< 10⁻⁶", "1", "0.99995"]
    assert probability(0.0, 1e-4) == "< 10⁻⁴"
    assert probability(1 - 1e-8) == "> 1 − 10⁻⁶"


# ---- global risks with the errors of the result ---------------------------------------------------------------------
def independent_risks(prior, errors, limits: Limits, accepted: Limits) -> tuple[float, float]:
    """R_C and R_P by a fine sum over the prior; `errors` is the law of Y − y, so that the result is η − error."""
    eta = np.linspace(prior.ppf(1e-13), prior.ppf(1 - 1e-13), 2_000_001)
    mass = prior.pdf(eta) * (eta[1] - eta[0])
    rejected = np.zeros_like(eta)
    inside = np.ones(eta.size, dtype=bool)
    if accepted.lower is not None:
        rejected += errors.sf(eta - accepted.lower)
        inside &= eta >= limits.lower
    if accepted.upper is not None:
        rejected += errors.cdf(eta - accepted.upper)
        inside &= eta <= limits.upper
    return float((mass * (1 - rejected))[~inside].sum()), float((mass * rejected)[inside].sum())


@pytest.mark.long
def test_twice_global_risks_of_a_t_distributed_result() -> None:
    """U = 0.4 with ν = 4: a normal error of the same u says 1.00 % and 3.78 % where 1.10 % and 5.20 % are right."""
    u = 0.4 / stats.t.ppf(0.975, 4)
    prior, limits = Prior.normal(10.0, 0.3), Limits(lower=9.5)
    output = Analytic(10.0, u, 4.0)
    for w in (0.0, 0.02223926, 0.3):
        expected = independent_risks(stats.norm(10, 0.3), stats.t(4, 0, u), limits, limits.shrunk(w))
        found = global_risks(prior, output, limits=limits, acceptance=limits.shrunk(w))
        assert found == pytest.approx(expected, rel=2e-5)
    decision = decide(output, limits=limits, rule=Rule("global risk", risk=0.01), prior=prior)
    assert decision.guard_band == pytest.approx(0.03587, abs=1e-5)
    assert (decision.global_consumer_risk, decision.global_producer_risk) == pytest.approx((0.01, 0.057187), rel=1e-4)


def test_limit_a_guard_band_beyond_any_multiple_of_u_is_found() -> None:
    """Cauchy errors: a consumer's risk of 10⁻⁴ asks for a w of thousands of u."""
    prior, limits = Prior.normal(0.0, 1.0), Limits(upper=0.0)
    output = Analytic(0.0, 0.01, 1.0)
    w = global_guard_band(prior, output, limits=limits, risk=1e-4)
    assert w > 38 * output.u
    expected = independent_risks(stats.norm(0, 1), stats.cauchy(0, 0.01), limits, limits.shrunk(w))
    assert expected[0] == pytest.approx(1e-4, rel=1e-3)


SKEWED = {
    "exponential": (stats.expon(-1.0, 1.0), lambda rng: rng.exponential(size=400_000)),
    "lognormal": (stats.lognorm(0.8), lambda rng: np.exp(0.8 * rng.standard_normal(400_000))),
    "rectangular": (stats.uniform(-2.0, 4.0), lambda rng: rng.uniform(-2.0, 2.0, 400_000)),
}


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", SKEWED)
@pytest.mark.parametrize("limits", [Limits(lower=0.6), Limits(upper=2.5), Limits(0.3, 2.2)])
def test_twice_global_risks_of_draws_are_those_of_their_law(name: str, seed: int, limits: Limits) -> None:
    law, draw = SKEWED[name]
    output = drawn(0.5 * draw(np.random.default_rng(seed)) + 3.0)
    errors = type("Errors", (), {
        "cdf": staticmethod(lambda x: law.cdf(x / 0.5 + law.mean())),
        "sf": staticmethod(lambda x: law.sf(x / 0.5 + law.mean())),
    })  # fmt: skip
    accepted = limits.shrunk(0.05)
    expected = independent_risks(stats.lognorm(0.3), errors, limits, accepted)
    found = global_risks(Prior.lognormal(1.0, 0.3), output, limits=limits, acceptance=accepted)
    assert found == pytest.approx(expected, rel=0.02, abs=2e-4)
    w = global_guard_band(Prior.lognormal(1.0, 0.3), output, limits=Limits(lower=0.6), risk=0.005)
    assert independent_risks(stats.lognorm(0.3), errors, Limits(lower=0.6), Limits(lower=0.6 + w))[0] == pytest.approx(
        0.005, rel=0.03
    )


def test_closed_form_draws_of_two_values_are_errors_of_two_values() -> None:
    """Errors of ±1 in equal shares, prior N(0, 1), limit 0: an item at η > 0 is accepted where η < 1 and e = −1."""
    values = np.repeat([-1.0, 1.0], 50_000)
    consumer, producer = global_risks(
        Prior.normal(0.0, 1.0), drawn(values), limits=Limits(upper=0.0), acceptance=Limits(upper=0.0)
    )
    expected = 0.5 * (stats.norm.cdf(1) - 0.5)
    assert (consumer, producer) == pytest.approx((expected, expected), rel=1e-3)


# ---- what draws can show --------------------------------------------------------------------------------------------
def test_closed_form_a_count_of_zero_is_a_bound_of_three_in_all_draws() -> None:
    """(1 − 3/M)^M = 5 %: a larger probability shows in one of M draws at least, with 95 %."""
    output = drawn(np.linspace(0.0, 1.0, 1000))
    assert (1 - output.resolution) ** 1000 == pytest.approx(0.05, abs=1e-3)
    assert probability(0.0, output.resolution) == "< 3×10⁻³"
    assert [probability(0.0, 3 / m) for m in (100_000, 1_000_000, 200_000, 30)] == [
        "< 3×10⁻⁵", "< 3×10⁻⁶", "< 2×10⁻⁵", "< 10⁻¹",
    ]  # fmt: skip


@pytest.mark.parametrize("kind", ["specific risk", "global risk"])
@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_limit_draws_pass_nothing_by_a_risk_that_they_cannot_show(kind: str, seed: int) -> None:
    values = np.random.default_rng(seed).uniform(0.5, 1.5, 10_000)
    prior = Prior.normal(1.0, 0.2)
    for limits in (Limits(lower=0.4), Limits(0.4, 1.6)):
        for risk, verdict in ((1e-4, "conditional pass"), (2.9e-4, "conditional pass"), (0.05, "pass")):
            decision = decide(
                drawn(values), limits=limits, rule=Rule(kind, risk=risk), prior=prior if kind == "global risk" else None
            )
            assert decision.verdict == verdict
            assert ("The draws cannot show the agreed risk" in decision.sentence) is (verdict != "pass")
    binary = decide(drawn(values), limits=Limits(lower=0.4), rule=Rule("specific risk", risk=1e-4, binary=True))
    assert (binary.verdict, binary.acceptance_lower) == ("fail", None)
    exact = judged(1.0, 0.1, limits=Limits(lower=0.4), rule=Rule("specific risk", risk=1e-8))
    assert exact.verdict == "pass"  # the tail of a law is known as far as the law is


def test_closed_form_a_centred_interval_gives_one_guard_band_on_both_sides() -> None:
    values = np.random.default_rng(9).uniform(-4.0, 4.0, 100_000)
    decision = decide(drawn(values), limits=Limits(-10.0, 10.0), rule=Rule())
    assert decision.guard_band == expanded(drawn(values), 0.95) == pytest.approx(3.8, abs=0.02)
    assert decision.acceptance_lower == -decision.acceptance_upper
