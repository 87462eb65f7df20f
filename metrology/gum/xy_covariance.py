"""Covariance of the x and the y of points, as two diagonals or as one matrix, and products with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.fit import Floats
from metrology.gum.points import whitening


@dataclass(frozen=True)
class Frame:
    """Centre and spread of the points: the fit is made in scaled, centred coordinates."""

    x: float
    y: float
    x_scale: float
    y_scale: float


@dataclass(frozen=True)
class Blocks:
    """Covariance of x, of y, and of x with y: diagonals (n,) or matrices (n, n)."""

    xx: Floats
    yy: Floats
    xy: Floats

    def scaled(self, frame: Frame) -> Blocks:
        """Return them in the coordinates of a frame."""
        sx, sy = frame.x_scale, frame.y_scale
        return Blocks(self.xx / sx / sx, self.yy / sy / sy, self.xy / sx / sy)

    @property
    def both(self) -> Floats:
        """V_xy + V_yx."""
        return 2 * self.xy if self.xy.ndim == 1 else self.xy + self.xy.T


def stated_blocks(given: dict[str, Any], correlation: Any, covariance: Any, n: int) -> Blocks:
    """Blocks of a stated covariance, or of standard uncertainties and the correlation of each x with its y."""
    if covariance is not None:
        matrix = np.asarray(covariance, dtype=float)
        whitening(matrix, 2 * n)
        return Blocks(matrix[:n, :n], matrix[n:, n:], matrix[:n, n:])
    u_x, u_y = (np.asarray(given[name], dtype=float) for name in ("u_x", "u_y"))
    r = np.broadcast_to(np.asarray(0.0 if correlation is None else correlation, dtype=float), (n,))
    bad = np.flatnonzero(~(np.abs(r) < 1))
    if len(bad):
        raise MetrologyError(
            *(Fault(f"correlation[{i}]", f"{r[i]:g}", "a coefficient between −1 and 1") for i in bad[:5])
        )
    return Blocks(u_x**2, u_y**2, r * u_x * u_y)


def times(matrix: Floats, vector: Floats) -> Floats:
    """V·q of a diagonal (n,) or a matrix (n, n)."""
    return matrix * vector if matrix.ndim == 1 else np.asarray(matrix @ vector)


def form(left: Floats, matrix: Floats, right: Floats) -> Floats:
    """P·V·Qᵀ of a diagonal (n,) or a matrix (n, n)."""
    return np.asarray((left * matrix) @ right.T if matrix.ndim == 1 else left @ matrix @ right.T)


def stacked_root(v: Blocks) -> Floats:
    """Root of the covariance of x and y stacked; their standard uncertainties where all are independent."""
    if not np.any(v.xy):
        return np.asarray(np.sqrt(np.concatenate([v.xx, v.yy])))
    xx, xy, yy = (np.diag(block) if block.ndim == 1 else block for block in (v.xx, v.xy, v.yy))
    return np.asarray(np.linalg.cholesky(np.block([[xx, xy], [xy.T, yy]])))
