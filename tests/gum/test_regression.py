"""Lines and curves: certified and published digits, closed forms, second ways, extreme scales, refusals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import certified
import numpy as np
import pytest
from certified import numbers
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize
from scipy.stats import chi2
from uncertainties import ufloat, umath

from metrology.errors import MetrologyError
from metrology.expression import Expression
from metrology.gum import regression

WLS = ([1, 2, 3, 4, 5, 6], [3.3, 5.6, 7.1, 9.3, 10.7, 12.1])
THERMOMETER = (
    [21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511],
    [-0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160],
)
PEARSON_X, W_X = [0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4], [1000, 1000, 500, 800, 200, 80, 60, 20, 1.8, 1.0]
PEARSON_Y, W_Y = [5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5], [1, 1.8, 4, 8, 20, 20, 70, 70, 100, 500.0]


def digits(got: float, certified_value: str) -> float:
    """Number of digits to which a value agrees with a certified one."""
    expected = float(certified_value)
    return -math.log10(max(abs(got - expected) / abs(expected), 1e-16))


# Published digits


def test_reference_thermometer_calibration() -> None:
    # JCGM 100:2008 H.3, Table H.6
    fit = regression.line(np.array(THERMOMETER[0]) - 20, THERMOMETER[1])
    assert [f"{v:.4f}" for v in (fit.values[0], fit.u[0], fit.s or 0)] == ["-0.1712", "0.0029", "0.0035"]
    assert [f"{v:.5f}" for v in (fit.values[1], fit.u[1])] == ["0.00218", "0.00067"]
    assert f"{fit.correlation[0, 1]:.3f}" == "-0.930"
    assert fit.dof == fit.residual_dof == 9
    at30 = regression.predict(fit, 10.0)
    assert (f"{at30.value[0]:.4f}", f"{at30.u[0]:.4f}", at30.dof) == ("-0.1494", "0.0041", 9)


@pytest.mark.parametrize(
    ("y", "u_y", "published"),
    [
        # ISO/TS 28037:2010, the two examples of clause 6
        (WLS[1], [0.5] * 6, ["1.867", "1.757", "0.465", "0.120", "-0.050", "1.665"]),
        (
            [3.2, 4.3, 7.6, 8.6, 11.7, 12.8],
            [0.5] * 3 + [1.0] * 3,
            ["0.885", "2.057", "0.530", "0.178", "-0.082", "4.131"],
        ),
    ],
)
def test_reference_weighted_line(y: list[float], u_y: list[float], published: list[str]) -> None:
    fit = regression.line(WLS[0], y, u_y=u_y)
    found = (*fit.values, *fit.u, fit.covariance[0, 1], fit.chi_squared or 0)
    assert [f"{value:.3f}" for value in found] == published
    assert fit.dof == math.inf
    assert fit.p_value == pytest.approx(chi2.sf(fit.chi_squared, 4), rel=1e-12)


@pytest.mark.parametrize(
    ("y", "u_y", "new", "published"),
    [
        (WLS[1], [0.5] * 6, (10.5, 0.5), ("4.913", "0.322")),
        ([3.2, 4.3, 7.6, 8.6, 11.7, 12.8], [0.5] * 3 + [1.0] * 3, (10.5, 1.0), ("4.674", "0.533")),
    ],
)
def test_reference_inverse_use_of_a_line(
    y: list[float], u_y: list[float], new: tuple[float, float], published: tuple[str, str]
) -> None:
    # ISO/TS 28037:2010, 11.1
    found = regression.inverse(regression.line(WLS[0], y, u_y=u_y), new[0], u_y=new[1])
    assert found.value is not None
    assert (f"{found.value:.3f}", f"{found.u:.3f}") == published


def test_reference_errors_in_both_of_pearson_and_york() -> None:
    # values: Neri et al., J. Phys. E 22 (1989) 215; uncertainties: Kalantar, Meas. Sci. Technol. 3 (1992) 1113
    fit = regression.line(PEARSON_X, PEARSON_Y, u_x=np.array(W_X) ** -0.5, u_y=np.array(W_Y) ** -0.5)
    assert (f"{fit.values[0]:.8f}", f"{fit.values[1]:.9f}") == ("5.47991022", "-0.480533407")
    assert (f"{fit.u[0]:.5f}", f"{fit.u[1]:.6f}") == ("0.29193", "0.057617")
    assert f"{fit.covariance[0, 1]:.4f}" == "-0.0162"
    assert f"{(fit.chi_squared or 0) / 8:.4f}" == "1.4833"
    simple = regression.by_information(fit)
    assert (round(simple.u[0], 5), round(simple.u[1], 6)) == (0.29497, 0.057985)


def test_reference_errors_in_both_of_the_technical_specification() -> None:
    # ISO/TS 28037:2010, clause 7, example
    x, y = [1.2, 1.9, 2.9, 4.0, 4.7, 5.9], [3.4, 4.4, 7.2, 8.5, 10.8, 13.5]
    fit = regression.by_information(regression.line(x, y, u_x=0.2, u_y=[0.2] * 3 + [0.4] * 3))
    found = (*fit.values, *fit.u, fit.covariance[0, 1])
    assert [f"{value:.4f}" for value in found] == ["0.5788", "2.1597", "0.4764", "0.1355", "-0.0577"]
    assert f"{fit.chi_squared:.3f}" == "2.743"


def test_reference_norris() -> None:
    fit = regression.line(numbers(certified.NORRIS_X), numbers(certified.NORRIS_Y))
    for value, u, (certified_value, certified_u) in zip(fit.values, fit.u, certified.NORRIS, strict=True):
        assert digits(value, certified_value) > 12
        assert digits(u, certified_u) > 12
    assert digits(fit.s or 0, "0.884796396144373") > 12


def test_reference_filip() -> None:
    fit = regression.polynomial(numbers(certified.FILIP_X), numbers(certified.FILIP_Y), degree=10)
    for value, u, (certified_value, certified_u) in zip(fit.values, fit.u, certified.FILIP, strict=True):
        assert digits(value, certified_value) > 9
        assert digits(u, certified_u) > 9
    assert digits(fit.s or 0, "0.334801051324544E-02") > 9


@pytest.mark.parametrize("scale", [0, 1, 100, 10_000])
def test_reference_wampler(scale: int) -> None:
    x = np.arange(21.0)
    ones = sum(x**i for i in range(6))
    deviations = np.array(numbers(certified.WAMPLER3_Y)) - ones
    fit = regression.polynomial(x, ones + scale * deviations, degree=5)
    assert fit.names == ("b0", "b1", "b2", "b3", "b4", "b5")
    for value, u, certified_u in zip(fit.values, fit.u, certified.WAMPLER3_U.split(), strict=True):
        assert digits(value, "1.0") > 9
        assert u < 1e-8 if scale == 0 else digits(u / scale, certified_u) > 12


def test_reference_wampler2() -> None:
    x = np.arange(21.0)
    fit = regression.polynomial(x, sum((0.1 * x) ** i for i in range(6)), degree=5)
    for i, value in enumerate(fit.values):
        assert digits(value, f"1e-{i}") > 9


@pytest.mark.parametrize("name", certified.NONLINEAR)
@pytest.mark.parametrize("start", [0, 1])
def test_reference_nonlinear_from_both_starts(name: str, start: int) -> None:
    model, x, y, starts, values, deviations, s = certified.NONLINEAR[name]
    names = {f"b{i}": value for i, value in enumerate(starts[start], 1)}
    fit = regression.curve(Expression.parse(model), numbers(x), numbers(y), start=names)
    assert fit.converged
    for value, u, value_, u_ in zip(fit.values, fit.u, values.split(), deviations.split(), strict=True):
        assert digits(value, value_) > 9
        assert digits(u, u_) > 9
    assert digits(fit.s or 0, s) > 9


# Closed forms and second ways


def exact_line(x: Sequence[float], y: Sequence[float], w: Sequence[float]) -> tuple[Fraction, ...]:
    """Intercept, slope, and covariance of unit weight, by the normal equations in exact arithmetic."""
    xs, ys, ws = ([Fraction(value) for value in column] for column in (x, y, w))
    s0, s1, s2 = (sum(weight * value**k for weight, value in zip(ws, xs, strict=True)) for k in range(3))
    t0, t1 = (sum(a * b**k * c for a, b, c in zip(ws, xs, ys, strict=True)) for k in range(2))
    d = s0 * s2 - s1 * s1
    return (s2 * t0 - s1 * t1) / d, (s0 * t1 - s1 * t0) / d, s2 / d, s0 / d, -s1 / d


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e9])
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_twice_lines_by_exact_arithmetic_at_extreme_scales_and_offsets(offset: float, scale: float) -> None:
    generator = np.random.Generator(np.random.PCG64(7))
    x = offset + np.arange(12.0)
    y = scale * (3 * (x - offset) + generator.normal(size=12))
    u = scale * generator.uniform(0.5, 2, 12)
    fit = regression.line(x, y, u_y=u)
    a, b, v_a, v_b, cov = exact_line(list(x), list(y), [float(value) for value in 1 / u**2])
    assert fit.values[1] == pytest.approx(float(b), rel=1e-12)
    assert fit.values[0] == pytest.approx(float(a), rel=1e-12)
    assert fit.covariance[0, 0] == pytest.approx(float(v_a), rel=1e-12)
    assert fit.covariance[1, 1] == pytest.approx(float(v_b), rel=1e-12)
    assert fit.covariance[0, 1] == pytest.approx(float(cov), rel=1e-12, abs=1e-12 * math.sqrt(float(v_a * v_b)))
    middle = float(np.mean(x))
    expected = math.sqrt(float(v_a + 2 * Fraction(middle) * cov + Fraction(middle) ** 2 * v_b))
    assert regression.predict(fit, middle).u[0] == pytest.approx(expected, rel=1e-11)


def test_limit_y_offset_of_a_billion_times_the_scatter() -> None:
    x = np.arange(8.0)
    scatter = np.array([1, -1, -1, 1, 1, -1, -1, 1.0])
    fit = regression.line(x, 1e9 + scatter)
    _, b, *_ = exact_line(list(x), list(1e9 + scatter), [1.0] * 8)
    assert fit.values[1] == pytest.approx(float(b), abs=1e-10)
    assert fit.s == pytest.approx(regression.line(x, scatter).s, rel=1e-9)


def test_limit_a_hundred_thousand_points() -> None:
    n = 10**5
    x = np.arange(float(n))
    y = 2.0 + 0.5 * x + np.where(np.arange(n) % 2, 1.0, -1.0)
    fit = regression.line(x, y)
    assert fit.values[1] == pytest.approx(0.5, rel=1e-6)
    assert fit.s == pytest.approx(1.0, rel=1e-4)


def test_twice_correlated_y_against_the_normal_equations() -> None:
    generator = np.random.Generator(np.random.PCG64(3))
    x = np.linspace(0, 4, 9)
    root = generator.normal(size=(9, 9))
    v = root @ root.T + np.eye(9)
    y = 1 + 2 * x + generator.normal(size=9)
    fit = regression.line(x, y, covariance=v)
    design = np.column_stack([np.ones(9), x])
    information = design.T @ np.linalg.solve(v, design)
    expected = np.linalg.solve(information, design.T @ np.linalg.solve(v, y))
    np.testing.assert_allclose(fit.values, expected, rtol=1e-11)
    np.testing.assert_allclose(fit.covariance, np.linalg.inv(information), rtol=1e-10)
    same = regression.curve(lambda at, p: p["a"] + p["b"] * at, x, y, start={"a": 0.0, "b": 1.0}, covariance=v)
    np.testing.assert_allclose(same.values, expected, rtol=1e-11)
    np.testing.assert_allclose(same.covariance, fit.covariance, rtol=1e-10)


def test_limit_without_errors_in_x_the_line_is_the_weighted_one() -> None:
    u = [0.5, 0.3, 0.5, 1.0, 0.2, 0.7]
    plain = regression.line(*WLS, u_y=u)
    both = regression.line(*WLS, u_x=1e-9, u_y=u)
    np.testing.assert_allclose(both.values, plain.values, rtol=1e-12)
    np.testing.assert_allclose(both.covariance, plain.covariance, rtol=1e-9)
    assert both.chi_squared == pytest.approx(plain.chi_squared, rel=1e-12)


def test_law_exchange_of_x_and_y_inverts_the_line() -> None:
    u_x, u_y = np.array(W_X) ** -0.5, np.array(W_Y) ** -0.5
    forth = regression.line(PEARSON_X, PEARSON_Y, u_x=u_x, u_y=u_y)
    back = regression.line(PEARSON_Y, PEARSON_X, u_x=u_y, u_y=u_x)
    assert back.values[1] == pytest.approx(1 / forth.values[1], rel=1e-11)
    assert back.values[0] == pytest.approx(-forth.values[0] / forth.values[1], rel=1e-11)
    assert back.u[1] == pytest.approx(forth.u[1] / forth.values[1] ** 2, rel=1e-9)
    assert back.chi_squared == pytest.approx(forth.chi_squared, rel=1e-12)


@pytest.mark.parametrize("scale", [(1.0, 1.0), (1e-6, 1e9), (1e9, 1e-6)])
def test_twice_errors_in_both_against_orthogonal_distance_regression(scale: tuple[float, float]) -> None:
    x, y = np.array(PEARSON_X) * scale[0], np.array(PEARSON_Y) * scale[1]
    u_x, u_y = np.array(W_X) ** -0.5 * scale[0], np.array(W_Y) ** -0.5 * scale[1]
    fit = regression.line(x, y, u_x=u_x, u_y=u_y)

    def distances(p: Any) -> Any:
        """Weighted distances in x and in y, with the true x as parameters of their own."""
        true = p[2:]
        return np.concatenate([(PEARSON_X - true) * np.sqrt(W_X), (PEARSON_Y - p[0] - p[1] * true) * np.sqrt(W_Y)])

    found = optimize.least_squares(distances, [5.0, -0.5, *PEARSON_X], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert fit.values[0] / scale[1] == pytest.approx(found.x[0], rel=1e-7)
    assert fit.values[1] / scale[1] * scale[0] == pytest.approx(found.x[1], rel=1e-7)
    assert fit.chi_squared == pytest.approx(2 * found.cost, rel=1e-10)


def _correlated(x: Any, y: Any, r: float) -> tuple[Any, np.ndarray[Any, Any]]:
    n = len(x)
    u_x, u_y = np.array(W_X) ** -0.5, np.array(W_Y) ** -0.5
    v = np.zeros((2 * n, 2 * n))
    v[:n, :n], v[n:, n:] = np.diag(u_x**2), np.diag(u_y**2)
    v[:n, n:] = v[n:, :n] = np.diag(r * u_x * u_y)
    return (u_x, u_y), v


@pytest.mark.parametrize("r", [-0.9, 0.3, 0.99])
def test_twice_errors_in_both_with_correlation_by_numerical_derivatives_of_the_minimum(r: float) -> None:
    (u_x, u_y), v = _correlated(PEARSON_X, PEARSON_Y, r)

    def minimum(z: Any) -> Any:
        x, y = z[:10], z[10:]

        def chi_squared(p: Any) -> float:
            w = u_y**2 - 2 * p[1] * r * u_x * u_y + (p[1] * u_x) ** 2
            return float(np.sum((y - p[0] - p[1] * x) ** 2 / w))

        start = optimize.minimize(
            chi_squared, [5.5, -0.5], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12}
        )
        return start.x

    fit = regression.line(PEARSON_X, PEARSON_Y, u_x=u_x, u_y=u_y, correlation=r)
    z, h = np.array([*map(float, PEARSON_X), *PEARSON_Y]), 1e-3
    np.testing.assert_allclose(fit.values, minimum(z), rtol=1e-6)
    jacobian = np.array([(minimum(z + step) - minimum(z - step)) / (2 * h) for step in h * np.eye(20)]).T
    np.testing.assert_allclose(fit.covariance, jacobian @ v @ jacobian.T, rtol=1e-3)
    whole = regression.line(PEARSON_X, PEARSON_Y, covariance=v)
    np.testing.assert_allclose(whole.values, fit.values, rtol=1e-9)
    np.testing.assert_allclose(whole.covariance, fit.covariance, rtol=1e-8)


@pytest.mark.study
def test_twice_errors_in_both_cover_the_truth_as_often_as_they_say() -> None:
    generator = np.random.Generator(np.random.PCG64(11))
    true_x = np.linspace(0, 10, 12)
    slopes, stated = [], []
    for _ in range(2000):
        x = true_x + generator.normal(0, 0.2, 12)
        y = 1 + 0.7 * true_x + generator.normal(0, 0.3, 12)
        fit = regression.line(x, y, u_x=0.2, u_y=0.3)
        slopes.append(fit.values[1])
        stated.append(fit.u[1])
    assert np.std(slopes) == pytest.approx(np.mean(stated), rel=0.06)
    assert np.mean(slopes) == pytest.approx(0.7, abs=4 * np.std(slopes) / math.sqrt(2000))


def test_closed_form_scaled_weights_take_the_scatter_as_their_measure() -> None:
    weighted = regression.scaled(regression.line(*WLS, u_y=17.0))
    plain = regression.line(*WLS)
    np.testing.assert_allclose(weighted.covariance, plain.covariance, rtol=1e-12)
    assert weighted.dof == plain.dof == 4
    np.testing.assert_allclose(
        regression.predict(weighted, [0.0, 9.0]).u, regression.predict(plain, [0.0, 9.0]).u, rtol=1e-12
    )


def test_closed_form_as_many_points_as_parameters_with_stated_uncertainty() -> None:
    fit = regression.line([1.0, 3.0], [2.0, 6.0], u_y=[0.1, 0.2])
    np.testing.assert_allclose(fit.values, [0.0, 2.0], atol=1e-14)
    assert fit.u[1] == pytest.approx(math.hypot(0.1, 0.2) / 2, rel=1e-14)
    assert fit.p_value is None
    assert "nothing is left to test the fit" in fit.sentence


def test_closed_form_the_sentence_says_when_the_points_scatter_more_than_stated() -> None:
    assert "scatter more than their stated uncertainties" in regression.line(*WLS, u_y=0.05).sentence
    assert "account for the scatter" in regression.line(*WLS, u_y=0.5).sentence
    assert "s = 0.323, 4 degrees of freedom" in regression.line(*WLS).sentence


def test_twice_knowledge_of_a_fit_propagates_as_its_prediction_does() -> None:
    fit = regression.line(*WLS, u_y=0.5)
    known = regression.knowledge(fit, "cal", ["N", "N/m"])
    assert list(known.inputs) == ["cal.a", "cal.b"]
    assert [item.unit for item in known.inputs.values()] == ["N", "N/m"]
    ((pair, r),) = known.correlations.items()
    a, b = (known.inputs[name] for name in ("cal.a", "cal.b"))
    variance = a.u**2 + (7 * b.u) ** 2 + 2 * 7 * r * a.u * b.u
    assert set(pair) == {"cal.a", "cal.b"}
    assert math.sqrt(variance) == pytest.approx(regression.predict(fit, 7.0).u[0], rel=1e-12)
    scattered = regression.knowledge(regression.line(*WLS), "cal")
    (ensemble,) = scattered.ensembles
    assert (ensemble.members, ensemble.dof) == (("cal.a", "cal.b"), 4)
    np.testing.assert_array_equal(ensemble.covariance, regression.line(*WLS).covariance)
    assert all(not item.components for item in scattered.inputs.values())


def test_twice_inverse_of_a_curve_by_the_law_of_propagation() -> None:
    x = np.linspace(0, 3, 12)
    fit = regression.curve(Expression.parse("A*exp(c*x)"), x, 2 * np.exp(0.5 * x), start={"A": 1.0, "c": 1.0}, u_y=0.01)
    found = regression.inverse(fit, 5.0, u_y=0.02)
    y = ufloat(5.0, 0.02)
    expected = umath.log(y / 2) / 0.5
    by_fit = (regression.predict(fit, found.value or 0).u[0]) / (0.5 * 5.0)
    assert found.value == pytest.approx(expected.n, rel=1e-9)
    assert found.u == pytest.approx(math.hypot(expected.s, by_fit), rel=1e-6)


@pytest.mark.parametrize(
    ("y", "between", "part"),
    [(-1.0, None, "does not take the value -1"), (1.0, None, "more than once"), (4.0, None, ""), (1.0, (0.5, 2.0), "")],
)
def test_limit_inverse_of_a_parabola(y: float, between: tuple[float, float] | None, part: str) -> None:
    x = np.linspace(-2, 2.5, 10)
    fit = regression.polynomial(x, x**2, degree=2, u_y=0.01)
    found = regression.inverse(fit, y, between=between)
    assert part in found.sentence
    assert (found.value is None) == bool(part)
    if not part:
        assert abs(found.value or 0) == pytest.approx(math.sqrt(y), rel=1e-9)


@pytest.mark.parametrize("scale", [1e-15, 1e-6, 1e9])
def test_law_inverse_of_a_curve_keeps_its_digits_in_any_unit(scale: float) -> None:
    x = scale * np.linspace(0.5, 2.5, 10)
    fit = regression.polynomial(x, (x / scale) ** 2, degree=2, u_y=0.01)
    found = regression.inverse(fit, 3.0).value
    assert found is not None
    assert found / scale == pytest.approx(math.sqrt(3), rel=1e-12)


def test_law_prediction_of_a_line_with_errors_in_both_lies_on_it() -> None:
    fit = regression.line(PEARSON_X, PEARSON_Y, u_x=np.array(W_X) ** -0.5, u_y=np.array(W_Y) ** -0.5)
    at = np.array([-3.0, 0.0, 4.5, 12.0])
    np.testing.assert_allclose(regression.predict(fit, at).value, fit.values[0] + fit.values[1] * at, rtol=1e-12)


@pytest.mark.parametrize("u_y", [None, 0.01])
def test_law_chi_squared_belongs_to_stated_uncertainties_and_s_to_scatter(u_y: float | None) -> None:
    x = np.linspace(0, 3, 12)
    y = 2 * np.exp(0.5 * x) + 0.01 * np.cos(9 * x)
    fit = regression.curve(Expression.parse("A*exp(c*x)"), x, y, start={"A": 1.0, "c": 1.0}, u_y=u_y)
    assert (fit.chi_squared is None, fit.s is None) == (u_y is None, u_y is not None)
    spread = float(fit.residuals @ fit.residuals)
    assert (fit.s**2 * 10 if fit.s is not None else fit.chi_squared * u_y**2) == pytest.approx(spread, rel=1e-9)
    assert "scatter about the curve" in fit.sentence or u_y


def test_closed_form_two_points_with_errors_in_both_give_the_line_through_them() -> None:
    fit = regression.line([1.0, 3.0], [2.0, 8.0], u_x=0.1, u_y=0.2)
    np.testing.assert_allclose(fit.values, [-1.0, 3.0], rtol=1e-12)
    # b = Δy/Δx: u(b) = √(2·u_y² + 2·b²·u_x²)/Δx
    assert fit.u[1] == pytest.approx(math.sqrt(2 * 0.2**2 + 2 * 9 * 0.1**2) / 2, rel=1e-9)


def test_limit_inverse_of_a_flat_line_is_refused_in_a_sentence() -> None:
    noisy = regression.line([1, 2, 3, 4], [1.0, 1.2, 0.8, 1.0], u_y=0.3)
    assert "is not distinguished from zero" in regression.inverse(noisy, 1.0).sentence
    flat = regression.line([1, 2, 3, 4], [1.0, 1.0, 1.0, 1.0], u_y=0.3)
    assert regression.inverse(flat, 1.0).value is None
    level = regression.polynomial(np.linspace(-1, 1, 9), np.full(9, 2.0), degree=2, u_y=0.1)
    assert regression.inverse(level, 1.0).value is None


def test_limit_no_scatter_at_all_gives_no_uncertainty() -> None:
    fit = regression.line([1.0, 2.0, 3.0, 4.0], [2.0, 4.0, 6.0, 8.0])
    np.testing.assert_allclose(fit.values, [0.0, 2.0], atol=1e-15)
    assert fit.s == pytest.approx(0.0, abs=1e-15)
    assert np.all(np.isfinite(fit.correlation))


# Curves that fail, and refusals


def test_limit_parameters_that_cannot_be_told_apart_are_told_of() -> None:
    x = np.linspace(1, 2, 8)
    fit = regression.curve(Expression.parse("a*b*x"), x, 3 * x + 0.01 * np.cos(9 * x), start={"a": 1.0, "b": 1.0})
    assert not fit.converged
    assert "do not distinguish the parameters" in fit.sentence
    assert np.all(np.isnan(fit.covariance))
    assert regression.inverse(fit, 3.0).sentence == fit.sentence
    with pytest.raises(MetrologyError, match="a fit that did not converge"):
        regression.knowledge(fit, "f")


def test_limit_a_parameter_without_influence_or_a_curve_that_runs_away_is_told_of() -> None:
    x = np.linspace(0, 1, 8)
    idle = regression.curve(lambda at, p: p["a"] * at + 0 * p["b"], x, 3 * x, start={"a": 1.0, "b": 1.0}, u_y=0.1)
    assert not idle.converged
    away = regression.curve(Expression.parse("exp(c*x)"), x, -1 - x, start={"c": 1.0}, u_y=0.1)
    assert not away.converged
    assert np.all(np.isnan(away.covariance))


def test_limit_a_parameter_that_is_zero_settles_as_well() -> None:
    x = np.linspace(0.0, 4.0, 9)
    wave = np.array([1, -1, 0, 0, 0, 0, 0, -1, 1.0])
    fit = regression.curve(
        Expression.parse("a + b*x*exp(-c*x)"), x, 2 * x + 1e-3 * wave, start={"a": 1.0, "b": 1.0, "c": 0.1}
    )
    assert fit.converged
    assert np.all(np.abs(fit.values - [0.0, 2.0, 0.0]) < 5 * fit.u)
    nothing = regression.curve(Expression.parse("a*x"), x, 0 * x, start={"a": 1.0}, u_y=0.1)
    assert nothing.converged
    assert nothing.values[0] == pytest.approx(0.0, abs=1e-15)


def test_limit_a_curve_whose_best_parameter_lies_on_the_edge_of_its_domain_does_not_settle() -> None:
    x = np.linspace(1.0, 4.0, 9)
    fit = regression.curve(Expression.parse("sqrt(c)*x"), x, -x, start={"c": 1.0}, u_y=0.1)
    assert not fit.converged
    assert "Begin from other values" in fit.sentence


coordinates = st.integers(-5, 5).map(float)
points = st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=6).filter(
    lambda p: len({x for x, _ in p}) > 1
)


@settings(deadline=None)
@given(points, st.sampled_from([1e-3, 0.1, 1.0, 30.0]), st.sampled_from([1e-3, 0.1, 1.0, 30.0]))
def test_law_any_cloud_gives_the_least_line_with_finite_uncertainty_or_a_sentence(
    cloud: Any, u_x: float, u_y: float
) -> None:
    x, y = (np.array(column) for column in zip(*cloud, strict=True))
    fit = regression.line(x, y, u_x=u_x, u_y=u_y)
    if not fit.converged:
        assert np.all(np.isnan(fit.covariance))
        assert "did not converge" in fit.sentence
        return
    assert np.all(np.isfinite(fit.covariance))

    def chi_squared(slope: float) -> float:
        rho = y - slope * x - np.mean(y - slope * x)
        return float(rho @ rho / (u_y**2 + slope**2 * u_x**2))

    slopes = np.concatenate([np.linspace(-3, 3, 61), np.tan(np.linspace(-1.5, 1.5, 60)), [fit.values[1]]])
    assert fit.chi_squared == pytest.approx(chi_squared(fit.values[1]), rel=1e-9, abs=1e-12)
    assert fit.chi_squared <= min(chi_squared(slope) for slope in slopes) * (1 + 1e-9) + 1e-12


def test_refusal_of_curves_that_are_not_finite_at_the_start_or_do_not_use_their_parameters() -> None:
    x = np.arange(5.0)
    with pytest.raises(MetrologyError, match="start: got c = 10000"):
        regression.curve(Expression.parse("exp(c*x)"), x, x, start={"c": 1e4})
    for text in ("a*x", "a*x*b*q", "a*b"):
        with pytest.raises(MetrologyError, match="an expression of all parameters and of one more name"):
            regression.curve(Expression.parse(text), x, x, start={"a": 1.0, "b": 1.0})


LINE: Callable[..., Any] = regression.line


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (
            ([1, 2], [1, 2], {}),
            ["fit: got 2 points; expected at least 3 for 2 parameters. Fix: state the uncertainty"],
        ),
        (([1], [1], {"u_y": 0.1}), ["fit: got 1 points; expected at least 2"]),
        (([2, 2, 2], [1, 2, 3], {}), ["x: got 1 different value(s); expected at least 2"]),
        (([2, 2, 2], [1, 2, 3], {"u_x": 1, "u_y": 1}), ["x: got 1 different value(s)"]),
        (([1, 2, math.nan], [1, math.inf, 3], {}), ["x[2]: got nan", "y[1]: got inf"]),
        (([1, 2, 3], [1, 2, 3], {"u_y": [0.1, 0, -1]}), ["u_y[1]: got 0;", "u_y[2]: got -1;"]),
        (([1, 2, 3], [1, 2, 3], {"u_x": [0.0, 0.1, 0.1], "u_y": 0.1}), ["u_x[0]: got 0;"]),
        (([1, 2, 3], [1, 2, 3, 4], {}), ["x: got 3 values; expected as many as y has, 4"]),
        (([1, 2, 3], [1, 2, 3], {"u_x": 0.1}), ["u_x: got uncertainties of x alone"]),
        (
            ([1, 2, 3], [1, 2, 3], {"u_x": 1, "u_y": 1, "correlation": [0, 1, math.nan]}),
            ["correlation[1]", "correlation[2]"],
        ),
        (([1, 2, 3], [1, 2, 3], {"covariance": np.ones((3, 3))}), ["covariance: got a singular matrix"]),
        (([1, 2, 3], [1, 2, 3], {"covariance": np.eye(4)}), ["covariance: got the shape (4, 4)"]),
        (([1, 2, 3], [1, 2, 3], {"covariance": -np.eye(3)}), ["a variance not above zero"]),
        (([1, 2, 3], [1, 2, 3], {"covariance": np.eye(3) + np.eye(3, k=1) / 4}), ["a matrix that is not symmetric"]),
        (([1, 2, 3], [1, 2, 3], {"covariance": np.ones((6, 6))}), ["covariance: got a singular matrix"]),
    ],
)
def test_refusal_of_data_that_give_no_line(arguments: tuple[Any, Any, dict[str, Any]], parts: list[str]) -> None:
    x, y, options = arguments
    with pytest.raises(MetrologyError) as caught:
        LINE(x, y, **options)
    assert len(caught.value.faults) == len(parts)
    for part, fault in zip(parts, caught.value.faults, strict=True):
        assert part in str(fault)


def test_refusal_of_other_covariances_and_scales_than_a_fit_has() -> None:
    fit = regression.line(*WLS)
    with pytest.raises(MetrologyError, match="no stated uncertainties"):
        regression.scaled(fit)
    with pytest.raises(MetrologyError, match="as many parameters as points"):
        regression.scaled(regression.line([1, 2], [1, 2], u_y=1))
    with pytest.raises(MetrologyError, match="without errors in x"):
        regression.by_information(fit)


def test_limit_a_cloud_without_direction_still_gives_a_line_or_a_sentence() -> None:
    square = regression.line([0, 0, 1, 1], [0, 1, 0, 1], u_x=0.1, u_y=0.1)
    assert not square.converged
    assert "did not converge" in square.sentence
    assert np.all(np.isnan(square.covariance))
    flat = regression.line([0, 1, 2, 3], [1, 1, 1, 1], u_x=0.1, u_y=0.1)
    assert flat.values[1] == pytest.approx(0.0, abs=1e-12)
