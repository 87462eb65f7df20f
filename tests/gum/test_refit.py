"""Parameters of a fit drawn by fitting drawn data: against SciPy closed forms, and limits of the law."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import certified
import numpy as np
import pytest
from certified import numbers
from fitted import evaluated
from scipy import stats
from scipy.optimize import least_squares, minimize_scalar

from metrology.expression import Expression
from metrology.gum import Measurand, evaluate, regression

X = np.linspace(0.0, 5.0, 6)
Y = np.array([0.4, 1.1, 2.6, 2.7, 4.6, 4.7])


def drawn(fit: regression.Regression, size: int, seed: int = 1) -> np.ndarray:
    (found,) = regression.knowledge(fit, "cal").redrawn
    return fit.values[:, None] + found.draw(np.random.default_rng(seed), size)


def mgh09() -> tuple[regression.Regression, np.ndarray, np.ndarray]:
    model, x, y, starts, values, *_ = certified.NONLINEAR["MGH09"]
    names = [f"b{i + 1}" for i in range(len(numbers(values)))]
    start = dict(zip(names, starts[-1], strict=True))
    x, y = numbers(x), numbers(y)
    return regression.curve(Expression.parse(model), x, y, start=start), np.array(x), np.array(y)


@pytest.mark.long
def test_twice_refits_of_mgh09_are_distributed_as_those_of_scipy() -> None:
    fit, x, y = mgh09()
    rng = np.random.default_rng(5)
    found = []
    for _ in range(800):
        data = y + fit.s * rng.standard_t(1e9, 11) / sqrt(rng.chisquare(7) / 7)

        def gap(b: np.ndarray, data: np.ndarray = data) -> np.ndarray:
            return b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]) - data

        found.append(least_squares(gap, fit.values, method="lm", max_nfev=2000).x[1])
    ours = drawn(fit, 20_000)[1]
    normal = fit.values[1] + fit.u[1] * rng.standard_t(7, 20_000)
    assert stats.ks_2samp(found, ours).pvalue > 0.01
    assert stats.ks_2samp(found, normal).pvalue < 1e-6


@pytest.mark.long
def test_reference_interval_of_mgh09_b2_has_no_negative_values_which_the_law_gives() -> None:
    fit, *_ = mgh09()
    model = Measurand("b2", lambda q: q["cal.b2"])
    found = evaluate([model], regression.knowledge(fit, "cal"), seed=1).estimates["b2"]
    assert (found.coverage.low, found.coverage.high) == pytest.approx((-0.273, 0.656), abs=1e-3)
    assert found.monte_carlo.low == pytest.approx(0.0, abs=0.01)
    assert 0.85 < found.monte_carlo.high < 1.25
    assert not found.monte_carlo.law_valid


def covariances() -> dict[str, np.ndarray]:
    close = 0.5 * np.eye(6) + 0.5
    x, y, both = 0.36 * close, 0.25 * close, 0.06 * np.eye(6)
    zero, one = np.zeros((6, 6)), np.eye(6)
    return {
        "independent": np.block([[0.36 * one, zero], [zero, 0.25 * one]]),
        "x with y": np.block([[0.36 * one, both], [both, 0.25 * one]]),
        "within x and y": np.block([[x, zero], [zero, y]]),
        "all": np.block([[x, both], [both, y]]),
    }


def slope(x: np.ndarray, y: np.ndarray, covariance: np.ndarray) -> float:
    """Slope of least χ² over both unknowns, by a bounded search for b with a in closed form."""
    one = np.ones(len(x))

    def chi_squared(b: float) -> float:
        turn = np.hstack([-b * np.eye(len(x)), np.eye(len(x))])
        weight = np.linalg.inv(turn @ covariance @ turn.T)
        r = y - b * x
        r = r - (one @ weight @ r) / (one @ weight @ one)
        return float(r @ weight @ r)

    return float(minimize_scalar(chi_squared, bounds=(0.1, 4.0), method="bounded", options={"xatol": 1e-8}).x)


@pytest.mark.long
@pytest.mark.parametrize("name", covariances())
def test_twice_refits_of_a_line_with_errors_in_x_and_y(name: str) -> None:
    covariance = covariances()[name]
    if name in ("independent", "x with y"):
        r = covariance[0, 6] / 0.3
        fit = regression.line(X, Y, u_x=0.6, u_y=0.5, correlation=r)
    else:
        fit = regression.line(X, Y, covariance=covariance)
    rng = np.random.default_rng(2)
    root = np.linalg.cholesky(covariance)
    found = []
    for _ in range(600):
        x, y = np.split(np.concatenate([X, Y]) + root @ rng.standard_normal(12), 2)
        found.append(slope(x, y, covariance))
    ours = drawn(fit, 20_000)[1]
    assert stats.ks_2samp(found, ours).pvalue > 0.01


def test_closed_form_refits_of_a_straight_line_written_as_a_curve_are_students() -> None:
    fit = regression.curve(Expression.parse("a + b*x"), X, Y, start={"a": 1.0, "b": 2.0})
    line = regression.line(X, Y)
    for row, values in enumerate(drawn(fit, 100_000)):
        standard = (values - line.values[row]) / line.u[row]
        assert stats.kstest(standard, stats.t(4).cdf).pvalue > 0.001


def test_limit_of_linear_estimators_the_covariance_says_it_all() -> None:
    for fit in (regression.line(X, Y), regression.line(X, Y, u_y=0.3), regression.polynomial(X, Y, degree=3, u_y=1)):
        assert regression.knowledge(fit, "cal").redrawn == ()


@pytest.mark.long
def test_law_draws_about_the_adjusted_points_have_the_covariance_of_iso_28037_and_others_the_propagated_one() -> None:
    # Small uncertainties and large residuals: the two covariances differ, and the refits are nearly linear.
    fit = regression.line(X, [0, 4, -1, 5, 1, 6], u_x=0.02, u_y=0.02)
    other = regression.by_information(fit)
    assert abs(fit.u[1] / other.u[1] - 1) > 0.05
    for one in (fit, other):
        assert drawn(one, 100_000).std(axis=1) == pytest.approx(one.u, rel=0.015)


def test_closed_form_scaled_uncertainties_are_drawn_as_students() -> None:
    # Residuals of 1e-3 on a line of 10: the slope is as good as linear in them.
    fit = regression.scaled(regression.line(X, 2 * X + 1e-3 * (Y - X), u_x=1e-5, u_y=1e-5))
    assert fit.s > 10
    standard = (drawn(fit, 50_000)[1] - fit.values[1]) / fit.u[1]
    assert stats.kstest(standard, stats.t(4).cdf).pvalue > 0.001


@pytest.mark.long
def test_reference_a_curve_of_a_campaign_is_drawn_by_refits(tmp_path: Path) -> None:
    # BoxBOD of NIST: b2 of 0.547 with a long tail upwards; by the law up to 0.838.
    _, x, y, *_ = certified.NONLINEAR["BoxBOD"]
    findings = evaluated(
        tmp_path,
        f"""\
    x: {{values: {numbers(x)}, unit: "1"}}
    y: {{values: {numbers(y)}, unit: "1"}}
    model: {{expression: 'b1*(1 - exp(-b2*x))', start: {{b1: 100, b2: 0.75}}}}
""",
    )
    found = next(one for one in findings.results if one.name == "cal.result.b2")
    assert found.coverage.high == pytest.approx(0.838, abs=1e-3)
    ours = found.monte_carlo
    rng = np.random.default_rng(9)
    at, data = np.array(numbers(x)), np.array(numbers(y))
    refits = []
    for _ in range(1500):
        moved = data + 17.088072423 * rng.standard_normal(6) / sqrt(rng.chisquare(4) / 4)
        gap = lambda b, moved=moved: b[0] * (1 - np.exp(-b[1] * at)) - moved  # noqa: E731
        refits.append(least_squares(gap, [213.8, 0.547], method="lm").x[1])
    below, above = np.mean(np.array(refits) < ours.low), np.mean(np.array(refits) > ours.high)
    assert 0.014 < below < 0.036
    assert 0.014 < above < 0.036
    assert ours.high > 1.1
    assert not ours.law_valid
