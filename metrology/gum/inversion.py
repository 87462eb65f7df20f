"""The x of a new y: as an equation for the law and for draws, and the interval of Fieller for a straight line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.fit import Regression, inverse
from metrology.gum.inputs import Input
from metrology.gum.law import coverage_factor, effective_dof

_STEP = 1e-100
_MOST = 50
Curve = Callable[[Mapping[str, Any], Any], Any]


def equation(
    curve: Curve, key: str, members: Sequence[str], x0: float, span: float
) -> Callable[[Mapping[str, Any]], Any]:
    """The x at which a curve of the parameters `members` takes the value of the quantity `key`, near `x0`.

    For uncertain variables one step from x0, which has the exact derivatives; for draws Newton's steps to the end, none
    longer than the `span` of the data, and nan where the drawn curve does not take the drawn value.

    Parameters
    ----------
    curve : callable
        ``curve(namespace, x)``.
    key : str
        Name of the quantity whose value the curve is to take.
    members : sequence of str
        Names of the parameters of the curve.
    x0 : float
        The x at the estimates.
    span : float
        Range of the x of the data, in its unit.

    Returns
    -------
    callable
        Takes a namespace of uncertain variables or of draws, shape (n,), and returns x in the same kind.
    """

    def solve(namespace: Mapping[str, Any]) -> Any:
        gap = curve(namespace, x0) - namespace[key]
        if not isinstance(gap, np.ndarray):
            nominal = {name: getattr(namespace[name], "nominal_value", namespace[name]) for name in members}
            return x0 - gap / float(np.imag(curve(nominal, complex(x0, _STEP)) / _STEP))
        x = np.full(gap.shape, x0)
        for _ in range(_MOST):
            step = (curve(namespace, x) - namespace[key]) / (np.imag(curve(namespace, x + 1j * _STEP)) / _STEP)
            x = x - np.clip(step, -span, span)
            if not np.any(np.abs(step) > 1e-9 * span):
                return x
        return np.where(np.abs(step) > 1e-9 * span, np.nan, x)

    return solve


def crossing(fit: Regression, y: float, where: str) -> float:
    """The one x at which the curve takes `y` within the range of the data.

    Parameters
    ----------
    fit : Regression
        A fitted curve.
    y : float
        In the unit of its y.
    where : str
        What an error names.

    Returns
    -------
    float
        In the unit of its x.

    Raises
    ------
    MetrologyError
        Where there is none, or more than one, or the curve is flat there.
    """
    found = inverse(fit, y, between=(float(np.min(fit.x)), float(np.max(fit.x))))
    if found.value is None:
        expected = "a value that the curve takes once within the range of its data"
        raise MetrologyError(Fault(where, f"y = {y:g}", expected, found.sentence))
    return found.value


def fieller(fit: Regression, y: Input, probability: float) -> tuple[float, float] | None:
    """Interval of all x at which the line does not differ from y: (a + b·x − y)² ≤ t²·(u²(a + b·x) + u²(y)).

    None where the slope is not significant, |b| ≤ t·u(b): the interval has no end.

    Parameters
    ----------
    fit : Regression
        A straight line a + b·x.
    y : Input
        The value with its u, independent of the line.
    probability : float
        Coverage probability.

    Returns
    -------
    tuple of float, or None
        Both ends, in the unit of x.

    Notes
    -----
    E. C. Fieller, J. R. Stat. Soc. B 16 (1954) 175.
    """
    a, b = (float(value) for value in fit.values)
    t = coverage_factor(probability, _dof(fit, y))
    v = fit.covariance
    square = b * b - t * t * float(v[1, 1])
    if square <= 0:
        return None
    half = b * (a - y.value) - t * t * float(v[0, 1])
    rest = (a - y.value) ** 2 - t * t * (float(v[0, 0]) + y.u**2)
    root = sqrt(max(half * half - square * rest, 0.0))
    return (-half - root) / square, (-half + root) / square


def _dof(fit: Regression, y: Input) -> float:
    """Effective degrees of freedom of the gap between line and y at the crossing (JCGM 100 G.4.1)."""
    at = np.array([1.0, (y.value - float(fit.values[0])) / float(fit.values[1])]) if fit.values[1] else np.eye(2)[0]
    return effective_dof([(float(at @ fit.covariance @ at), fit.dof), *((one.u**2, one.dof) for one in y.components)])
