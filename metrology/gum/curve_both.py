"""A stated function fitted to points that are uncertain in x and y (generalised distance regression)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.expression import Expression
from metrology.gum.curve import Function, curve
from metrology.gum.curve_draws import STEP, CurveEstimator
from metrology.gum.fit import Basis, Floats, Regression
from metrology.gum.points import checked, quality, representable, spread
from metrology.gum.refit import Local, Refit
from metrology.message import said

_INNER = 60
"""Trials of a true x: a few steps, each halved some ten times where the curve turns within u(x)."""
_ROUNDING = 1e-12
_NEAR = 1e-7
"""Step of a true x, in its standard uncertainty, that moves the sum of squares by less than rounding."""
_SMALL = 1e-4


def curve_both(
    model: Expression | Function, x: Any, y: Any, *, start: Mapping[str, float], u_x: Any, u_y: Any
) -> Regression:
    """Function y = f(x; parameters) with errors in x and y, Σ (x_i − ξ_i)²/u²(x_i) + (y_i − f(ξ_i))²/u²(y_i) → min.

    The true ξ_i are found for each trial of the parameters. The covariance is that of propagation through the
    estimator; `information` is that which neglects the residuals, as ISO/TS 28037 has it for lines.

    Parameters
    ----------
    model : Expression or callable
        As in `metrology.gum.curve.curve`.
    x, y : array_like, shape (n,)
        Data, in any units.
    start : mapping of str to float
        Names of the parameters, in order, with values to begin from.
    u_x, u_y : array_like, shape (n,), or float
        Standard uncertainties; the points are independent.

    Returns
    -------
    Regression
        Parameters in the order of `start` with their covariance, residuals and χ².

    Raises
    ------
    MetrologyError
        As in `curve`, and for uncertainties of x alone.

    Notes
    -----
    P. T. Boggs, R. H. Byrd, R. B. Schnabel, SIAM J. Sci. Stat. Comput. 8 (1987) 1052; JCGM 100:2008 5.2.
    """
    if u_y is None:
        fix = "state 'u_y', or exchange 'x' and 'y'"
        raise MetrologyError(Fault("u_x", "uncertainties of x alone", "'u_y' as well", fix))
    n = np.size(y)
    given = {"u_x": spread(u_x, n), "u_y": spread(u_y, n)}
    points, values = checked(x, y, given, parameters=len(start))
    sizes = (np.asarray(given["u_x"], dtype=float), np.asarray(given["u_y"], dtype=float))
    first = curve(model, points, values, start=start, u_y=sizes[1])
    if first.refit is None:
        return first
    plain = first.refit.estimator
    assert isinstance(plain, CurveEstimator)
    estimator = BothEstimator(plain.function, plain.x, plain.whiten, plain.best, plain.root, _SMALL, *sizes)
    return _result(first, estimator, np.concatenate([points, values]))


@dataclass(frozen=True)
class BothEstimator(CurveEstimator):
    """Sum of squares over the true ξ, which are found for each draw of x and y stacked, shape (2n, m)."""

    u_x: Floats
    u_y: Floats

    def nearest(self, theta: Floats, drawn: Floats) -> tuple[Floats, Floats, Floats]:
        """True ξ of each point, f there and its slope by x; NaN where no ξ was found.

        Steps of Newton from the point itself, of Gauss and Newton where the sum of squares curves downwards: each a
        direction of descent, and halved until the sum falls.
        """
        rows = list(self.best[:, None] + self.root @ theta)
        x, y = np.split(drawn, 2)
        wx, wy = self.u_x[:, None] ** -2, self.u_y[:, None] ** -2
        small = _SMALL * self.u_x[:, None]
        xi, share = x, np.ones_like(x)
        f, slope = self._both(rows, xi)
        total = wy * (y - f) ** 2
        for _ in range(_INNER):
            bend = (self._both(rows, xi + small)[1] - slope) / small
            plain = wx + wy * slope**2
            whole = plain - wy * (y - f) * bend
            step = (wx * (x - xi) + wy * slope * (y - f)) / np.where(whole > 0, whole, plain)
            near = np.abs(step) < _NEAR * self.u_x[:, None]
            if near.all():
                break
            trial = xi + share * step
            g, steeper = self._both(rows, trial)
            there = wx * (x - trial) ** 2 + wy * (y - g) ** 2
            better = there <= total * (1 + _ROUNDING)
            xi, f, slope = np.where(better, trial, xi), np.where(better, g, f), np.where(better, steeper, slope)
            total, share = np.where(better, there, total), np.where(better, 1.0, share / 2)
        return np.where(near, xi, np.nan), f, slope

    def _both(self, rows: list[Any], xi: Floats) -> tuple[Floats, Floats]:
        moved = np.broadcast_to(self.function(xi + 1j * STEP, rows), xi.shape)
        return np.broadcast_to(self.function(xi, rows), xi.shape), np.imag(moved) / STEP

    def _plain(self, theta: Floats, drawn: Floats) -> tuple[Floats, Floats, Floats]:
        rows = list(self.best[:, None] + self.root @ theta)
        x, y = np.split(drawn, 2)
        xi, f, slope = self.nearest(theta, drawn)
        wx, wy = self.u_x[:, None] ** -2, self.u_y[:, None] ** -2
        by_parameter = []
        for index in range(len(rows)):
            moved = [row + 1j * STEP if place == index else row for place, row in enumerate(rows)]
            by_parameter.append(np.imag(np.broadcast_to(self.function(xi, moved), xi.shape)) / STEP)
        jacobian = np.tensordot(self.root.T, np.array(by_parameter), 1)
        weight = 1 / (self.u_y[:, None] ** 2 + (slope * self.u_x[:, None]) ** 2)
        curvature = np.einsum("inm,nm,jnm->mij", jacobian, weight, jacobian, optimize=True)
        descent = np.einsum("inm,nm->im", jacobian, wy * (y - f))
        total = (wx * (x - xi) ** 2 + wy * (y - f) ** 2).sum(axis=0)
        return np.asarray(total), descent, curvature


def _result(first: Regression, estimator: BothEstimator, data: Floats) -> Regression:
    """Fit by the search that fits draws, begun from the fit without errors in x, to rounding."""
    size = len(first.values)
    root = np.concatenate([estimator.u_x, estimator.u_y])
    search = Refit(estimator, data, data, root, np.zeros(size), np.ones(size), estimator.root)
    phi = search.fit(data[:, None])
    here = estimator.at(phi, data[:, None], full=True)
    moved = float(np.max(np.abs(np.linalg.solve(here.curvature[0], here.descent[:, 0]))))
    theta = estimator.best + estimator.root @ phi[:, 0]
    if not moved < _SMALL:
        failure = said("The fit did not converge. Begin from other values, or plot the curve at the start.")
        empty = np.full((size, size), np.nan)
        basis = replace(first.basis, covariance=empty)
        return replace(
            first, converged=False, sentence=failure, covariance=empty, p_value=None, basis=basis, refit=None
        )
    with representable():
        by_data = _by_data(estimator, phi, data, here)
        covariance = estimator.root @ ((by_data * root**2) @ by_data.T) @ estimator.root.T
        plain = estimator.at(phi, data[:, None]).curvature[0]
        information = estimator.root @ np.linalg.inv(plain) @ estimator.root.T
    return _regression(first, search, (theta, covariance, information), phi, float(here.total[0]))


def _by_data(estimator: BothEstimator, phi: Floats, data: Floats, here: Local) -> Floats:
    """Derivatives of φ by every x and y, −(∂h/∂φ)⁻¹·∂h/∂(x, y), with differences of the descent h by the data."""
    count = len(data)
    small = _SMALL * np.diag(np.concatenate([estimator.u_x, estimator.u_y]))
    many = np.repeat(phi, count, axis=1)
    up = estimator.at(many, data[:, None] + small).descent
    down = estimator.at(many, data[:, None] - small).descent
    return np.asarray(np.linalg.solve(here.curvature[0], (up - down) / (2 * np.diag(small))))


def _regression(
    first: Regression, search: Refit, found: tuple[Floats, Floats, Floats], phi: Floats, total: float
) -> Regression:
    theta, covariance, information = found
    estimator = search.estimator
    assert isinstance(estimator, BothEstimator)
    xi, f, _ = estimator.nearest(phi, search.data[:, None])
    p_value, sentence = quality(total, first.residual_dof)
    x, y = np.split(search.data, 2)
    refit = replace(
        search,
        adjusted=np.concatenate([xi[:, 0], f[:, 0]]),
        best=phi[:, 0],
        units=np.sqrt(np.diag(np.linalg.solve(estimator.root, np.linalg.solve(estimator.root, covariance).T))),
    )
    basis = Basis(theta, covariance, first.basis.function, first.basis.gradient)
    return replace(
        first, values=theta, covariance=covariance, dof=inf, chi_squared=total, p_value=p_value, sentence=sentence,
        residuals=y - first.basis.function(x, theta), basis=basis, information=information, refit=refit,
    )  # fmt: skip
