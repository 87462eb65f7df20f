"""The variables of the law against those of the library `uncertainties`, whose operators they shorten."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import pytest
import uncertainties
from uncertainties import ufloat

from metrology.gum import functions
from metrology.gum.variable import Variable

CALCULATIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "sum": lambda x, y, _: x + y,
    "difference": lambda x, y, _: x - y,
    "product": lambda x, y, _: x * y,
    "quotient": lambda x, y, _: x / y,
    "with itself": lambda x, _, zero: x * x / x + x - x - zero,
    "with numbers": lambda x, y, _: 2 * (1 - x) / 3 + (y + 4) * 5 - 6 / y,
    "with other operators": lambda x, y, _: -(x**2) * y + x**y * (y - x),
    "with functions": lambda x, y, zero: functions.sqrt(x * y) / functions.atan2(y + zero, x),
    "with a variable of the library": lambda x, y, _: x * ufloat(3.0, 0.1) - ufloat(1, 1) / y,
}


@pytest.mark.parametrize("name", CALCULATIONS)
def test_value_and_derivatives_are_those_of_the_library_to_the_last_digit(name: str) -> None:
    inputs = {"x": 1.7, "y": 0.3, "zero": 0.0}
    found, expected = (
        CALCULATIONS[name](*(kind(value, tag) for tag, value in inputs.items()))
        for kind in (Variable, lambda value, tag: uncertainties.Variable(value, 1.0, tag))
    )
    assert found.nominal_value == expected.nominal_value
    assert [(one.tag, slope) for one, slope in found.derivatives.items()] == [
        (one.tag, slope) for one, slope in expected.derivatives.items()
    ]


def test_comparisons_are_those_of_the_library() -> None:
    x, y, zero = Variable(1.7, "x"), Variable(1.7, "y"), Variable(0.0, "zero")
    assert x == x
    assert x != y  # equal values of two inputs are no equal inputs
    assert x != 1.7
    assert x + y == y + x
    assert zero
    assert not x - x


@pytest.mark.parametrize("divisor", [0.0, Variable(0.0, "zero")])
def test_refusal_of_a_quotient_by_zero(divisor: Any) -> None:
    with pytest.raises(ZeroDivisionError, match="float division by zero"):
        operator.truediv(Variable(1.0, "x"), divisor)


def test_refusal_of_what_is_no_number() -> None:
    with pytest.raises(TypeError, match="unsupported operand"):
        Variable(1.0, "x") + "1"
