"""Fits made again to drawn data, many at once: the distribution of parameters that are no linear function of the data.

The data are drawn about what was measured, with their stated uncertainties or with the scatter about the curve, and
every draw is fitted by the same least squares (JCGM 101:2008, 5.9.6: a model that is an algorithm). Draws by a
covariance of the parameters would only repeat what the GUM uncertainty framework says of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any, Protocol

import numpy as np

from metrology.gum.inputs import Floats

MOST_STEPS = 30
"""Steps after which a search keeps the best that it found; nearly all end within ten."""
FINE = 1e-3
"""Steps that end a search, in standard uncertainties: δ for two digits is at least five times as much."""
_PLAIN_STEPS = 4
"""Steps of Gauss and Newton, after which second derivatives cost less than the steps that they save."""
_TOGETHER = 2000
"""Draws that are fitted together: their arrays stay in the cache of a processor."""
_AGAIN = 8
_FIRST, _LESS, _MORE = 1e-3, 0.1, 10.0
Indices = np.ndarray[tuple[int, ...], np.dtype[np.intp]]


@dataclass(frozen=True)
class Local:
    """Sum of squares of each draw (m,), half of its negative gradient (p, m), and half of its curvature (m, p, p)."""

    total: Floats
    descent: Floats
    curvature: Floats


class Estimator(Protocol):
    """A fit of one model to data of which many draws exist."""

    def at(self, theta: Floats, drawn: Floats, *, full: bool = False) -> Local:
        """Sums of squares at parameters (p, m) for the data (q, m); `full`: with second derivatives of the model."""


@dataclass(frozen=True)
class Refit:
    """How the parameters of a fit are drawn.

    Parameters
    ----------
    estimator : Estimator
    data : ndarray, shape (q,)
        About which the data are drawn: as measured.
    adjusted : ndarray, shape (q,)
        The data moved onto the fitted line or curve.
    root : ndarray, shape (q,) or (q, q)
        What standard normals do to the data: their standard uncertainties, or a root of their covariance.
    best : ndarray, shape (p,)
        Parameters of the fit itself, in the parametrisation of the estimator.
    units : ndarray, shape (p,)
        Their standard uncertainties, in which steps are measured.
    to_parameters : ndarray, shape (p, p)
        What turns differences of these parameters into those of the parameters that the fit reports.
    scale : float
        Factor of all uncertainties of the data: the scatter about the curve where none are stated.
    dof : float
        Degrees of freedom of the scale; with finite ones the errors are scaled t, as those of readings.
    """

    estimator: Estimator
    data: Floats
    adjusted: Floats
    root: Floats
    best: Floats
    units: Floats
    to_parameters: Floats
    scale: float = 1.0
    dof: float = inf

    def about_adjusted(self) -> Refit:
        """Draws about the data on the curve, to which a covariance belongs that neglects the residuals."""
        return replace(self, data=self.adjusted)

    def __call__(self, generator: np.random.Generator, size: int) -> Floats:
        """Differences of the reported parameters from their estimates, shape (p, size)."""
        normal = generator.standard_normal((len(self.data), size))
        errors = self.root[:, None] * normal if self.root.ndim == 1 else self.root @ normal
        errors *= self.scale
        if isfinite(self.dof):
            errors /= np.sqrt(generator.chisquare(self.dof, size) / self.dof)
        drawn = self.data[:, None] + errors
        found = np.empty((len(self.best), size))
        with np.errstate(all="ignore"):
            for first in range(0, size, _TOGETHER):
                some = slice(first, first + _TOGETHER)
                found[:, some] = self._search(drawn[:, some])
        return np.asarray(self.to_parameters @ (found - self.best[:, None]))

    def repeat(self, generator: np.random.Generator, size: int) -> tuple[Floats, Floats]:
        """Errors of the reported parameters in fits to data drawn about the fitted curve, and u² of each over its own.

        Each fit has the covariance of its own curvature and, where the scatter about the curve is estimated, its own
        scatter. A fit that ends without a covariance has an error that no interval holds.
        """
        normal = generator.standard_normal((len(self.data), size))
        errors = self.root[:, None] * normal if self.root.ndim == 1 else self.root @ normal
        drawn = self.adjusted[:, None] + self.scale * errors
        found, variances = np.empty((len(self.best), size)), np.empty((len(self.best), size))
        with np.errstate(all="ignore"):
            for first in range(0, size, _TOGETHER):
                some = slice(first, first + _TOGETHER)
                found[:, some] = self._search(drawn[:, some])
                variances[:, some] = self._variances(found[:, some], drawn[:, some])
            own = self._variances(self.best[:, None], self.adjusted[:, None], scatter=self.scale**2)
        return np.asarray(self.to_parameters @ (found - self.best[:, None])), variances / own

    def _variances(self, theta: Floats, drawn: Floats, *, scatter: float | None = None) -> Floats:
        """u² of the reported parameters of fits, (p, m)."""
        here = self.estimator.at(theta, drawn)
        scaled = here.curvature * np.outer(self.units, self.units)
        usable = np.isfinite(scaled).all(axis=(1, 2))
        scaled[~usable] = np.eye(len(self.best))
        turn = self.to_parameters * self.units
        covariance = turn @ np.linalg.pinv(scaled, hermitian=True) @ turn.T
        variances = np.diagonal(covariance, axis1=1, axis2=2).T.copy()
        variances[:, ~usable] = 0.0
        if isfinite(self.dof):
            variances *= here.total / self.dof if scatter is None else scatter
        return variances

    def fit(self, data: Floats) -> Floats:
        """Parameters of the one fit to data (q, 1), to rounding: searches are repeated from where they ended."""
        found = self.best
        with np.errstate(all="ignore"):
            for _ in range(_AGAIN):
                found = replace(self, best=found)._search(data)[:, 0]
        return found[:, None]

    def _search(self, drawn: Floats) -> Floats:
        """Levenberg and Marquardt's way from the fit itself, for all draws at once; those that have arrived leave.

        A first guess by derivatives would be nearer for most, and beyond a pole or in another minimum for some.
        """
        size = drawn.shape[1]
        theta = np.repeat(self.best[:, None], size, axis=1)
        here, left, damping = self.estimator.at(theta, drawn), np.arange(size), np.zeros(size)
        for number in range(MOST_STEPS):
            step = _step(here, damping, self.units)
            short = _squared(step, here.curvature) < (FINE * self.scale) ** 2
            arrived = short & (damping <= _FIRST)
            theta[:, left[arrived]] += step[:, arrived]
            going = np.flatnonzero(~arrived)
            if not going.size:
                break
            left, damping, step, here = left[going], damping[going], step[:, going], _taken(here, going)
            trial = self.estimator.at(theta[:, left] + step, drawn[:, left], full=number >= _PLAIN_STEPS)
            better = _usable(trial) & (trial.total <= here.total * (1 + 1e-12))
            theta[:, left[better]] += step[:, better]
            _put(here, np.flatnonzero(better), _taken(trial, better))
            damping = np.where(better, np.where(damping > _FIRST, damping * _LESS, 0.0), damping * _MORE)
            damping = np.where(~better & (damping < _FIRST), _FIRST, damping)
        return theta


def _squared(step: Floats, curvature: Floats) -> Floats:
    """Squares of the lengths of steps, by which the sum of squares would change."""
    return np.asarray(np.einsum("im,mij,jm->m", step, curvature, step, optimize=True))


def _usable(local: Local) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    sound = np.isfinite(local.descent).all(axis=0) & np.isfinite(local.curvature).all(axis=(1, 2))
    return np.asarray(np.isfinite(local.total) & sound)


def _taken(local: Local, which: Any) -> Local:
    return Local(local.total[which], local.descent[:, which], local.curvature[which])


def _put(local: Local, which: Indices, other: Local) -> None:
    local.total[which], local.descent[:, which], local.curvature[which] = other.total, other.descent, other.curvature


def _step(local: Local, damping: Floats, units: Floats) -> Floats:
    """Damped steps (p, m), solved in standard uncertainties."""
    matrix = local.curvature * np.outer(units, units)
    index = np.arange(len(units))
    diagonal = matrix[:, index, index]
    matrix[:, index, index] += damping[:, None] * diagonal + 1e-14 * diagonal.max(axis=1, keepdims=True) + 1e-300
    solved = np.linalg.solve(matrix, (local.descent * units[:, None]).T[:, :, None])[:, :, 0]
    return np.asarray(solved.T * units[:, None])
