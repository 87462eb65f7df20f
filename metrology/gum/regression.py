"""Calibration lines and curves through declared data, and what is made of them.

`line` is the straight line in all its kinds, `polynomial` and `curve` the rest. A `Regression` is used by `predict`,
`inverse` (the x of a new y) and `knowledge` (the parameters, with their covariance, as inputs of further models).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from metrology.gum.curve import curve
from metrology.gum.curve_both import curve_both
from metrology.gum.distance import line_both
from metrology.gum.fit import (
    Basis,
    Prediction,
    Regression,
    by_information,
    knowledge,
    predict,
    scaled,
)
from metrology.gum.inversion import Inverse, inverse
from metrology.gum.polynomial import polynomial

__all__ = [
    "Basis",
    "Inverse",
    "Prediction",
    "Regression",
    "by_information",
    "curve",
    "curve_both",
    "inverse",
    "knowledge",
    "line",
    "polynomial",
    "predict",
    "scaled",
]


def line(
    x: Any, y: Any, *, u_x: Any = None, u_y: Any = None, correlation: Any = None, covariance: Any = None
) -> Regression:
    """Straight line y = a + b·x.

    Ordinary least squares without uncertainties (s from the scatter, ν = n − 2); weighted with `u_y`; with correlated y
    by a `covariance` of shape (n, n); with errors in x and y by `u_x` and `u_y`, or a `covariance` of shape (2n, 2n) of
    x and y stacked.

    Parameters
    ----------
    x, y : array_like, shape (n,)
        Data, in any units; n ≥ 3 without stated uncertainties.
    u_x, u_y : array_like, shape (n,), or float
        Standard uncertainties.
    correlation : array_like, shape (n,), or float
        Correlation coefficients r(x_i, y_i), with `u_x` and `u_y`.
    covariance : array_like, shape (n, n) or (2n, 2n)
        Of y, or of x and y stacked.

    Returns
    -------
    Regression
        a and b with their covariance, residuals and χ².

    Raises
    ------
    MetrologyError
        With every fault of the data.

    Notes
    -----
    JCGM 100:2008 H.3; ISO/TS 28037:2010.

    Examples
    --------
    >>> fit = line([1, 2, 3, 4, 5, 6], [3.3, 5.6, 7.1, 9.3, 10.7, 12.1], u_y=0.5)
    >>> [round(float(v), 6) for v in (*fit.values, *fit.u)]
    [1.866667, 1.757143, 0.465475, 0.119523]
    """
    both = u_x is not None or (covariance is not None and np.shape(covariance) == (2 * np.size(y),) * 2)
    if both:
        return line_both(x, y, u_x=u_x, u_y=u_y, correlation=correlation, covariance=covariance)
    return polynomial(x, y, degree=1, u_y=u_y, covariance=covariance)
