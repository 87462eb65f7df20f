"""The straight line with errors in x and y, fitted to many draws of its points at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from metrology.gum.inputs import Floats
from metrology.gum.refit import Local


@dataclass(frozen=True)
class LineEstimator:
    """χ² of `metrology.gum.distance` with the line a + b·x, for every draw of x and y stacked, shape (2n, m).

    Parameters
    ----------
    xx, yy, both : ndarray, shape (n,) or (n, n)
        V_xx, V_yy, and V_xy + V_yx.
    one : ndarray, shape (n,)
        What the intercept does to each point; ones, unless the points were turned.
    """

    xx: Floats
    yy: Floats
    both: Floats
    one: Floats

    def at(self, theta: Floats, drawn: Floats, *, full: bool = False) -> Local:  # noqa: ARG002 - always full
        """Sum of squares, descent and curvature; the curvature of a good fit where the full one has no minimum."""
        a, b = theta
        x, y = np.split(drawn, 2)
        one = self.one[:, None]
        rho = y - a * one - b * x
        if self.xx.ndim == 1:
            xx, both = self.xx[:, None], self.both[:, None]
            w = 1.0 / (self.yy[:, None] - b * both + b * b * xx)
            q = w * rho
            slope_q, curve_q = (2 * b * xx - both) * q, xx * q
            g = x + slope_q
            w_one, w_g = w * one, w * g
        else:
            w = self.yy - b[:, None, None] * self.both + (b * b)[:, None, None] * self.xx
            q, w_one, w_x = _solved(w, rho, np.broadcast_to(one, rho.shape), x)
            curve_q = self.xx @ q
            slope_q = 2 * b * curve_q - self.both @ q
            g = x + slope_q
            w_g = w_x + _solved(w, slope_q)[0]
        first, corner = (self.one @ column for column in (w_one, w_g))
        last = _dot(g, w_g)
        whole = last - _dot(q, curve_q)
        sound = whole * first > corner * corner
        curvature = np.array([[first, corner], [corner, np.where(sound, whole, last)]])
        descent = np.array([self.one @ q, _dot(x, q) + _dot(q, slope_q) / 2])
        return Local(_dot(rho, q), descent, np.moveaxis(curvature, 2, 0))


def _dot(a: Floats, b: Floats) -> Any:
    return np.einsum("im,im->m", a, b)


def _solved(matrices: Floats, *columns: Floats) -> Floats:
    """Solutions of one system a draw, shape (columns, n, m)."""
    right: Any = np.stack(columns, axis=-1).swapaxes(0, 1)
    return np.asarray(np.moveaxis(np.linalg.solve(matrices, right), (0, 1, 2), (2, 1, 0)))
