"""A curve with errors in x and y: against SciPy over all true x, its covariances and draws by derivatives and laws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fitted import evaluated
from scipy.optimize import least_squares

from metrology.errors import MetrologyError
from metrology.expression import Expression
from metrology.gum import regression

X = np.linspace(0.5, 5.0, 10)
Y = np.array([1.55, 1.35, 2.6, 2.5, 4.4, 4.2, 6.9, 8.1, 8.8, 11.9])
U_X, U_Y = 0.1, 0.2
PARABOLA = "a + b*x + c*x**2"
START = {"a": 1.0, "b": 0.5, "c": 0.2}


def fitted(u_x: float = U_X) -> regression.Regression:
    return regression.curve_both(Expression.parse(PARABOLA), X, Y, start=START, u_x=u_x, u_y=U_Y)


def by_scipy(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parameters and Jacobian of the fit over the parameters and all true x."""

    def rest(unknown: np.ndarray) -> np.ndarray:
        a, b, c, true = *unknown[:3], unknown[3:]
        return np.concatenate([(x - true) / U_X, (y - a - b * true - c * true**2) / U_Y])

    found = least_squares(rest, [1.0, 0.5, 0.2, *x], xtol=1e-15, ftol=1e-15, gtol=1e-15, jac="3-point")
    return found.x[:3], found.jac


def test_twice_parameters_and_information_by_all_true_x() -> None:
    fit, (values, jacobian) = fitted(), by_scipy(X, Y)
    assert fit.values == pytest.approx(values, rel=1e-6)
    information = np.linalg.inv(jacobian.T @ jacobian)[:3, :3]
    assert regression.by_information(fit).covariance == pytest.approx(information, rel=1e-5)


@pytest.mark.long
def test_twice_the_propagated_covariance_by_moving_every_point() -> None:
    columns = []
    for index in range(20):
        step = np.zeros(20)
        step[index] = 1e-3
        up, down = (by_scipy(*(np.concatenate([X, Y]) + sign * step).reshape(2, 10))[0] for sign in (1, -1))
        columns.append((up - down) / 2e-3)
    by_data = np.array(columns).T
    expected = (by_data * np.repeat([U_X**2, U_Y**2], 10)) @ by_data.T
    fit = fitted()
    assert fit.covariance == pytest.approx(expected, rel=1e-3)
    assert abs(fit.u[2] / regression.by_information(fit).u[2] - 1) > 0.01


@pytest.mark.long
def test_law_draws_have_the_covariance_that_was_asked_for() -> None:
    fit = regression.curve_both(Expression.parse(PARABOLA), X, Y, start=START, u_x=0.01, u_y=0.02)
    for one in (fit, regression.by_information(fit)):
        (redrawn,) = regression.knowledge(one, "cal").redrawn
        draws = redrawn.draw(np.random.default_rng(3), 20_000)
        assert draws.std(axis=1) == pytest.approx(one.u, rel=0.02)


def test_limit_of_a_line_and_of_exact_x() -> None:
    line = regression.line(X, Y, u_x=U_X, u_y=U_Y)
    same = regression.curve_both(Expression.parse("a + b*x"), X, Y, start={"a": 0, "b": 1}, u_x=U_X, u_y=U_Y)
    assert same.values == pytest.approx(line.values, rel=1e-9)
    assert same.u == pytest.approx(line.u, rel=1e-4)
    assert same.chi_squared == pytest.approx(line.chi_squared, rel=1e-9)
    plain = regression.polynomial(X, Y, degree=2, u_y=U_Y)
    assert fitted(1e-7).values == pytest.approx(plain.values, rel=1e-6)
    assert fitted(1e-7).u == pytest.approx(plain.u, rel=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 6, 7, 13, 17, 28, 39])
def test_twice_a_curve_that_turns_within_the_uncertainty_of_x(seed: int) -> None:
    """Near a crest the slope vanishes, and steps of Gauss and Newton alone go round it."""
    generator, u_x, u_y = np.random.default_rng(seed), 0.1, 0.05
    true = np.sort(generator.uniform(0, 6, 20))
    x = true + u_x * generator.standard_normal(20)
    y = 2 * np.sin(1.3 * true) + u_y * generator.standard_normal(20)

    def rest(unknown: np.ndarray) -> np.ndarray:
        a, b, at = *unknown[:2], unknown[2:]
        return np.concatenate([(x - at) / u_x, (y - a * np.sin(b * at)) / u_y])

    found = least_squares(rest, [1.8, 1.25, *x], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    fit = regression.curve_both(Expression.parse("a*sin(b*x)"), x, y, start={"a": 1.8, "b": 1.25}, u_x=u_x, u_y=u_y)
    assert fit.converged
    assert fit.values == pytest.approx(found.x[:2], rel=1e-6)
    assert fit.chi_squared == pytest.approx(2 * found.cost, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("covariance", ["propagated", "iso28037"])
def test_twice_a_campaign_with_errors_in_both_axes_of_a_curve(tmp_path: Path, covariance: str) -> None:
    findings = evaluated(
        tmp_path,
        f"""\
    x: {X.tolist()}
    y: {Y.tolist()}
    u_x: {{value: {U_X}}}
    u_y: {{value: {U_Y}}}
    scatter: stated
    covariance: {covariance}
    model: {{expression: '{PARABOLA}', start: {{a: 1, b: 0.5, c: 0.2}}}}
""",
    )
    (fit,) = findings.fits
    values, jacobian = by_scipy(X, Y)
    assert fit.values == pytest.approx(values, rel=1e-6)
    information = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))[:3]
    assert (fit.u == pytest.approx(information, rel=1e-4)) == (covariance == "iso28037")


def test_refusal_uncertainties_of_x_alone() -> None:
    with pytest.raises(MetrologyError, match="uncertainties of x alone"):
        regression.curve_both(Expression.parse(PARABOLA), X, Y, start=START, u_x=U_X, u_y=None)
