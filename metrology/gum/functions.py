"""Functions of a measurement model, for floats, arrays of draws and `uncertainties` variables alike.

A model written with them serves both ways of propagation: the law (variables that carry derivatives) and Monte Carlo
(arrays). They are those of the expression language, so that a model means the same in code and in a campaign file.
"""

from metrology.expression.elementary import (
    FUNCTIONS,
    absolute,
    acos,
    asin,
    atan,
    atan2,
    cos,
    exp,
    log,
    log10,
    maximum,
    minimum,
    sin,
    sqrt,
    tan,
)

__all__ = [
    "FUNCTIONS",
    "absolute",
    "acos",
    "asin",
    "atan",
    "atan2",
    "cos",
    "exp",
    "log",
    "log10",
    "maximum",
    "minimum",
    "sin",
    "sqrt",
    "tan",
]
