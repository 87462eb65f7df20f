"""Covariance of least-squares parameters whose residuals are correlated, and how well it is known."""

from __future__ import annotations

import numpy as np

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


def sandwich(jacobian: Floats, residual: Floats, lags: int, taken: Floats) -> Floats:
    """Return the covariance of least-squares parameters whose residuals are correlated: (JᵀJ)⁻¹·JᵀRJ·(JᵀJ)⁻¹.

    R is the matrix of the residuals' own autocovariances, tapered to zero at `lags` (Bartlett's window; Newey & West,
    Econometrica 55 (1987) 703). The fit took noise out of the residuals, most of it where the parameters act: each u is
    therefore enlarged by as much as that of white noise would be too small. Of three periods that is a third of it.

    Parameters
    ----------
    jacobian, residual : ndarray, shape (n, p), (n,)
        Derivatives by the parameters, and what the fit leaves.
    lags : int
        Samples over which residuals are taken to be correlated; a quarter of them at most.
    taken : ndarray, shape (n, q)
        Orthonormal columns of all that was fitted.
    """
    n, lags = residual.size, min(lags, residual.size // 4)
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1.0
    unit = jacobian / scale
    inverse = np.linalg.pinv(unit.T @ unit, rcond=1e-14)

    def lagged(of: Floats) -> Floats:
        return np.array([np.sum(of[: n - k] * of[k:]) for k in range(lags + 1)]) / n

    def found(covariances: Floats) -> Floats:
        tapered = covariances * (1 - np.arange(lags + 1) / (lags + 1))
        kernel = np.concatenate([tapered[:0:-1], tapered])
        spread = np.column_stack([np.convolve(column, kernel, mode="same") for column in unit.T])
        whole: Floats = inverse @ (unit.T @ spread) @ inverse
        return whole

    left = -lagged(taken)
    left[0] += 1.0
    white, expected = np.diag(inverse), np.diag(found(left))
    enlarged = np.sqrt(np.divide(white, expected, out=np.ones_like(white), where=expected > 0)) / scale
    return found(lagged(residual)) * np.outer(enlarged, enlarged)


def degrees_of_freedom(count: int, lags: int) -> float:
    """Return those of a variance by Bartlett's window, 3·n/lags (Priestley, Spectral Analysis and Time Series, 6.2)."""
    return 3 * count / max(min(lags, count // 4), 1)
