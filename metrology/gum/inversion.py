"""The x of a new y: with its u, as an equation for the law and for draws, and Fieller's interval for a line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.fit import LINE, Regression, predict
from metrology.gum.inputs import Input
from metrology.gum.law import coverage_factor, effective_dof
from metrology.gum.rounding import readable
from metrology.message import said

_STEP = 1e-100
_MOST = 50
Curve = Callable[[Mapping[str, Any], Any], Any]


@dataclass(frozen=True)
class Inverse:
    """The x at which the curve takes a stated y; None with a sentence where there is no such, or no single one."""

    value: float | None
    u: float | None
    sentence: str = ""


def inverse(fit: Regression, y: float, *, u_y: float = 0.0, between: tuple[float, float] | None = None) -> Inverse:
    """The x at which the curve takes the value y, u²(x) = (u²(y) + gᵀ·V·g) / f′(x)².

    Parameters
    ----------
    fit : Regression
    y, u_y : float
        A new reading, with its standard uncertainty.
    between : tuple of float
        Where to look; the range of the data where None (a straight line needs no range).

    Notes
    -----
    ISO/TS 28037:2010, 11.1; its example has x = 4.913, u = 0.322 for y = 10.5, u = 0.5.
    """
    if not fit.converged:
        return Inverse(None, None, fit.sentence)
    x = _line_crossing(fit, y) if fit.model == LINE and between is None else _curve_crossing(fit, y, between)
    if isinstance(x, str):
        return Inverse(None, None, x)
    step = max(float(np.ptp(fit.x)), abs(x) * 1e-6) * 1e-5
    low, high = fit.basis.function(np.array([x - step, x + step]), fit.basis.values)
    slope = float(high - low) / (2 * step)
    if fit.model == LINE:
        slope = float(fit.values[1])
    if slope == 0:
        return Inverse(None, None, said("The curve is flat at x = {x:g}: y does not determine x there.", x=float(x)))
    u = sqrt(u_y**2 + float(predict(fit, x).u[0]) ** 2) / abs(slope)
    return Inverse(x, u)


def _line_crossing(fit: Regression, y: float) -> float | str:
    slope, u_slope = float(fit.values[1]), float(fit.u[1])
    if slope == 0 or 2 * u_slope > abs(slope):
        text = "The slope {slope:g} is not distinguished from zero (u = {u:g}): y does not determine x."
        return said(text, slope=slope, u=u_slope)
    centre = float(np.mean(fit.x))
    return centre + (y - float(predict(fit, centre).value[0])) / slope


def _curve_crossing(fit: Regression, y: float, between: tuple[float, float] | None) -> float | str:
    from scipy.optimize import brentq

    low, high = between or (float(np.min(fit.x)), float(np.max(fit.x)))
    grid = np.linspace(low, high, 201)
    gap = fit.basis.function(grid, fit.basis.values) - y
    changes = np.flatnonzero(np.sign(gap[:-1]) != np.sign(gap[1:]))
    if len(changes) == 0:
        text = "The curve does not take the value {y:g} between x = {low:g} and {high:g}."
        return said(text, y=float(y), low=float(low), high=float(high))
    if len(changes) > 1 and not np.any(gap == 0):
        text = "The curve takes the value {y:g} more than once between x = {low:g} and {high:g}: narrow the range."
        return said(text, y=float(y), low=float(low), high=float(high))

    def function(x: float) -> float:
        return float(fit.basis.function(np.array([x]), fit.basis.values)[0]) - y

    first = int(changes[0])
    return float(brentq(function, grid[first], grid[first + 1], xtol=abs(high - low) * 1e-15, rtol=1e-14))


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


def crossing(fit: Regression, y: float, where: str, units: tuple[str, str] = ("1", "1")) -> float:
    """The one x at which the curve takes `y` within the range of the data.

    Parameters
    ----------
    fit : Regression
        A fitted curve.
    y : float
        In the unit of its y.
    where : str
        What an error names.
    units : tuple of str
        SI units of x and y, for an error.

    Returns
    -------
    float
        In the unit of its x.

    Raises
    ------
    MetrologyError
        Where there is none, or more than one, or the curve is flat there.
    """
    low, high = float(np.min(fit.x)), float(np.max(fit.x))
    found = inverse(fit, y, between=(low, high))
    if found.value is None:
        ends = " to ".join(readable(end, units[0], 4) for end in (low, high))
        expected = f"a value that the curve takes once within the range of its data, x = {ends}"
        ways = {"more than once": "takes more than once", "is flat": "is flat at"}
        why = next((text for sign, text in ways.items() if sign in found.sentence), "does not take")
        got = f"y = {readable(y, units[1], 4)}, which the curve {why}"
        raise MetrologyError(Fault(where, got, expected, "state another one, or leave it out"))
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
