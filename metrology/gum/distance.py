"""A straight line through points that are uncertain in x and y, correlated or not (generalised distance regression)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.distance_draws import LineEstimator
from metrology.gum.fit import LINE, Basis, Floats, Regression
from metrology.gum.matrix import root
from metrology.gum.points import checked, distinct, quality, representable, spread
from metrology.gum.refit import Refit
from metrology.gum.xy_covariance import Blocks, Frame, form, stacked_root, stated_blocks, times
from metrology.message import said

_MAX_STEPS = 200


def line_both(
    x: Any, y: Any, *, u_x: Any = None, u_y: Any = None, correlation: Any = None, covariance: Any = None
) -> Regression:
    """Straight line y = a + b·x with errors in x and y.

    With ρ = y − a − b·x and W(b) = V_yy − b·(V_xy + V_yx) + b²·V_xx, minimises χ² = ρᵀ·W⁻¹·ρ over a and b: what remains
    of the generalised distance once the true x are eliminated. The covariance of a and b is that of the law of
    propagation through the estimator, by implicit derivatives with respect to every x_i and y_i; `fit.by_information`
    gives the one of ISO/TS 28037, which neglects the residuals.

    Parameters
    ----------
    x, y : array_like, shape (n,)
    u_x, u_y : array_like, shape (n,), or float
        Standard uncertainties.
    correlation : array_like, shape (n,), or float
        Correlation coefficients r(x_i, y_i).
    covariance : array_like, shape (2n, 2n)
        Of x and y stacked, in place of the above.

    Raises
    ------
    MetrologyError
        For points that are not finite or too few, equal x, uncertainties ≤ 0, |r| ≥ 1, a singular covariance.

    Notes
    -----
    D. York et al., Am. J. Phys. 72 (2004) 367; ISO/TS 28037:2010 clauses 7, 8 and 10.
    """
    n = np.size(y)
    given = {"u_x": spread(u_x, n), "u_y": spread(u_y, n)}
    if covariance is None and (u_x is None or u_y is None):
        fix = "state 'u_y', or exchange 'x' and 'y'"
        raise MetrologyError(Fault("u_x", "uncertainties of x alone", "'u_y' as well", fix))
    points, values = checked(x, y, {**given, "covariance": None if covariance is None else np.ones(n)}, parameters=2)
    distinct(points, 2)
    blocks = stated_blocks(given, correlation, covariance, n)
    frame = Frame(float(np.mean(points)), float(np.mean(values)), float(np.std(points)), float(np.std(values)) or 1.0)
    problem = _Problem((points - frame.x) / frame.x_scale, (values - frame.y) / frame.y_scale, blocks.scaled(frame))
    best = min((problem.minimise(start) for start in problem.starts()), key=lambda found: found.chi_squared)
    return _result(problem, best, frame, (points, values))


@dataclass(frozen=True)
class _State:
    """All that the equations of the minimum need at one (a, b)."""

    theta: Floats
    chi_squared: float
    equations: Floats
    jacobian: Floats
    information: Floats
    by_x: Floats
    by_y: Floats
    converged: bool = False

    @property
    def settled(self) -> bool:
        """Whether χ² has a proper minimum here: its second derivatives, scaled to those of a good fit, are positive."""
        scale = np.sqrt(np.diag(self.information))
        if not (np.all(np.isfinite(self.jacobian)) and np.all(scale > 0)):
            return False
        return bool(np.linalg.eigvalsh(self.jacobian / np.outer(scale, scale))[1] < -1e-9)


@dataclass(frozen=True)
class _Problem:
    x: Floats
    y: Floats
    v: Blocks

    def solve(self, b: float, *columns: Floats) -> list[Floats]:
        w = self.v.yy - b * self.v.both + b * b * self.v.xx
        if w.ndim == 1:
            return [column / w for column in columns]
        return list(np.linalg.solve(w, np.column_stack(columns)).T)

    def starts(self) -> list[Floats]:
        """Slopes of y on x and of x on y, and the one between them."""
        direct = float(self.x @ self.y) / float(self.x @ self.x)
        slopes = [direct]
        if direct:
            reverse = float(self.y @ self.y) / float(self.x @ self.y)
            slopes += [reverse, float(np.sign(direct) * np.sqrt(abs(direct * reverse)))]
        return [np.array([0.0, slope]) for slope in slopes]

    def at(self, theta: Floats) -> _State:
        """Equations of the minimum and their derivatives.

        With q = W⁻¹·ρ and g = x + W′·q: 1ᵀ·q = 0 and xᵀ·q + qᵀ·W′·q/2 = 0.
        """
        a, b = float(theta[0]), float(theta[1])
        rho, one = self.y - a - b * self.x, np.ones(len(self.x))
        (q,) = self.solve(b, rho)
        slope_q = times(2 * b * self.v.xx - self.v.both, q)
        g = self.x + slope_q
        adjusted = self.x + times(b * self.v.xx - self.v.xy, q)
        w_one, w_g, w_adjusted = self.solve(b, one, g, adjusted)
        corner = -float(one @ w_g)
        return _State(
            theta,
            float(rho @ q),
            np.array([np.sum(q), self.x @ q + slope_q @ q / 2]),
            np.array([[-one @ w_one, corner], [corner, -g @ w_g + q @ times(self.v.xx, q)]]),
            np.array([[one @ w_one, one @ w_adjusted], [adjusted @ w_one, adjusted @ w_adjusted]]),
            np.array([-b * w_one, q - b * w_g]),
            np.array([w_one, w_g]),
        )

    def minimise(self, start: Floats) -> _State:
        """Newton's steps where they descend, Gauss–Newton's otherwise, halved until χ² falls."""
        state = self.at(start)
        for _ in range(_MAX_STEPS):
            step = self._step(state)
            size = float(np.max(np.abs(step) / (1e-3 + np.abs(state.theta))))
            if size < 1e-10:
                final = self.at(state.theta + step)
                return replace(final, converged=final.settled)
            shorter = self._descend(state, step)
            if shorter is None:
                return state
            state = shorter
        return state

    def _step(self, state: _State) -> Floats:
        if np.linalg.eigvalsh(state.jacobian)[1] < 0:
            return np.asarray(-np.linalg.solve(state.jacobian, state.equations))
        return np.asarray(np.linalg.lstsq(state.information, state.equations, rcond=None)[0])

    def _descend(self, state: _State, step: Floats) -> _State | None:
        for halvings in range(40):
            trial = self.at(state.theta + step * 0.5**halvings)
            if trial.chi_squared <= state.chi_squared * (1 + 1e-13):
                return trial
        return None

    def covariance(self, state: _State) -> Floats:
        """J·V·Jᵀ with J = −(∂h/∂θ)⁻¹·∂h/∂(x, y)."""
        by_x, by_y = (np.asarray(-np.linalg.solve(state.jacobian, part)) for part in (state.by_x, state.by_y))
        cross = form(by_x, self.v.xy, by_y)
        return np.asarray(form(by_x, self.v.xx, by_x) + form(by_y, self.v.yy, by_y) + cross + cross.T)


def _refit(problem: _Problem, state: _State, covariance: Floats, to_parameters: Floats) -> Refit:
    """Draws of the points about those measured, and the line through each draw.

    Where x and y are independent of each other, points are turned so that the turned ones are independent: with
    V_yy = L·Lᵀ and L⁻¹·V_xx·L⁻ᵀ = U·D·Uᵀ, Uᵀ·L⁻¹ makes V_yy the unit matrix and V_xx the diagonal D.
    """
    from scipy.linalg import block_diag

    v, n = problem.v, len(problem.x)
    columns = [problem.x, problem.y, np.ones(n), *_adjusted(problem, state)]
    drawn = stacked_root(v)
    if v.xx.ndim == 2 and not np.any(v.xy):
        lower = np.linalg.cholesky(v.yy)
        half = np.linalg.solve(lower, v.xx)
        sizes, turned = np.linalg.eigh(np.linalg.solve(lower, half.T))
        columns = [turned.T @ np.linalg.solve(lower, column) for column in columns]
        # Drawn before they are turned: eigenvectors have other signs and directions on another processor.
        drawn = block_diag(*(turned.T @ np.linalg.solve(lower, root(block)) for block in (v.xx, v.yy)))
        v = Blocks(sizes, np.ones(n), np.zeros(n))
    x, y, one, on_x, on_y = columns
    return Refit(
        estimator=LineEstimator(v.xx, v.yy, v.both, one),
        data=np.concatenate([x, y]),
        adjusted=np.concatenate([on_x, on_y]),
        root=drawn,
        best=state.theta,
        units=np.sqrt(np.diag(covariance)),
        to_parameters=to_parameters,
    )


def _adjusted(problem: _Problem, state: _State) -> tuple[Floats, Floats]:
    """Points on the line that are nearest to those measured: x − (V_xy − b·V_xx)·q and y − (V_yy − b·V_yx)·q."""
    v, (a, b) = problem.v, state.theta
    (q,) = problem.solve(float(b), problem.y - a - b * problem.x)
    x = problem.x - times(v.xy - b * v.xx, q)
    return x, a + b * x


def _result(problem: _Problem, state: _State, frame: Frame, data: tuple[Floats, Floats]) -> Regression:
    x, y = data
    scale = np.array([frame.y_scale, frame.y_scale / frame.x_scale])
    centred = state.theta * scale + np.array([frame.y, 0.0])
    empty = np.full((2, 2), np.nan)
    to_line = np.array([[1.0, -frame.x], [0.0, 1.0]])
    with representable():
        unit = np.outer(scale, scale)
        in_frame = problem.covariance(state) if state.converged else empty
        covariance = in_frame * unit
        information = np.asarray(np.linalg.inv(state.information) * unit) if state.converged else empty
        of_line = to_line @ covariance @ to_line.T
    p_value, sentence = quality(state.chi_squared, len(x) - 2)
    failure = said(
        "The line did not converge: these points do not determine its slope. Look at the plot; swap x and y if steep."
    )
    values = to_line @ centred
    return Regression(
        model=LINE,
        names=("a", "b"),
        values=values,
        covariance=of_line,
        dof=inf,
        residual_dof=len(x) - 2,
        s=None,
        chi_squared=state.chi_squared,
        p_value=p_value if state.converged else None,
        x=x,
        y=y,
        residuals=y - (centred[0] + centred[1] * (x - frame.x)),
        converged=state.converged,
        sentence=sentence if state.converged else failure,
        basis=Basis(
            values=centred,
            covariance=covariance,
            function=lambda at, theta: np.asarray(theta[0] + theta[1] * (at - frame.x)),
            gradient=lambda at, theta: np.column_stack([np.ones_like(at), at - frame.x]),  # noqa: ARG005
        ),
        information=information,
        refit=_refit(problem, state, in_frame, to_line * scale) if state.converged else None,
    )
