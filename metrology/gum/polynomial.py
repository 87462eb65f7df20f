"""Lines and polynomials by linear least squares: ordinary, weighted, and with correlated y."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import comb, frexp, inf, sqrt
from typing import Any

import numpy as np

from metrology.gum.fit import LINE, Basis, Floats, Regression
from metrology.gum.points import checked, distinct, quality, representable, scattered, spread, whitening

_REFINEMENTS = 3


def polynomial(x: Any, y: Any, *, degree: int, u_y: Any = None, covariance: Any = None) -> Regression:
    """Polynomial y = b0 + b1·x + … by least squares, (y − f)ᵀ·V⁻¹·(y − f) → min.

    Solved in t = (x − centre) / width by Householder QR with iterative refinement, then expanded in exact arithmetic.

    Parameters
    ----------
    x, y : array_like, shape (n,)
    degree : int
        At least 1.
    u_y : array_like, shape (n,), or float
        Standard uncertainties of y; the covariance of the parameters then rests on them alone (ν infinite). Without any
        it comes from the scatter about the curve, s²·(XᵀX)⁻¹ with ν = n − p.
    covariance : array_like, shape (n, n)
        Of y, in place of `u_y`.

    Raises
    ------
    MetrologyError
        For points that are not finite, too few or at too few different x, uncertainties ≤ 0, a singular covariance, and
        for values so large or small that the variances of the parameters cannot be held.

    Notes
    -----
    JCGM 100:2008 H.3; ISO/TS 28037:2010 clauses 6 and 9; refinement after Å. Björck, BIT 7 (1967) 257.
    """
    u_y = spread(u_y, np.size(y))
    stated = {"u_y": u_y, "covariance": None if covariance is None else np.ones(np.shape(y))}
    points, values = checked(x, y, stated, parameters=degree + 1)
    distinct(points, degree + 1)
    frame = _Frame.of(points, degree)
    design, target = frame.powers(points.astype(np.longdouble)), values.astype(np.longdouble)
    if covariance is not None:
        whiten = whitening(covariance, len(values)).astype(np.longdouble)
        solution = _solve(whiten @ design, whiten @ target)
    else:
        weight = 1 / np.asarray(np.ones(len(values)) if u_y is None else u_y, dtype=np.longdouble)
        solution = _solve(design * weight[:, None], target * weight)
    residuals = np.asarray(target - design @ solution.coefficients, dtype=float)
    return _result(frame, solution, (points, values, residuals), stated=u_y is not None or covariance is not None)


@dataclass(frozen=True)
class _Frame:
    """Scaling t = (x − centre) / width, with |t| ≤ 1 and a width that is a power of two."""

    centre: float
    width: float
    degree: int

    @classmethod
    def of(cls, x: Floats, degree: int) -> _Frame:
        low, high = float(np.min(x)), float(np.max(x))
        return cls(low / 2 + high / 2, 2.0 ** frexp(high / 2 - low / 2)[1], degree)

    def powers(self, x: Any) -> Any:
        """Columns 1, t, t², …, shape (n, degree + 1)."""
        t = (x - self.centre) / self.width
        return np.vander(t, self.degree + 1, increasing=True)

    def expand(self, columns: Any) -> Floats:
        """Coefficients of powers of x from those of powers of t, by exact binomial expansion, column by column."""
        c, h = Fraction(self.centre), Fraction(self.width)
        size = self.degree + 1
        table = [
            [comb(j, i) * (-c) ** (j - i) / h**j if j >= i else Fraction(0) for j in range(size)] for i in range(size)
        ]
        exact = [[Fraction(float(entry)) for entry in column] for column in np.asarray(columns, dtype=float).T]
        return np.array(
            [[float(sum(a * b for a, b in zip(row, column, strict=True))) for column in exact] for row in table]
        )


@dataclass(frozen=True)
class _Solution:
    """Coefficients, root of their covariance at unit weight (root·rootᵀ), and the weighted sum of squares."""

    coefficients: Any
    root: Floats
    total: float


def _solve(design: Any, target: Any) -> _Solution:
    """Least squares by QR, refined with residuals in extended precision."""
    scale = np.sqrt(np.sum(design.astype(float) ** 2, axis=0))
    scaled = design / scale
    orthogonal, triangle = np.linalg.qr(scaled.astype(float))
    solution, residual = np.zeros(design.shape[1], dtype=np.longdouble), np.zeros(len(target), dtype=np.longdouble)
    for _ in range(1 + _REFINEMENTS):
        first = target - residual - scaled @ solution
        second = -(scaled.T @ residual)
        from_second = np.linalg.solve(triangle.T, second.astype(float))
        step = np.linalg.solve(triangle, orthogonal.T @ first.astype(float) - from_second)
        correction = first - scaled @ step
        solution, residual = solution + step, residual + correction
    root = np.linalg.inv(triangle) / scale[:, None]
    return _Solution(solution / scale, root, float(np.sum((target - scaled @ solution) ** 2)))


def _result(frame: _Frame, solution: _Solution, data: tuple[Floats, Floats, Floats], *, stated: bool) -> Regression:
    x, y, residuals = data
    dof = len(x) - frame.degree - 1
    variance = 1.0 if stated else solution.total / dof
    with representable():
        root = solution.root * sqrt(variance)
        expanded, values = frame.expand(root), frame.expand(solution.coefficients[:, None])[:, 0]
        covariance, in_basis = expanded @ expanded.T, root @ root.T
    p_value, sentence = quality(solution.total, dof) if stated else (None, "")
    line = frame.degree == 1
    return Regression(
        model=LINE
        if line
        else "y = " + " + ".join(["b0", "b1·x", *(f"b{i}·x^{i}" for i in range(2, frame.degree + 1))]),
        names=("a", "b") if line else tuple(f"b{i}" for i in range(frame.degree + 1)),
        values=values,
        covariance=covariance,
        dof=inf if stated else float(dof),
        residual_dof=dof,
        s=None if stated else sqrt(variance),
        chi_squared=solution.total if stated else None,
        p_value=p_value,
        x=x,
        y=y,
        residuals=residuals,
        converged=True,
        sentence=sentence or scattered(variance, dof),
        basis=Basis(
            values=np.asarray(solution.coefficients, dtype=float),
            covariance=in_basis,
            function=lambda at, values: np.asarray(frame.powers(at) @ values),
            gradient=lambda at, values: np.asarray(frame.powers(at)),  # noqa: ARG005
        ),
    )
