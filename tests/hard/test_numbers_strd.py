"""Certified digits: the Statistical Reference Datasets of NIST for means, lines, polynomials, curves.

Certified lag-1 autocorrelations have no counterpart here: nothing in the package gives that coefficient. Longley, with
six regressors, goes through `curve`, which takes any function of the row.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import certified
import numpy as np
import pytest
import strd
import strd_long
from certified import numbers

from metrology.expression import Expression
from metrology.gum import mean, regression, standard_deviation

NONLINEAR = {**certified.NONLINEAR, **strd.NONLINEAR, **strd_long.NONLINEAR}


def digits(got: Any, certified_values: Sequence[str]) -> float:
    """Least number of digits to which values agree with certified ones: the log relative error."""
    expected = np.array([float(value) for value in certified_values])
    return -math.log10(max(float(np.max(np.abs(np.asarray(got) - expected) / np.abs(expected))), 1e-16))


def names(count: int) -> list[str]:
    return [f"b{i}" for i in range(1, count + 1)]


@pytest.mark.parametrize("name", strd.UNIVARIATE)
def test_reference_univariate(name: str) -> None:
    readings, certified_mean, deviation = strd.UNIVARIATE[name]
    assert digits(mean(readings), [certified_mean]) > 14
    assert digits(standard_deviation(readings), [deviation]) > 13


def test_reference_pontius() -> None:
    fit = regression.polynomial(strd.PONTIUS_X, numbers(strd.PONTIUS_Y), degree=2)
    assert digits(fit.values, [value for value, _ in strd.PONTIUS]) > 12
    assert digits(fit.u, [u for _, u in strd.PONTIUS]) > 12
    assert digits(fit.s, ["0.205177424076185E-03"]) > 12


@pytest.mark.parametrize("name", strd.NO_INTERCEPT)
def test_reference_line_through_the_origin(name: str) -> None:
    x, y, slope, u, s = strd.NO_INTERCEPT[name]
    fit = regression.curve(Expression.parse("b*x"), x, y, start={"b": 1.0})
    assert digits([fit.values[0], fit.u[0], fit.s], [slope, u, s]) > 14


def test_reference_longley() -> None:
    rows = np.array(numbers(strd.LONGLEY_ROWS)).reshape(16, 7)
    columns = np.column_stack([np.ones(16), rows[:, 1:]]).T
    fit = regression.curve(
        lambda _, p: sum(p[name] * column for name, column in zip(names(7), columns, strict=True)),
        np.arange(16.0),
        rows[:, 0],
        start=dict.fromkeys(names(7), 0.0),
    )
    assert digits(fit.values, [value for value, _ in strd.LONGLEY]) > 10
    assert digits(fit.u, [u for _, u in strd.LONGLEY]) > 10
    assert digits(fit.s, ["304.854073561965"]) > 10


@pytest.mark.parametrize("start", [0, 1])
@pytest.mark.parametrize("name", [*strd.NONLINEAR, *strd_long.NONLINEAR])
def test_reference_curve_from_both_starts(name: str, start: int) -> None:
    model, x, y, starts, values, deviations, s = NONLINEAR[name]
    begin = dict(zip(names(len(starts[start])), starts[start], strict=True))
    fit = regression.curve(Expression.parse(model), numbers(x), numbers(y), start=begin)
    assert fit.converged
    assert digits(fit.values, values.split()) > 9
    assert digits(fit.u, deviations.split()) > 9
    assert digits(fit.s, [s]) > 9
