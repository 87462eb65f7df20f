"""A stated function fitted to data by nonlinear least squares."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf, isfinite, sqrt
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.expression import Expression
from metrology.gum.curve_draws import STEP, CurveEstimator
from metrology.gum.fit import Basis, Floats, Regression
from metrology.gum.points import checked, quality, representable, scattered, spread, whitening
from metrology.gum.refit import Refit
from metrology.message import said

_DEPENDENT = 1e12
Function = Callable[[Any, Mapping[str, Any]], Any]


def curve(
    model: Expression | Function, x: Any, y: Any, *, start: Mapping[str, float], u_y: Any = None, covariance: Any = None
) -> Regression:
    """Function y = f(x; parameters) by least squares, (y − f)ᵀ·V⁻¹·(y − f) → min.

    Levenberg and Marquardt's way first (MINPACK), then undamped Gauss–Newton steps by QR until they vanish.
    Derivatives are exact, by complex steps.

    Parameters
    ----------
    model : Expression or callable
        An expression of the parameters and of one more name, the x; or ``function(x, parameters)`` made of arithmetic
        and of functions that take complex arrays.
    x, y : array_like, shape (n,)
        Data, in any units.
    start : mapping of str to float
        Names of the parameters, in order, with values to begin from.
    u_y : array_like, shape (n,), or float
        Standard uncertainties of y; as in `polynomial`.
    covariance : array_like, shape (n, n)
        Of y, in place of `u_y`.

    Returns
    -------
    Regression
        Parameters in the order of `start` with their covariance, residuals and χ².

    Raises
    ------
    MetrologyError
        For data as in `polynomial`, and for a function that is not finite at the start.

    Notes
    -----
    A fit that does not settle is returned with ``converged`` false, a covariance of nan, and a sentence.
    """
    u_y = spread(u_y, np.size(y))
    stated = {"u_y": u_y, "covariance": None if covariance is None else np.ones(np.shape(y))}
    points, values = checked(x, y, stated, parameters=len(start))
    function = _function(model, tuple(start))
    whiten: Floats = np.ones(len(values)) if u_y is None else 1 / np.asarray(u_y, dtype=float)
    if covariance is not None:
        whiten = whitening(covariance, len(values))
    problem = _Problem(function, points, values, whiten)
    begin = np.array([float(value) for value in start.values()])
    problem.require_finite(begin, tuple(start))
    theta, failure = problem.refine(problem.search(begin))
    text = model.text if isinstance(model, Expression) else getattr(model, "__name__", "f(x)")
    given = u_y is not None or covariance is not None
    return _result(problem, theta, tuple(start), (text, failure), stated=given)


def _function(model: Expression | Function, names: tuple[str, ...]) -> Callable[[Any, Any], Any]:
    if not isinstance(model, Expression):
        return lambda x, theta: model(x, dict(zip(names, theta, strict=True)))
    free = model.names - set(names)
    unused = [name for name in names if name not in model.names]
    if len(free) != 1 or unused:
        got = f"{model.text!r} with the parameters {', '.join(names)}"
        raise MetrologyError(Fault("model", got, "an expression of all parameters and of one more name, the x"))
    (variable,) = free
    return lambda x, theta: model.evaluate({variable: x, **dict(zip(names, theta, strict=True))})


@dataclass(frozen=True)
class _Problem:
    function: Callable[[Any, Any], Any]
    x: Floats
    y: Floats
    whiten: Floats

    def at(self, x: Floats, theta: Any) -> Any:
        """The function; nan where it is not defined for these parameters at all."""
        try:
            with np.errstate(all="ignore"):
                return np.broadcast_to(self.function(x, list(theta)), x.shape)
        except (ArithmeticError, ValueError):
            return np.full(x.shape, np.nan)

    def curve(self, x: Floats, theta: Any) -> Floats:
        return np.asarray(self.at(x, theta), dtype=float)

    def gradient(self, x: Floats, theta: Any) -> Floats:
        """Derivatives by the parameters, Im f(θ + i·h) / h."""
        steps = [[complex(value, STEP * (i == j)) for j, value in enumerate(theta)] for i in range(len(theta))]
        return np.column_stack([np.imag(self.at(x, moved)) / STEP for moved in steps])

    def weigh(self, column: Floats) -> Floats:
        if self.whiten.ndim == 2:
            return np.asarray(self.whiten @ column)
        return column * (self.whiten if column.ndim == 1 else self.whiten[:, None])

    def residuals(self, theta: Any) -> Floats:
        return self.weigh(self.y - self.curve(self.x, theta))

    def jacobian(self, theta: Any) -> Floats:
        return self.weigh(self.gradient(self.x, theta))

    def require_finite(self, theta: Floats, names: tuple[str, ...]) -> None:
        if not (np.all(np.isfinite(theta)) and np.all(np.isfinite(self.residuals(theta)))):
            got = ", ".join(f"{name} = {value:g}" for name, value in zip(names, theta, strict=True))
            raise MetrologyError(Fault("start", got, "values at which the function is finite at every point"))

    def search(self, theta: Floats) -> Floats:
        """Levenberg–Marquardt from the start."""
        from scipy.optimize import least_squares

        def gaps(at: Floats) -> Floats:
            return np.nan_to_num(-self.residuals(at), nan=1e100, posinf=1e100, neginf=-1e100)

        def slopes(at: Floats) -> Floats:
            return np.nan_to_num(self.jacobian(at), nan=0.0, posinf=0.0, neginf=0.0)

        limit = 1e-14
        found = least_squares(gaps, theta, slopes, method="lm", x_scale="jac", xtol=limit, ftol=limit, max_nfev=5000)
        return np.asarray(found.x)

    def refine(self, theta: Floats) -> tuple[Floats, str]:
        """Gauss–Newton steps without damping, until they are lost in rounding; and what is wrong where they are not."""
        best = inf
        for _ in range(200):
            step, size = self._newton(theta)
            if size == inf:
                return theta, said("The points do not distinguish the parameters (the sensitivities are dependent).")
            if size >= best and best < 1e-8:
                return theta, ""
            best = min(best, size)
            theta = self._shortened(theta, step)
        return theta, said("The fit did not converge.")

    def _newton(self, theta: Floats) -> tuple[Floats, float]:
        """Gauss–Newton step, and its size as a part of the parameter or of the curve, whichever is smaller.

        Infinite where the sensitivities are not finite or depend on one another.
        """
        triangle, scale, orthogonal = self.factor(theta)
        if not (np.all(np.isfinite(triangle)) and np.linalg.cond(triangle) < _DEPENDENT):
            return np.zeros(len(theta)), inf
        step = np.linalg.solve(triangle, orthogonal.T @ self.residuals(theta)) / scale
        whole = np.maximum(np.abs(theta), np.linalg.norm(self.weigh(self.y)) / scale)
        return step, float(np.max(np.divide(np.abs(step), whole, out=np.zeros_like(step), where=whole > 0)))

    def factor(self, theta: Floats) -> tuple[Floats, Floats, Floats]:
        jacobian = self.jacobian(theta)
        if not np.all(np.isfinite(jacobian)):
            return np.full((len(theta),) * 2, np.nan), np.ones(len(theta)), jacobian
        scale = np.linalg.norm(jacobian, axis=0)
        scale = np.where(scale > 0, scale, 1.0)
        orthogonal, triangle = np.linalg.qr(jacobian / scale)
        return triangle, scale, orthogonal

    def _shortened(self, theta: Floats, step: Floats) -> Floats:
        """Where the step leads, halved while it raises the sum of squares beyond rounding."""
        now = self.total(theta)
        for _ in range(30):
            if self.total(theta + step) <= now * (1 + 1e-10):
                return theta + step
            step = step / 2
        return theta

    def total(self, theta: Floats) -> float:
        """Sum of squares of the weighted residuals; infinite where the function is not finite."""
        total = float(np.sum(self.residuals(theta) ** 2))
        return total if isfinite(total) else inf


def _result(
    problem: _Problem, theta: Floats, names: tuple[str, ...], text: tuple[str, str], *, stated: bool
) -> Regression:
    model, failure = text
    dof, total = len(problem.y) - len(names), problem.total(theta)
    variance = 1.0 if stated else total / dof
    if failure:
        covariance, refit = np.full((len(names),) * 2, np.nan), None
    else:
        triangle, scale, _ = problem.factor(theta)
        with representable():
            unit = np.linalg.inv(triangle) / scale[:, None]
            root = unit * sqrt(variance)
            covariance = root @ root.T
        known = inf if stated else float(dof)
        refit = _refit(problem, theta, unit, scale=sqrt(variance), dof=known)
    p_value, sentence = quality(total, dof) if stated else (None, "")
    settled = sentence or scattered(variance, dof)
    text_of_failure = "{failure} Begin from other values, plot the curve at the start, or leave a parameter out."
    advice = said(text_of_failure, failure=failure)
    return Regression(
        model=f"y = {model}",
        names=names,
        values=theta,
        covariance=covariance,
        dof=inf if stated else float(dof),
        residual_dof=dof,
        s=None if stated else sqrt(variance),
        chi_squared=total if stated else None,
        p_value=None if failure else p_value,
        x=problem.x,
        y=problem.y,
        residuals=problem.y - problem.curve(problem.x, theta),
        converged=not failure,
        sentence=advice if failure else settled,
        basis=Basis(theta, covariance, problem.curve, problem.gradient),
        refit=refit,
    )


def _refit(problem: _Problem, theta: Floats, root: Floats, *, scale: float, dof: float) -> Refit:
    """Draws of y about those measured, and the curve through each draw."""
    size = len(theta)
    return Refit(
        estimator=CurveEstimator(problem.function, problem.x, problem.whiten, theta, root, (scale or 1.0) * 1e-4),
        data=problem.weigh(problem.y),
        adjusted=problem.weigh(problem.curve(problem.x, theta)),
        root=np.ones(len(problem.y)),
        best=np.zeros(size),
        units=np.full(size, scale or 1.0),
        to_parameters=root,
        scale=scale,
        dof=dof,
    )
