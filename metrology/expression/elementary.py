"""Elementary functions that serve floats, complex numbers, arrays, and variables of `uncertainties` alike.

Floats raise where the function is not defined, arrays yield nan there. Complex arguments carry a derivative in their
imaginary part (complex-step differentiation): ``abs``, ``min``, ``max`` and ``atan2`` are continued so that
they stay differentiable.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np

Function = Callable[..., Any]


def _uncertain(*values: Any) -> bool:
    return any(hasattr(value, "nominal_value") for value in values)


def _nominal(value: Any) -> Any:
    return getattr(value, "nominal_value", value)


def _arrays(*values: Any) -> bool:
    return any(isinstance(value, np.ndarray | np.generic | complex) for value in values)


def _complex(*values: Any) -> bool:
    return any(isinstance(value, complex) or getattr(value, "dtype", None) == np.complex128 for value in values)


def _unary(name: str, ufunc: np.ufunc) -> Function:
    scalar = getattr(math, name)

    def function(x: Any) -> Any:
        if isinstance(x, np.ndarray) and x.dtype == object:
            return np.frompyfunc(function, 1, 1)(x)
        if _arrays(x):
            return ufunc(x)
        if _uncertain(x):
            from uncertainties import umath

            return getattr(umath, name)(x)
        return scalar(x)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = f"{name} of a float, an array, or an uncertain variable."
    return function


sqrt = _unary("sqrt", np.sqrt)
exp = _unary("exp", np.exp)
log = _unary("log", np.log)
log10 = _unary("log10", np.log10)
sin = _unary("sin", np.sin)
cos = _unary("cos", np.cos)
tan = _unary("tan", np.tan)
asin = _unary("asin", np.arcsin)
acos = _unary("acos", np.arccos)
atan = _unary("atan", np.arctan)


def absolute(x: Any) -> Any:
    """|x|; of a complex number ±x by the sign of its real part."""
    if _complex(x):
        return np.where(np.real(x) < 0, -x, x)[()]
    if _uncertain(x):
        return x if _nominal(x) >= 0 else -x
    return abs(x)


def atan2(y: Any, x: Any) -> Any:
    """Angle of the point (x, y), in rad."""
    if _complex(y, x):
        yr, xr = np.real(y), np.real(x)
        slope = (xr * np.imag(y) - yr * np.imag(x)) / (xr**2 + yr**2)
        return np.arctan2(yr, xr) + 1j * slope
    if _arrays(y, x):
        return np.arctan2(y, x)
    if _uncertain(y, x):
        from uncertainties import umath

        return umath.atan2(y, x)
    return math.atan2(y, x)


def minimum(*values: Any) -> Any:
    """Least of the values; of uncertain variables the one whose estimate is least."""
    return reduce(lambda a, b: _choice(a, b, sign=1), values)


def maximum(*values: Any) -> Any:
    """Greatest of the values; of uncertain variables the one whose estimate is greatest."""
    return reduce(lambda a, b: _choice(a, b, sign=-1), values)


def _choice(a: Any, b: Any, *, sign: int) -> Any:
    if _complex(a, b):
        return np.where(sign * np.real(a) <= sign * np.real(b), a, b)[()]
    if _arrays(a, b):
        return np.minimum(a, b) if sign > 0 else np.maximum(a, b)
    return a if sign * _nominal(a) <= sign * _nominal(b) else b


def power(base: Any, exponent: Any) -> Any:
    """``base ** exponent`` in real numbers.

    Raises
    ------
    ValueError
        For a negative base with an exponent that is not a whole number, or that is uncertain.
    """
    if _arrays(base, exponent):
        return np.power(base, exponent)
    if _uncertain(base, exponent):
        whole = not _uncertain(exponent) and float(exponent).is_integer()
        if _nominal(base) < 0 and not whole:
            raise ValueError("power of a negative number")
        return base**exponent
    return math.pow(base, exponent)


#: The functions of the expression language, by the name that is written.
FUNCTIONS: dict[str, Function] = {
    **{function.__name__: function for function in (sqrt, exp, log, log10, sin, cos, tan, asin, acos, atan, atan2)},
    "abs": absolute,
    "min": minimum,
    "max": maximum,
}
