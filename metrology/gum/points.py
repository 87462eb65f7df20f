"""Points that a line or a curve is to be fitted to: what they must fulfil, and how well a fit meets them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite, sqrt
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.inputs import Floats
from metrology.message import said

REFUTED = 0.05
"""p-value of χ² below which points refute their stated uncertainties (ISO/TS 28037:2010, 6: 95 % quantile of χ²)."""


def quality(chi_squared: float, dof: int) -> tuple[float | None, str]:
    """Probability of χ² to be exceeded by chance, and what follows from it in words."""
    if dof < 1:
        return None, said("As many parameters as points: nothing is left to test the fit.")
    from scipy.special import gammaincc

    p = float(gammaincc(dof / 2, chi_squared / 2))
    text = (
        "χ² = {chi_squared:.4g} for {dof} degrees of freedom (p = {p:.2g}): the stated uncertainties account for the "
        "scatter."
    )
    if p < REFUTED:
        text = (
            "χ² = {chi_squared:.4g} for {dof} degrees of freedom (p = {p:.2g}): the points scatter more than their "
            "stated uncertainties allow; find the cause or enlarge them."
        )
    return p, said(text, chi_squared=float(chi_squared), dof=int(dof), p=p)


def scattered(variance: float, dof: int) -> str:
    """What is said of points without stated uncertainties."""
    text = "The points scatter about the curve with s = {s:.3g}, {dof} degrees of freedom."
    return said(text, s=sqrt(variance), dof=int(dof))


def checked(x: Any, y: Any, u: dict[str, Any], *, parameters: int) -> tuple[Floats, Floats]:
    """Data as arrays, after every check that any fit needs; all faults at once."""
    columns = {name: np.asarray(data, dtype=float) for name, data in {"x": x, "y": y, **u}.items() if data is not None}
    n, faults = columns["y"].size, []
    for name, column in columns.items():
        if column.shape != (n,):
            faults.append(Fault(name, f"{column.size} values", f"as many as y has, {n}"))
        faults += [
            Fault(f"{name}[{i}]", f"{column.flat[i]}", "a finite number")
            for i in np.flatnonzero(~np.isfinite(column))[:5]
        ]
        if name in u:
            bad = np.flatnonzero(column <= 0)[:5]
            faults += [
                Fault(f"{name}[{i}]", f"{column.flat[i]:g}", "a standard uncertainty greater than zero") for i in bad
            ]
    needed = parameters if any(data is not None for data in u.values()) else parameters + 1
    if n < needed:
        fix = "" if n < parameters else "state the uncertainty of the points, or take more of them"
        faults.append(Fault("fit", f"{n} points", f"at least {needed} for {parameters} parameters", fix))
    if faults:
        raise MetrologyError(*faults)
    return columns["x"], columns["y"]


def spread(u: Any, n: int) -> Any:
    """One uncertainty for all points as one for each."""
    return np.full(n, u, dtype=float) if u is not None and np.ndim(u) == 0 else u


def distinct(x: Floats, needed: int) -> None:
    """Refuse data that stand at too few different x."""
    if (found := len(np.unique(x))) < needed:
        raise MetrologyError(Fault("x", f"{found} different value(s)", f"at least {needed} different values"))


def whitening(covariance: Any, n: int) -> Floats:
    """Inverse of the Cholesky factor of a covariance matrix; refuses what is none."""
    matrix = np.asarray(covariance, dtype=float)
    where, expected = "covariance", "a symmetric positive definite matrix"
    if matrix.shape != (n, n):
        raise MetrologyError(Fault(where, f"the shape {matrix.shape}", f"the shape {(n, n)}"))
    diagonal = np.diag(matrix)
    if not (np.all(np.isfinite(matrix)) and np.all(diagonal > 0)):
        raise MetrologyError(Fault(where, "an entry that is not finite, or a variance not above zero", expected))
    scale = np.sqrt(diagonal)
    correlation = matrix / np.outer(scale, scale)
    if not np.allclose(correlation, correlation.T, rtol=0, atol=1e-9):
        raise MetrologyError(Fault(where, "a matrix that is not symmetric", expected))
    least = float(np.linalg.eigvalsh(correlation)[0])
    if least < 1e-13 * n or not isfinite(least):
        got = f"a singular matrix (least eigenvalue of the correlation {least:.2g})"
        raise MetrologyError(Fault(where, got, expected, "drop one of two points that carry the same information"))
    factor = np.linalg.cholesky((correlation + correlation.T) / 2)
    return np.asarray(np.linalg.inv(factor) / scale)


@contextmanager
def representable() -> Iterator[None]:
    """Refuse a fit whose parameters or their variances overflow, or vanish below the smallest number."""
    try:
        with np.errstate(over="raise", under="raise"):
            yield
    except (FloatingPointError, OverflowError) as error:
        got = f"points so large or so small that a parameter or its variance cannot be held ({error})"
        expected = "values for which squares of the parameters lie between 1e-300 and 1e300"
        raise MetrologyError(Fault("fit", got, expected, "use units in which the values are nearer to one")) from error
