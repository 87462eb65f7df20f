"""A stated function fitted to many draws of its points at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from metrology.gum.inputs import Floats
from metrology.gum.refit import Local

STEP = 1e-100
"""Imaginary step of derivatives: its square is lost beside any number."""
_LEAST = 1e-10
"""Curvature, as a part of that of all directions, that is a difference of rounded numbers."""


@dataclass(frozen=True)
class CurveEstimator:
    """Sum of squares of a curve in whitened points, for every draw of y, shape (n, m).

    The parameters are best + root·φ with the root of the covariance at unit variance: φ are independent at the fit, so
    that its curvature, J·Jᵀ of Gauss and Newton, is well conditioned.

    Parameters
    ----------
    function : callable
        ``function(x, parameters)``.
    x : ndarray, shape (n,)
    whiten : ndarray, shape (n,) or (n, n)
        Inverse root of the covariance of y.
    best : ndarray, shape (p,)
    root : ndarray, shape (p, p)
    small : float
        A small step of φ.
    """

    function: Callable[[Any, Any], Any]
    x: Floats
    whiten: Floats
    best: Floats
    root: Floats
    small: float

    def at(self, theta: Floats, drawn: Floats, *, full: bool = False) -> Local:
        """Sum of squares of the whitened residuals, its descent by φ, and its curvature."""
        total, descent, curvature = self._plain(theta, drawn)
        if full:
            curvature = self._full(theta, drawn, descent, curvature)
        return Local(total, descent, curvature)

    def _plain(self, theta: Floats, drawn: Floats) -> tuple[Floats, Floats, Floats]:
        """Curvature without second derivatives."""
        rows = list(self.best[:, None] + self.root @ theta)
        residuals = drawn - self._weigh(self._curve(rows, drawn.shape))
        by_parameter = np.array([self._weigh(self._slope(rows, index, drawn.shape)) for index in range(len(rows))])
        jacobian = np.tensordot(self.root.T, by_parameter, 1)
        curvature = np.einsum("inm,jnm->mij", jacobian, jacobian, optimize=True)
        descent = np.einsum("inm,nm->im", jacobian, residuals)
        return np.einsum("nm,nm->m", residuals, residuals), descent, curvature

    def _full(self, theta: Floats, drawn: Floats, descent: Floats, plain: Floats) -> Floats:
        """Differences of the descent; the plain curvature where this one has no minimum."""
        columns = []
        for index in range(len(theta)):
            moved = theta.copy()
            moved[index] += self.small
            columns.append((descent - self._plain(moved, drawn)[1]) / self.small)
        whole = np.moveaxis(np.array(columns), 2, 0)
        whole = (whole + whole.swapaxes(1, 2)) / 2
        finite: Any = np.isfinite(whole).all(axis=(1, 2))
        least = np.linalg.eigvalsh(np.where(finite[:, None, None], whole, 0.0))[:, 0]
        sound: Any = least > _LEAST * np.trace(plain, axis1=1, axis2=2)
        return np.where(sound[:, None, None], whole, plain)

    def _curve(self, rows: list[Any], shape: tuple[int, ...]) -> Any:
        return np.broadcast_to(self.function(self.x[:, None], rows), shape)

    def _slope(self, rows: list[Any], index: int, shape: tuple[int, ...]) -> Any:
        moved = [row + 1j * STEP if place == index else row for place, row in enumerate(rows)]
        return np.imag(self._curve(moved, shape)) / STEP

    def _weigh(self, columns: Floats) -> Floats:
        return np.asarray(columns * self.whiten[:, None] if self.whiten.ndim == 1 else self.whiten @ columns)
