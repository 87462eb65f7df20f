"""Functions of a measurement model, for floats, arrays of draws and `uncertainties` variables alike.

A model written with them serves both ways of propagation: the law (variables that carry derivatives) and Monte Carlo
(arrays). Outside its domain a function of floats or variables raises ValueError, one of arrays returns NaN for the
draws concerned.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np


def _apply(name: str, vector: Callable[..., Any], *arguments: Any) -> Any:
    """Call the `math`, NumPy or `uncertainties` version of a function, by what the arguments are."""
    if any(isinstance(argument, np.ndarray) for argument in arguments):
        return vector(*arguments)
    if all(isinstance(argument, int | float | np.number) for argument in arguments):
        return getattr(math, name)(*arguments)
    from uncertainties import umath

    return getattr(umath, name)(*arguments)


def _estimate(x: Any) -> float:
    """Estimate of a float or of an `uncertainties` variable."""
    return float(getattr(x, "nominal_value", x))


def sqrt(x: Any) -> Any:
    """Square root √x."""
    return _apply("sqrt", np.sqrt, x)


def exp(x: Any) -> Any:
    """Exponential eˣ."""
    return _apply("exp", np.exp, x)


def log(x: Any) -> Any:
    """Natural logarithm ln x."""
    return _apply("log", np.log, x)


def log10(x: Any) -> Any:
    """Decimal logarithm lg x."""
    return _apply("log10", np.log10, x)


def sin(x: Any) -> Any:
    """Sine of an angle in rad."""
    return _apply("sin", np.sin, x)


def cos(x: Any) -> Any:
    """Cosine of an angle in rad."""
    return _apply("cos", np.cos, x)


def tan(x: Any) -> Any:
    """Tangent of an angle in rad."""
    return _apply("tan", np.tan, x)


def asin(x: Any) -> Any:
    """Arcsine in rad, from −π/2 to π/2."""
    return _apply("asin", np.arcsin, x)


def acos(x: Any) -> Any:
    """Arccosine in rad, from 0 to π."""
    return _apply("acos", np.arccos, x)


def atan(x: Any) -> Any:
    """Arctangent in rad, from −π/2 to π/2."""
    return _apply("atan", np.arctan, x)


def atan2(y: Any, x: Any) -> Any:
    """Angle of the point (x, y) in rad, from −π to π."""
    return _apply("atan2", np.arctan2, y, x)


def absolute(x: Any) -> Any:
    """Absolute value |x|."""
    if isinstance(x, np.ndarray):
        return np.abs(x)
    return x if _estimate(x) >= 0 else -x


def minimum(x: Any, y: Any) -> Any:
    """The smaller of two quantities, draw by draw; of two variables the one with the smaller estimate."""
    if isinstance(x, np.ndarray) or isinstance(y, np.ndarray):
        return np.minimum(x, y)
    return x if _estimate(x) <= _estimate(y) else y


def maximum(x: Any, y: Any) -> Any:
    """The larger of two quantities, draw by draw; of two variables the one with the larger estimate."""
    if isinstance(x, np.ndarray) or isinstance(y, np.ndarray):
        return np.maximum(x, y)
    return x if _estimate(x) >= _estimate(y) else y


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": sqrt,
    "exp": exp,
    "log": log,
    "log10": log10,
    "sin": sin,
    "cos": cos,
    "tan": tan,
    "asin": asin,
    "acos": acos,
    "atan": atan,
    "atan2": atan2,
    "abs": absolute,
    "min": minimum,
    "max": maximum,
}
"""Every function by the name it has in an expression."""
