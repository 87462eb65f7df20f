"""What a least-squares fit yields: parameters with covariance, the test of fit, predictions, inputs for further use."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.inputs import Component, Ensemble, Input, Knowledge, Redrawn
from metrology.gum.refit import Refit
from metrology.message import said

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
LINE = "y = a + b·x"


@dataclass(frozen=True)
class Basis:
    """The parametrisation in which the fit is well conditioned: predictions are made in it.

    Parameters
    ----------
    values : ndarray, shape (p,)
    covariance : ndarray, shape (p, p)
    function : callable
        ``function(x, values)``, the fitted curve, shape (n,).
    gradient : callable
        ``gradient(x, values)``, derivatives of the curve by the parameters, shape (n, p).
    """

    values: Floats
    covariance: Floats
    function: Callable[[Floats, Floats], Floats]
    gradient: Callable[[Floats, Floats], Floats]


@dataclass(frozen=True)
class Regression:
    """A fitted line or curve y = f(x; parameters).

    Parameters
    ----------
    model : str
        The equation.
    names : tuple of str
        Of the parameters.
    values : ndarray, shape (p,)
    covariance : ndarray, shape (p, p)
        Of the parameters; nan where the fit did not converge.
    dof : float
        Degrees of freedom of the covariance: n − p where it comes from the scatter, infinite from stated uncertainties.
    residual_dof : int
        n − p.
    s : float
        Standard deviation of the residuals, √(Σ r² / (n − p)); None where uncertainties were stated, or n = p.
    chi_squared, p_value : float
        Σ of squared weighted residuals, and its probability to be exceeded; None where no uncertainties were stated.
    x, y, residuals : ndarray, shape (n,)
        Data, and y − f(x).
    converged : bool
    sentence : str
        What the fit says of itself, or why it failed and what to try.
    basis : Basis
    information : ndarray, shape (p, p)
        For errors in x and y: covariance in the basis by the information matrix of ISO/TS 28037:2010, clause 7 and 10.
    refit : Refit, optional
        How the parameters are drawn where they are no linear function of the data; else the covariance says it all.
    """

    model: str
    names: tuple[str, ...]
    values: Floats
    covariance: Floats
    dof: float
    residual_dof: int
    s: float | None
    chi_squared: float | None
    p_value: float | None
    x: Floats
    y: Floats
    residuals: Floats
    converged: bool
    sentence: str
    basis: Basis
    information: Floats | None = None
    refit: Refit | None = None

    @property
    def u(self) -> Floats:
        """Standard uncertainties of the parameters."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Floats:
        """Correlation coefficients of the parameters; 0 beside the diagonal where an uncertainty is zero."""
        u = np.where(self.u > 0, self.u, 1.0)
        scaled: Floats = self.covariance / np.outer(u, u)
        np.fill_diagonal(scaled, 1.0)
        return scaled


@dataclass(frozen=True)
class Prediction:
    """Values of the fitted curve with their standard uncertainties, and the degrees of freedom of these."""

    value: Floats
    u: Floats
    dof: float


def predict(fit: Regression, x: Floats | Sequence[float] | float) -> Prediction:
    """Fitted curve at some x, u²(y) = gᵀ·V·g with the gradient g of the curve by the parameters.

    Parameters
    ----------
    fit : Regression
        A fit that converged.
    x : array_like, shape (n,)
        Taken as exact; the uncertainty of a new reading comes on top.

    Returns
    -------
    Prediction
        y and its u, each of shape (n,), in the unit of y, with their degrees of freedom.

    Notes
    -----
    JCGM 100:2008 H.3.4 gives b(30 °C) = −0.1494 °C with u = 0.0041 °C.
    """
    points = np.atleast_1d(np.asarray(x, dtype=float))
    gradient = fit.basis.gradient(points, fit.basis.values)
    variance = np.einsum("ij,jk,ik->i", gradient, fit.basis.covariance, gradient)
    return Prediction(fit.basis.function(points, fit.basis.values), np.sqrt(np.maximum(variance, 0.0)), fit.dof)


def knowledge(fit: Regression, name: str, units: Sequence[str] = ()) -> Knowledge:
    """The parameters as inputs of further models, ``name.a``, ``name.b``, with their joint state of knowledge.

    Where the covariance comes from the scatter of the points the parameters form an ensemble with ν = n − p;
    where it rests on stated uncertainties they are normal and correlated. Draws of parameters that are no linear
    function of the data come from fits to drawn data.

    Parameters
    ----------
    fit : Regression
        A fit that converged.
    name : str
        Of the fit.
    units : sequence of str
        SI units of the parameters; numbers where it is empty.

    Returns
    -------
    Knowledge
        Inputs by name, in SI, with their correlations or their ensemble.

    Raises
    ------
    MetrologyError
        For a fit that did not converge: its values must not be used.
    """
    from metrology.gum.distributions import Normal

    if not fit.converged:
        raise MetrologyError(Fault(name, "a fit that did not converge", "a fit that did", fit.sentence))
    members = tuple(f"{name}.{parameter}" for parameter in fit.names)
    stated = fit.dof == inf
    source = said("fit {name}, {model}", name=name, model=fit.model)
    inputs = {}
    for i, (member, unit) in enumerate(zip(members, units or ("1",) * len(members), strict=True)):
        component = Component(said("fit"), Normal(float(fit.u[i])), source=source)
        described = said("parameter {parameter} of the fit {name}", parameter=fit.names[i], name=name)
        inputs[member] = Input(member, float(fit.values[i]), (component,) if stated else (), unit, described)
    redrawn = (Redrawn(members, fit.refit, fit.refit.repeat),) if fit.refit else ()
    if not stated:
        together = Ensemble(said("fit {name}", name=name), members, fit.covariance, fit.dof, source)
        return Knowledge(inputs, (together,), redrawn=redrawn)
    pairs = {(members[i], members[j]): float(fit.correlation[i, j]) for i in range(len(members)) for j in range(i)}
    return Knowledge(inputs, correlations=pairs, redrawn=redrawn)


def scaled(fit: Regression) -> Regression:
    """The same fit where the stated uncertainties are known up to a common factor only, V·χ²/ν with ν = n − p.

    Parameters
    ----------
    fit : Regression
        With stated uncertainties.

    Returns
    -------
    Regression
        The same parameters with their covariance times χ²/ν.

    Raises
    ------
    MetrologyError
        Without stated uncertainties, or without degrees of freedom left.
    """
    if fit.chi_squared is None or fit.residual_dof < 1:
        got = "no stated uncertainties" if fit.chi_squared is None else "as many parameters as points"
        raise MetrologyError(Fault("fit", got, "stated uncertainties and more points than parameters"))
    ratio = fit.chi_squared / fit.residual_dof
    basis = replace(fit.basis, covariance=fit.basis.covariance * ratio)
    dof, s = float(fit.residual_dof), sqrt(ratio)
    refit = replace(fit.refit, scale=s, dof=dof) if fit.refit else None
    return replace(fit, covariance=fit.covariance * ratio, basis=basis, dof=dof, s=s, refit=refit)


def by_information(fit: Regression) -> Regression:
    """The same line with errors in x and y, with the covariance of ISO/TS 28037:2010, which neglects the residuals.

    The default is the law of propagation through the estimator itself (JCGM 100:2008, 5.2), which the residuals enter.
    Draws of the points are then made about those on the line, to which that covariance belongs.

    Parameters
    ----------
    fit : Regression
        With errors in x and y.

    Returns
    -------
    Regression
        The same parameters with the other covariance.

    Raises
    ------
    MetrologyError
        A fit without errors in x.
    """
    if fit.information is None:
        raise MetrologyError(Fault("fit", f"a fit of {fit.model} without errors in x", "one with errors in x and y"))
    turn = np.eye(len(fit.values))
    if fit.model == LINE:
        jacobian = fit.basis.gradient(np.array([0.0, 1.0]), fit.basis.values)
        turn = np.array([jacobian[0], jacobian[1] - jacobian[0]])
    basis = replace(fit.basis, covariance=fit.information)
    refit = fit.refit.about_adjusted() if fit.refit else None
    return replace(fit, covariance=turn @ fit.information @ turn.T, basis=basis, refit=refit)
