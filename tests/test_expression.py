"""The expression language: values, dimensions, derivatives, every refusal, and properties over random expressions."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from uncertainties import ufloat

from metrology.expression import RESERVED, Expression, ExpressionError
from metrology.expression.elementary import FUNCTIONS
from metrology.units import Dimension, dimension

VALUES = {"k": 24734.25, "L": 2.99, "w": 0.025, "t": 5e-5, "n": 3.0, "α.x_1": 2.0}
DIMENSIONS = {"k": "N/m", "L": "m", "w": "m", "t": "m", "n": "1", "m": "kg", "T": "K", "F": "N"}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("k * L / (w * t)", 24734.25 * 2.99 / (0.025 * 5e-5)),
        ("-2**2", -4.0),
        ("2**-1", 0.5),
        ("2**3**2", 512.0),
        ("1 - 2 - 3", -4.0),
        ("8 / 4 / 2", 1.0),
        ("+1 - -1", 2.0),
        ("1.e0 + .5e1", 6.0),
        ("2*pi*e", 2 * math.pi * math.e),
        ("sqrt(16) + log10(1000) + log(exp(2))", 9.0),
        ("sin(pi/6) + cos(0) + tan(0)", 1.5),
        ("asin(1) + acos(1) + atan(0)", math.pi / 2),
        ("atan2(1, -1)", 3 * math.pi / 4),
        ("min(3, 1, 2) + max(n, 5) + abs(-n)", 9.0),
        ("α.x_1 * µ", 14.0),
    ],
)
def test_closed_form_arithmetic_follows_the_rules_of_mathematics(text: str, value: float) -> None:
    assert Expression.parse(text).evaluate({**VALUES, "μ": 7.0}) == pytest.approx(value, rel=1e-15)


def test_closed_form_names_are_those_of_quantities() -> None:
    assert Expression.parse("2*pi*k + sqrt(a.b) - e").names == {"k", "a.b"}
    assert {"pi", "e", "sqrt", "atan2"} <= RESERVED


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("k * L / (w * t)", "Pa"),
        ("sqrt(w * t)", "m"),
        ("L**(1/2) * L**0.5", "m"),
        ("(k / m)**(1/2)", "1/s"),
        ("exp(L / w) + n", "1"),
        ("max(L, 0) + min(w, t) - abs(-L)", "m"),
        ("atan2(L, w)", "1"),
        ("n**n", "1"),
        ("L * 2**(1 + 1)", "m"),
        ("(L * L)**0", "1"),
    ],
)
def test_closed_form_dimensions_follow_the_expression(text: str, unit: str) -> None:
    known = {name: dimension(of) for name, of in DIMENSIONS.items()}
    assert Expression.parse(text).dimension(known) == dimension(unit)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("k + L", "got a stiffness and a length in one sum at column 3; expected terms of one dimension"),
        ("max(L, F)", "got a length and a force in one 'max' at column 1"),
        ("exp(L)", "got exp of a length at column 1; expected exp of a number"),
        ("2 * sin(T)", "got sin of a temperature at column 5"),
        ("L**n", "got a length to a power that is a quantity at column 2"),
        ("n**L", "got a length as an exponent at column 2"),
        ("L**0.123456", "got a length to the power 0.123456 at column 2"),
        ("L**101", "got a length to the power 101 at column 2"),
        ("L**(1e308*10)", "got a length to the power inf at column 2"),
        ("atan2(L, F)", "got a length and a force in one 'atan2' at column 1"),
        ("q", "got 'q' in 'q' at column 1; expected the name of a quantity: F, L, T, k, m, n, t, w"),
    ],
)
def test_refusal_of_dimensions_that_do_not_fit(text: str, message: str) -> None:
    known = {name: dimension(of) for name, of in DIMENSIONS.items()}
    with pytest.raises(ExpressionError) as caught:
        Expression.parse(text).dimension(known)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("text", "column", "part"),
    [
        ("", 1, "a number, a name or '('"),
        ("k *", 4, "got the end"),
        ("(1 + 2", 7, "a ')' for the '(' at column 1"),
        ("1 + )", 5, "a number, a name or '('"),
        ("x^2", 2, "write a power as 'x**2'"),
        ("x²", 2, "write a power as 'x**2'"),
        ("a × b", 3, "write a product as 'a * b'"),
        ("y = 2", 3, "right of the equals sign"),
        ("1,5 * k", 2, "the decimal mark is a point"),
        ("k L", 3, "a '*' is missing"),
        ("al-1100.length", 9, "give the quantity a name without one under 'where:'"),
        ("foo(1)", 1, "a function, one of sqrt"),
        ("sqr(1)", 1, "did you mean 'sqrt'?"),
        ("sqrt", 1, "its argument, such as 'sqrt(x)'"),
        ("sin(1, 2)", 1, "1 argument(s), not 2"),
        ("max(1)", 1, "two or more argument(s), not 1"),
        ("atan2(1)", 1, "2 argument(s), not 1"),
        ("1e400", 1, "a number below 1e308"),
        ("k.__class__.__bases__[0]", 22, "arithmetic such as"),
        ("'a' + 1", 1, "arithmetic such as"),
        ("(" * 41 + "1" + ")" * 41, 41, "at most 40 levels"),
        ("-" * 41 + "1", 41, "at most 40 levels"),
        ("2**" * 41 + "1", 121, "at most 40 levels"),
    ],
)
def test_refusal_of_what_cannot_be_read_names_the_column(text: str, column: int, part: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        Expression.parse(text)
    assert caught.value.column == column
    assert part in str(caught.value)


def test_refusal_of_too_much_text_and_of_none() -> None:
    with pytest.raises(ExpressionError, match="at most 1000 characters"):
        Expression.parse("1+" * 500 + "1")
    with pytest.raises(ExpressionError, match="not a text"):
        Expression.parse(3)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("n / (n - 3)", "division by zero at column 3"),
        ("9**9**9", "a number beyond 1e308 at column 2"),
        ("exp(k)", "a number beyond 1e308 at column 1"),
        ("log(-n)", "log of -3 at column 1"),
        ("sqrt(-n)", "sqrt of -3 at column 1"),
        ("(-8)**(1/3)", "** of -8, 0.333333 at column 5"),
        ("1e308 * 10 * n", "inf from '1e308 * 10 * n'"),
        ("K * n", "the name of a quantity"),
    ],
)
def test_refusal_of_values_that_are_no_finite_number(text: str, part: str) -> None:
    uncertain = {name: ufloat(value, 0.1) for name, value in VALUES.items()}
    for values in (VALUES, uncertain) if "n" in text and "1e308" not in text and "exp" not in text else (VALUES,):
        with pytest.raises(ExpressionError) as caught:
            Expression.parse(text).evaluate(values)
        assert part.replace("-3", "-3") in str(caught.value)


def test_refusal_of_a_quantity_that_is_named_like_a_constant() -> None:
    with pytest.raises(ExpressionError, match="a constant and a quantity as well"):
        Expression.parse("2 * e").evaluate({"e": 1.0})
    assert Expression.parse("2 * k").evaluate({"e": 1.0, "k": 2.0}) == 4.0


def test_refusal_of_roots_of_negative_uncertain_numbers() -> None:
    with pytest.raises(ExpressionError, match=r"\*\* of -8"):
        Expression.parse("x**y").evaluate({"x": ufloat(-8, 0.1), "y": 1 / 3})
    with pytest.raises(ExpressionError, match=r"\*\* of -8"):
        Expression.parse("x**y").evaluate({"x": -8.0, "y": ufloat(2, 0.1)})
    assert Expression.parse("x**2").evaluate({"x": ufloat(-8, 0.1)}).n == 64.0


def test_limit_arrays_become_nan_where_the_function_is_not_defined() -> None:
    result = Expression.parse("sqrt(x) / (x - 4)").evaluate({"x": np.array([-1.0, 1.0, 4.0])})
    assert np.isnan(result[0])
    assert result[1] == pytest.approx(-1 / 3)
    assert np.isinf(result[2])


SMOOTH = "sqrt(x)*exp(-x) + log(x)/log10(x+2) + sin(x)*cos(x)*tan(x/5) + asin(x/9) + acos(x/9) + atan(x)"
KINKED = " + atan2(x, 2) + atan2(1, x) + abs(-x)**1.5 + abs(x) + min(x, 9)*max(x, 1)*max(9, x)*min(1, x)"


@pytest.mark.parametrize("x", [0.7, 2.5, 6.0])
def test_twice_derivatives_of_variables_and_of_complex_steps_agree_with_differences(x: float) -> None:
    expression = Expression.parse(SMOOTH + KINKED)
    variable = ufloat(x, 0.1)
    by_law = expression.evaluate({"x": variable}).derivatives[variable]
    by_step = expression.evaluate({"x": complex(x, 1e-100)}).imag / 1e-100
    on_array = np.imag(expression.evaluate({"x": np.array([x, 1.0]) + 1e-100j})[0]) / 1e-100
    h = 1e-5
    difference = (expression.evaluate({"x": x + h}) - expression.evaluate({"x": x - h})) / (2 * h)
    assert by_step == pytest.approx(by_law, rel=1e-13)
    assert on_array == pytest.approx(by_law, rel=1e-13)
    assert difference == pytest.approx(by_law, rel=1e-7)
    assert expression.evaluate({"x": np.array([x])})[0] == pytest.approx(expression.evaluate({"x": x}), rel=1e-15)
    assert expression.evaluate({"x": variable}).n == pytest.approx(expression.evaluate({"x": x}), rel=1e-15)


def test_twice_arrays_of_variables_are_taken_element_by_element() -> None:
    values = FUNCTIONS["sqrt"](np.array([ufloat(4, 0.1), ufloat(9, 0.1)], dtype=object))
    assert [value.n for value in values] == [2.0, 3.0]


Tree = tuple[str, Callable[[], float]]


def _binary(pair: tuple[Tree, str, Tree]) -> Tree:
    (left, f), sign, (right, g) = pair
    operations: dict[str, Callable[[float, float], float]] = {
        "+": lambda a, b: a + b,
        "-": lambda a, b: a - b,
        "*": lambda a, b: a * b,
        "/": lambda a, b: a / b,
    }
    return f"({left} {sign} {right})", lambda: operations[sign](f(), g())


numbers = st.floats(0, 1e6, allow_nan=False).map(lambda value: (repr(value), lambda: value))
trees: st.SearchStrategy[Tree] = st.recursive(
    numbers,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(_binary),
        inner.map(lambda tree: (f"-{tree[0]}", lambda: -tree[1]())),
        inner.map(lambda tree: (f"abs({tree[0]})", lambda: abs(tree[1]()))),
    ),
    max_leaves=12,
)


@given(trees)
def test_twice_random_expressions_have_the_value_of_a_tree_built_beside_them(tree: Tree) -> None:
    text, value = tree
    try:
        expected = value()
    except ZeroDivisionError:
        with pytest.raises(ExpressionError, match="division by zero"):
            Expression.parse(text).evaluate({})
        return
    assume(math.isfinite(expected))
    assert Expression.parse(text).evaluate({}) == expected


@given(st.one_of(st.text(max_size=60), st.text(alphabet="0123456789.eE+-*/(), xksqrtlogmin_^", max_size=200)))
def test_law_any_text_gives_a_finite_number_or_the_one_error(text: str) -> None:
    try:
        expression = Expression.parse(text)
        value = expression.evaluate(dict.fromkeys(expression.names, 2.0))
    except ExpressionError:
        return
    assert math.isfinite(value)


@given(st.text(alphabet="12.+-*/(),xab^ sqrt", max_size=100))
def test_law_dimensions_of_numbers_are_numbers_whenever_they_can_be_read(text: str) -> None:
    try:
        expression = Expression.parse(text)
        found = expression.dimension(dict.fromkeys(expression.names, Dimension()))
    except ExpressionError:
        return
    assert found.dimensionless
