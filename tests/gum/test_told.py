"""What fits, decisions, comparisons and budgets say of themselves, refuse, and hand on: numbers and whole sentences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple
from functools import partial
from math import inf, nan, sqrt

import numpy as np
import pytest
from gum_models import knowledge, model
from scipy import stats

from metrology.errors import MetrologyError
from metrology.expression import Expression
from metrology.gum import Component, Ensemble, Input, Normal, Rectangular, regression
from metrology.gum.budget import budget
from metrology.gum.comparison import en
from metrology.gum.conformity import Decision, decide
from metrology.gum.conformity_probability import probability_of_conformity
from metrology.gum.guard_bands import Rule
from metrology.gum.law import propagate
from metrology.gum.output import Analytic
from metrology.gum.risk import Limits, Prior, global_guard_band, global_risks

WLS = ([1, 2, 3, 4, 5, 6], [3.3, 5.6, 7.1, 9.3, 10.7, 12.1])
X = np.linspace(0.0, 3.0, 12)
Y = 2 * np.exp(0.5 * X) + 0.01 * np.cos(9 * X)
GROWTH = Expression.parse("A*exp(c*x)")


def refused(action: Callable[[], object]) -> list[str]:
    with pytest.raises(MetrologyError) as caught:
        action()
    return [str(fault) for fault in caught.value.faults]


# ---------------------------------------------------------------- fits


def grown(u_y: float | None = None) -> regression.Regression:
    return regression.curve(GROWTH, X, Y, start={"A": 1.0, "c": 1.0}, u_y=u_y)


def test_law_a_curve_tells_its_model_scatter_and_test() -> None:
    fit = grown()
    s = sqrt(float(((Y - fit.values[0] * np.exp(fit.values[1] * X)) ** 2).sum()) / 10)
    assert (fit.model, fit.names, fit.dof, fit.residual_dof) == ("y = A*exp(c*x)", ("A", "c"), 10.0, 10)
    assert fit.s == pytest.approx(s, rel=1e-9)
    assert (fit.chi_squared, fit.p_value) == (None, None)
    assert fit.sentence == f"The points scatter about the curve with s = {s:.3g}, 10 degrees of freedom."
    stated = grown(0.01)
    assert stated.chi_squared is not None
    assert (stated.s, stated.dof, stated.residual_dof) == (None, inf, 10)
    assert stated.p_value == pytest.approx(stats.chi2.sf(stated.chi_squared, 10), rel=1e-9)
    assert stated.sentence == (
        f"χ² = {stated.chi_squared:.4g} for 10 degrees of freedom (p = {stated.p_value:.2g}): the stated uncertainties"
        " account for the scatter."
    )
    tight = grown(0.001)
    assert tight.sentence == (
        f"χ² = {tight.chi_squared:.4g} for 10 degrees of freedom (p = {tight.p_value:.2g}): the points scatter more"
        " than their stated uncertainties allow; find the cause or enlarge them."
    )


def test_twice_covariance_of_a_curve_by_its_jacobian() -> None:
    for u_y in (None, 0.01):
        fit = grown(u_y)
        a, c = fit.values
        jacobian = np.column_stack([np.exp(c * X), a * X * np.exp(c * X)])
        variance = fit.s**2 if fit.s is not None else 1e-4
        np.testing.assert_allclose(fit.covariance, variance * np.linalg.inv(jacobian.T @ jacobian), rtol=1e-8)
        np.testing.assert_allclose(fit.residuals, Y - a * np.exp(c * X), atol=1e-13)
        np.testing.assert_array_equal((fit.x, fit.y), (X, Y))
        assert fit.converged


def test_law_a_function_is_told_by_its_name_and_a_failure_by_what_to_do() -> None:
    def saturation(x: np.ndarray, p: dict[str, float]) -> np.ndarray:
        return p["a"] * x

    assert regression.curve(saturation, X, X, start={"a": 1.0}, u_y=0.1).model == "y = saturation"
    assert regression.curve(partial(saturation), X, X, start={"a": 1.0}, u_y=0.1).model == "y = f(x)"
    fit = regression.curve(Expression.parse("a*b*x"), X, X, start={"a": 1.0, "b": 1.0}, u_y=0.1)
    assert fit.p_value is None
    assert fit.sentence == (
        "The points do not distinguish the parameters (the sensitivities are dependent). Begin from other values, plot"
        " the curve at the start, or leave a parameter out."
    )


def test_refusal_of_models_and_starts_is_told() -> None:
    assert refused(lambda: regression.curve(Expression.parse("a*x"), X, X, start={"a": 1.0, "b": 2.0})) == [
        "model: got 'a*x' with the parameters a, b; expected an expression of all parameters and of one more name, the"
        " x"
    ]
    assert refused(lambda: regression.curve(GROWTH, X, Y, start={"A": 1.0, "c": 1e4})) == [
        "start: got A = 1, c = 10000; expected values at which the function is finite at every point"
    ]
    assert refused(lambda: regression.curve(GROWTH, X, Y, start={"A": nan, "c": 1.0})) == [
        "start: got A = nan, c = 1; expected values at which the function is finite at every point"
    ]


@pytest.mark.parametrize("offset", [0.0, 1e7])
def test_law_inverse_of_a_curve_does_not_hang_on_where_x_is_counted_from(offset: float) -> None:
    shifted = Expression.parse(f"A*exp(c*(x-{offset}))")
    found = regression.inverse(regression.curve(shifted, X + offset, Y, start={"A": 1.0, "c": 1.0}, u_y=0.01), 5.0)
    plain = regression.inverse(grown(0.01), 5.0)
    assert found.value is not None
    assert plain.value is not None
    assert found.value - offset == pytest.approx(plain.value, abs=1e-7)
    assert found.u == pytest.approx(plain.u, rel=1e-4)


def test_limit_inverse_says_where_it_ends() -> None:
    flat = regression.line([1, 2, 3, 4], [1.0, 1.0, 1.0, 1.0])
    assert regression.inverse(flat, 1.0).sentence == (
        "The slope 0 is not distinguished from zero (u = 0): y does not determine x."
    )
    steep = regression.line([1, 2, 3, 4], [1.0, 2.0, 3.0, 4.0])
    assert regression.inverse(steep, 2.5).value == pytest.approx(2.5, rel=1e-12)
    noisy = regression.line([1, 2, 3, 4], [1.0, 2.0, 3.0, 4.0], u_y=1.0)
    assert regression.inverse(noisy, 2.5).value is not None  # u = 0.447 of the slope 1
    noisier = regression.line([1, 2, 3, 4], [1.0, 2.0, 3.0, 4.0], u_y=1.2)
    assert regression.inverse(noisier, 2.5).sentence == (
        "The slope 1 is not distinguished from zero (u = 0.536656): y does not determine x."
    )
    x = np.linspace(-2, 2.5, 10)
    bowl = regression.polynomial(x, x**2, degree=2, u_y=0.01)
    ends = [regression.inverse(bowl, y, between=(-1.5, 2.0)) for y in (-1.0, 1.0)]
    assert [astuple(end) for end in ends] == [
        (None, None, "The curve does not take the value -1 between x = -1.5 and 2."),
        (None, None, "The curve takes the value 1 more than once between x = -1.5 and 2: narrow the range."),
    ]
    assert regression.inverse(bowl, 1.0, between=(1.0, 2.0)).value == pytest.approx(1.0, abs=1e-12)
    foot = regression.curve(lambda x, p: p["a"] * x**2, x, x**2, start={"a": 1.0}, u_y=0.1)
    assert astuple(regression.inverse(foot, 0.0, between=(-1.0, 1.0))) == (
        None, None, "The curve is flat at x = 0: y does not determine x there."
    )  # fmt: skip


def test_law_knowledge_of_a_fit_says_what_it_is() -> None:
    stated = regression.knowledge(regression.line(*WLS, u_y=0.5), "cal", ["N", "N/m"])
    a, b = stated.inputs.values()
    assert (a.description, b.description) == ("parameter a of the fit cal", "parameter b of the fit cal")
    (component,) = a.components
    assert (component.name, component.source, component.kind) == ("fit", "fit cal, y = a + b·x", "B")
    scattered = regression.knowledge(regression.line(*WLS), "cal")
    (ensemble,) = scattered.ensembles
    assert (ensemble.name, ensemble.source) == ("fit cal", "fit cal, y = a + b·x")
    assert [item.unit for item in scattered.inputs.values()] == ["1", "1"]
    fit = regression.curve(Expression.parse("a*b*x"), X, X, start={"a": 1.0, "b": 1.0}, u_y=0.1)
    assert refused(lambda: regression.knowledge(fit, "f")) == [
        f"f: got a fit that did not converge; expected a fit that did. Fix: {fit.sentence}"
    ]


def test_closed_form_scaled_and_simple_covariances() -> None:
    three = regression.line([1.0, 2.0, 3.0], [1.0, 2.1, 2.9], u_y=0.5)
    assert three.chi_squared is not None
    scaled = regression.scaled(three)
    assert (scaled.s, scaled.dof) == (pytest.approx(sqrt(three.chi_squared)), 1.0)
    np.testing.assert_allclose(scaled.covariance, three.covariance * three.chi_squared, rtol=1e-12)
    assert refused(lambda: regression.scaled(regression.line(*WLS))) == [
        "fit: got no stated uncertainties; expected stated uncertainties and more points than parameters"
    ]
    assert refused(lambda: regression.scaled(regression.line([1, 2], [1, 2], u_y=1))) == [
        "fit: got as many parameters as points; expected stated uncertainties and more points than parameters"
    ]
    both = regression.by_information(regression.line(*WLS, u_x=0.1, u_y=0.5))
    at = np.array([[1.0, 7.0]])
    expected = sqrt((at @ both.covariance @ at.T).item())
    assert regression.predict(both, 7.0).u[0] == pytest.approx(expected, rel=1e-9)
    assert refused(lambda: regression.by_information(regression.line(*WLS))) == [
        "fit: got a fit of y = a + b·x without errors in x; expected one with errors in x and y"
    ]


def test_law_a_line_with_errors_in_both_tells_its_test_or_that_it_failed() -> None:
    fit = regression.line(*WLS, u_x=0.1, u_y=0.3)
    assert fit.chi_squared is not None
    assert (fit.model, fit.names, fit.dof, fit.residual_dof, fit.s) == ("y = a + b·x", ("a", "b"), inf, 4, None)
    assert fit.p_value == pytest.approx(stats.chi2.sf(fit.chi_squared, 4), rel=1e-9)
    assert fit.sentence == (
        f"χ² = {fit.chi_squared:.4g} for 4 degrees of freedom (p = {fit.p_value:.2g}): the stated uncertainties account"
        " for the scatter."
    )
    np.testing.assert_allclose(fit.residuals, WLS[1] - fit.values[0] - fit.values[1] * np.array(WLS[0]), atol=1e-12)
    np.testing.assert_array_equal((fit.x, fit.y), WLS)
    square = regression.line([0, 0, 1, 1], [0, 1, 0, 1], u_x=0.1, u_y=0.1)
    assert (square.p_value, square.sentence) == (
        None, "The line did not converge: these points do not determine its slope. Look at the plot; swap x and"
        " y if steep.",
    )  # fmt: skip
    assert refused(lambda: regression.line(*WLS, u_x=0.1)) == [
        "u_x: got uncertainties of x alone; expected 'u_y' as well. Fix: state 'u_y', or exchange 'x' and 'y'"
    ]
    assert refused(lambda: regression.line(*WLS, u_x=0.1, u_y=0.1, correlation=1.0))[0] == (
        "correlation[0]: got 1; expected a coefficient between −1 and 1"
    )


def test_law_polynomials_tell_their_equation() -> None:
    fit = regression.polynomial(X, X**3, degree=3, u_y=0.1)
    assert (fit.model, fit.names) == ("y = b0 + b1·x + b2·x^2 + b3·x^3", ("b0", "b1", "b2", "b3"))
    assert (fit.residual_dof, fit.s) == (8, None)


def test_refusal_of_points_is_told_whole() -> None:
    assert refused(lambda: regression.line([1, 2], [1, 2])) == [
        "fit: got 2 points; expected at least 3 for 2 parameters. Fix: state the uncertainty of the points, or take"
        " more of them"
    ]
    assert refused(lambda: regression.line([1], [1], u_y=1)) == [
        "fit: got 1 points; expected at least 2 for 2 parameters"
    ]
    assert refused(lambda: regression.line([2, 2, 2], [1, 2, nan], u_y=[1, 1, 0])) == [
        "y[2]: got nan; expected a finite number",
        "u_y[2]: got 0; expected a standard uncertainty greater than zero",
    ]
    assert refused(lambda: regression.line([2, 2, 2], [1, 2, 3])) == [
        "x: got 1 different value(s); expected at least 2 different values"
    ]


# ---------------------------------------------------------------- decisions


def judged(value: float, u: float, *, dof: float = inf, **asked: object) -> Decision:
    """Decision on a result of a normal or t distribution."""
    return decide(Analytic(value, u, dof), **asked)  # type: ignore[arg-type]


VERDICTS = {
    7.0: ("pass", "The result lies within the acceptance limits; the probability that it is not conforming all the same"
          " is 0.0013."),
    9.0: ("conditional pass", "The result lies within the limits, but no further inside than the guard band; the"
          " probability that it is not conforming all the same is 0.16."),
    11.0: ("conditional fail", "The result lies outside the limits, but not as far as the rule asks of a fail; the"
           " probability that it is conforming all the same is 0.16."),
    13.0: ("fail", "The result lies outside the acceptance limits; the probability that it is conforming all the same"
           " is 0.0013."),
}  # fmt: skip


@pytest.mark.parametrize("value", VERDICTS)
def test_law_each_verdict_is_a_sentence_with_its_risk(value: float) -> None:
    found = judged(value, 1.0, limits=Limits(-10.0, 10.0), rule=Rule(coverage_factor=2.0))
    assert (found.verdict, found.sentence) == VERDICTS[value]
    risk = stats.norm.sf(abs(10 - value))
    assert found.specific_risk == pytest.approx(risk, rel=1e-12)
    assert found.probability == pytest.approx(1 - risk if value < 10 else risk, rel=1e-12)
    assert found.rule == "guard band, w = 1·2·u; pass, conditional pass, conditional fail or fail"
    assert (found.global_consumer_risk, found.global_producer_risk) == (None, None)


def test_law_exact_values_and_limits_too_narrow_are_told() -> None:
    exact = judged(1.0, 0.0, limits=Limits(upper=2.0), rule=Rule())
    assert exact.sentence == (
        "The result lies within the acceptance limits; the probability that it is not conforming all the same is 0."
        " The result has no uncertainty, so the decision takes the value as exact."
    )
    narrow = judged(0.0, 1.0, limits=Limits(-1.0, 1.5), rule=Rule("specific risk", risk=0.05))
    assert narrow.sentence == (
        "The result lies within the limits, but no further inside than the guard band; the probability that it is not"
        f" conforming all the same is {stats.norm.sf(1) + stats.norm.sf(1.5):.2g}. The uncertainty is too large for"
        " these limits: no result would pass without condition."
    )
    assert (narrow.guard_band, narrow.acceptance_lower, narrow.acceptance_upper) == (1.25, None, None)
    prior = Prior.normal(0.0, 1.0)
    assert judged(0.0, 1.0, limits=Limits(-1.0, 1.0), rule=Rule(), prior=prior).global_consumer_risk is None


def test_law_a_prior_counts_wherever_the_risk_of_this_item_does() -> None:
    """Posterior N(0.2·8 + 0.8·y, √0.2): on the acceptance limit its risk is the rule's (JCGM 106, 6.2 and 8.3.2)."""
    limits, prior = Limits(upper=10.0), Prior.normal(8.0, 1.0)
    rule = Rule("specific risk", risk=0.01)
    edge = (10.0 - sqrt(0.2) * stats.norm.isf(0.01) - 0.2 * 8.0) / 0.8
    assert judged(9.0, 0.5, limits=limits, rule=rule, prior=prior).acceptance_upper == pytest.approx(edge, rel=1e-9)
    # U does not depend on what is known of the items.
    bands = [judged(9.0, 0.5, limits=limits, rule=Rule(), prior=known).guard_band for known in (None, prior)]
    assert bands[0] == bands[1] == pytest.approx(0.5 * stats.norm.isf(0.025), rel=1e-12)


@pytest.mark.parametrize("dof", [3.0, inf])
@pytest.mark.parametrize("value", [-3.0, 0.0, 0.4, 2.5])
def test_twice_probability_of_conformity_by_scipy(dof: float, value: float) -> None:
    law = stats.norm if dof == inf else stats.t(dof)
    limits, u = Limits(-1.0, 1.5), 0.7
    inside = law.cdf((1.5 - value) / u) - law.cdf((-1.0 - value) / u)
    assert probability_of_conformity(Analytic(value, u, dof), limits) == pytest.approx((inside, 1 - inside), rel=1e-9)


def test_refusal_of_a_decision_is_told_whole() -> None:
    rule = Rule("global risk", factor=-1, risk=0.7, probability=1.0, coverage_factor=-2.0)
    assert refused(lambda: judged(nan, -1.0, limits=Limits(2.0, 1.0), rule=rule, dof=0)) == [
        "limits: got 2.0 to 1.0; expected a lower limit below the upper one",
        "value: got nan; expected a finite number",
        "u: got -1.0; expected a standard uncertainty, not below zero",
        "dof: got 0; expected degrees of freedom above zero",
        "rule.factor: got -1; expected a factor of U, not below zero",
        "rule.risk: got 0.7; expected a probability above 0 and up to 0.5",
        "rule.probability: got 1.0; expected a probability between 0 and 1",
        "rule.coverage_factor: got -2.0; expected k > 0",
        "prior: got none; expected a prior, which a global risk needs",
    ]
    assert refused(lambda: Limits(None, None)) == ["limits: got None to None; expected one or two finite limits"]
    assert refused(lambda: Prior.normal(0.0, -1.0)) == [
        "prior.standard_deviation: got -1.0; expected a finite number above zero"
    ]


@pytest.mark.parametrize("change", [
    {"dof": 0.5}, {"u": 0.0}, {"rule": Rule(factor=0.0)}, {"rule": Rule(risk=0.5)}, {"rule": Rule(probability=0.001)},
    {"rule": Rule(coverage_factor=1e-3)}, {"limits": Limits(1.0, 1.0)}, {"rule": Rule(probability=0.999)},
])  # fmt: skip
def test_limit_what_a_decision_just_allows(change: dict[str, object]) -> None:
    judged(**({"value": 1.0, "u": 1.0, "limits": Limits(upper=2.0), "rule": Rule()} | change))  # type: ignore[arg-type]


@pytest.mark.parametrize("change", [
    {"u": inf}, {"rule": Rule(factor=inf)}, {"rule": Rule(risk=0.0)}, {"rule": Rule(probability=0.0)},
    {"rule": Rule(coverage_factor=inf)}, {"rule": Rule(coverage_factor=0.0)}, {"value": inf}, {"dof": -1.0},
])  # fmt: skip
def test_refusal_what_a_decision_just_does_not_allow(change: dict[str, object]) -> None:
    with pytest.raises(MetrologyError) as caught:
        judged(**({"value": 1.0, "u": 1.0, "limits": Limits(upper=2.0), "rule": Rule()} | change))  # type: ignore[arg-type]
    assert len(caught.value.faults) == 1


PRIORS = {
    "normal (3, 0.5)": (lambda: Prior.normal(3.0, 0.5), stats.norm(3.0, 0.5)),
    "gamma (4, 0.25)": (lambda: Prior.gamma(4.0, 0.25), stats.gamma(4.0, scale=0.25)),
    "lognormal (3, 0.5)": (lambda: Prior.lognormal(3.0, 0.5), stats.lognorm(0.5, scale=3.0)),
    "rectangular (2, 5)": (lambda: Prior.rectangular(2.0, 5.0), stats.uniform(2.0, 3.0)),
}


@pytest.mark.parametrize("name", PRIORS)
def test_law_priors_have_their_names_densities_and_quantiles(name: str) -> None:
    make, law = PRIORS[name]
    prior = make()
    assert prior.name == name
    at = np.array([0.1, 0.5, 0.9])
    np.testing.assert_allclose(prior.quantile(at), law.ppf(at))
    np.testing.assert_allclose(prior.density(law.ppf(at)), law.pdf(law.ppf(at)))


def test_closed_form_risks_without_errors_of_measurement_are_shares_of_the_prior() -> None:
    prior, limits = Prior.normal(0.0, 1.0), Limits(-1.0, 1.5)
    tight, wide = limits.shrunk(0.4), limits.shrunk(-0.4)
    lost = stats.norm.cdf(-0.6) - stats.norm.cdf(-1.0) + stats.norm.cdf(1.5) - stats.norm.cdf(1.1)
    kept = stats.norm.cdf(-1.0) - stats.norm.cdf(-1.4) + stats.norm.cdf(1.9) - stats.norm.cdf(1.5)
    assert global_risks(prior, 0.0, limits=limits, acceptance=tight) == pytest.approx((0.0, lost), abs=1e-12)
    assert global_risks(prior, 0.0, limits=limits, acceptance=wide) == pytest.approx((kept, 0.0), abs=1e-12)
    for one in (Limits(lower=-1.0), Limits(upper=-1.0)):
        assert global_risks(prior, 0.0, limits=one, acceptance=one) == pytest.approx((0.0, 0.0), abs=1e-15)


def test_closed_form_tiny_risks_keep_their_digits() -> None:
    """Uniform on ±1, acceptance ten u inside: R_C = ½·∫Φ(−z − 10)·u dz = u/2·(φ(10) − 10·Φ(−10)), some 1e-26."""
    prior, u = Prior.rectangular(-1.0, 1.0), 0.01
    expected = u / 2 * (stats.norm.pdf(10) - 10 * stats.norm.sf(10))
    for limits in (Limits(upper=0.0), Limits(lower=0.0)):
        consumer, _ = global_risks(prior, u, limits=limits, acceptance=limits.shrunk(10 * u))
        assert consumer == pytest.approx(expected, rel=1e-6, abs=0)


@pytest.mark.parametrize(
    ("limits", "risk"), [(Limits(-1.0, 1.0), 1e-5), (Limits(upper=1.0), 1e-6), (Limits(-1.0, 1.0), 0.01)]
)
def test_law_guard_band_of_a_global_risk_keeps_it(limits: Limits, risk: float) -> None:
    """With 1e-5 the band takes more than a third of the interval, and most of its half."""
    prior = Prior.normal(0.0, 0.6)
    w = global_guard_band(prior, 0.2, limits=limits, risk=risk)
    assert global_risks(prior, 0.2, limits=limits, acceptance=limits.shrunk(w))[0] == pytest.approx(risk, rel=1e-6)


def test_limit_intervals_that_hold_nothing() -> None:
    limits = Limits(-1.0, 1.0)
    assert limits.shrunk(0.25) == Limits(-0.75, 0.75)
    assert limits.shrunk(inf).empty
    assert not Limits(1.0, 1.0).empty
    assert [limits.holds(x) for x in (-1.1, -1.0, 1.0, 1.1)] == [False, True, True, False]


# ---------------------------------------------------------------- comparisons


def test_law_agreement_is_a_sentence() -> None:
    assert en(10.5, 0.3, 9.0, 0.4).sentence == (
        "The two differ by more than their expanded uncertainties: E_n = 1.50 (k = 2)."
    )
    shared = en(1.0, 0.2, 2.0, 0.3, correlation=0.4, k=(2.0, 2.78))
    expanded = sqrt(0.4**2 + 0.834**2 - 2 * 0.4 * 0.4 * 0.834)
    assert shared.sentence == (
        f"The two differ by more than their expanded uncertainties: E_n = {-1 / expanded:.2f} (k = 2 and 2.78,"
        " correlation 0.40 taken into account)."
    )
    assert shared.u_difference == pytest.approx(sqrt(0.04 + 0.09 - 2 * 0.4 * 0.06), rel=1e-12)
    assert astuple(en(1.0, 0.0, 1.25, 0.0)) == (
        -0.25, 0.0, None, None,
        "E_n is undefined: no uncertainty stands against the difference; the values are 0.25 apart.",
    )  # fmt: skip


def test_refusal_of_a_comparison_is_told_whole() -> None:
    assert refused(lambda: en(nan, -1.0, inf, nan, correlation=1.1, k=(0.0, inf))) == [
        "value_a: got nan; expected a finite number",
        "value_b: got inf; expected a finite number",
        "u_a: got -1.0; expected a standard uncertainty, finite and not below zero",
        "u_b: got nan; expected a standard uncertainty, finite and not below zero",
        "correlation: got 1.1; expected a coefficient from −1 to 1",
        "k: got 0.0; expected a coverage factor above zero",
        "k: got inf; expected a coverage factor above zero",
    ]


# ---------------------------------------------------------------- budgets


def test_closed_form_every_column_of_a_budget() -> None:
    """y = 3a − 2b with two components of a, and readings of a and b together."""
    a = Input(
        "a", 1.5,
        (Component("certificate", Normal(0.1), dof=12.0, source="K-17"), Component("drift", Rectangular(0.3))),
        "N", "the load",
    )  # fmt: skip
    b, idle = Input("b", 2.5, (Component("scale", Normal(0.2), kind="A"),), "m", "the length"), Input("c", 1.0)
    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    state = knowledge(a, b, idle, ensembles=[Ensemble("readings", ("a", "b"), covariance, 9.0, "five pairs")])
    rows = budget(propagate([model("3*a - 2*b")], state), 0)
    u2 = 9 * (0.01 + 0.03 + 0.04) + 4 * (0.04 + 0.09) - 12 * 0.01
    expected = {
        ("a", "certificate"): ("the load", 1.5, 0.1, "N", "student", "B", 12.0, 3.0, 0.09, "K-17"),
        ("a", "drift"): ("the load", 1.5, 0.3 / sqrt(3), "N", "rectangular", "B", None, 3.0, 0.27, ""),
        ("a", "readings"): ("the load", 1.5, 0.2, "N", "student", "A", 9.0, 3.0, 0.36 - 0.06, "five pairs"),
        ("b", "scale"): ("the length", 2.5, 0.2, "m", "normal", "A", None, -2.0, 0.16, ""),
        ("b", "readings"): ("the length", 2.5, 0.3, "m", "student", "A", 9.0, -2.0, 0.36 - 0.06, "five pairs"),
    }
    assert sorted((row.input, row.component) for row in rows) == sorted(expected)
    for row in rows:
        text, value, u, unit, shape, kind, dof, c, part, source = expected[row.input, row.component]
        assert (row.description, row.value, row.unit) == (text, value, unit)
        assert (row.kind, row.dof, row.source) == (kind, dof, source)
        assert row.distribution == shape
        assert (row.u, row.sensitivity, row.contribution) == pytest.approx((u, c, c * u), rel=1e-12)
        assert row.share == pytest.approx(part / u2, rel=1e-9)


def test_limit_budget_of_nothing_uncertain_has_no_shares() -> None:
    state = knowledge(*(Input(name, 0.0, (Component("c", Normal(1.0)),)) for name in "ab"))
    rows = budget(propagate([model("a*b")], state), 0)
    assert [(row.share, row.sensitivity, row.contribution) for row in rows] == [(0.0, 0.0, 0.0)] * 2
