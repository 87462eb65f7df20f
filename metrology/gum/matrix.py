"""Roots and eigenvectors of covariances that are the same on every processor."""

from __future__ import annotations

import numpy as np

from metrology.gum.inputs import Floats

ROUNDING = 1e-13
"""Part of a variance below which what the values before it leave of it is zero: 500 units in the last place."""


def root(covariance: Floats) -> Floats:
    """Root L with L·Lᵀ = covariance, also where that is singular: lower triangular, shape (n, n).

    Cholesky's in the order of the values, on the correlations, since the values may have units of their own. It is
    unique, where a root of eigenvectors has their signs and, of equal eigenvalues, their directions; and a value that
    is known far better than all before it does not change how these are drawn, where the symmetric root would mix in
    its correlations, of which rounding leaves nothing.

    Parameters
    ----------
    covariance : ndarray, shape (n, n)
        Symmetric, positive semi-definite.

    Returns
    -------
    ndarray, shape (n, n)
        L, with columns of zeros where nothing is left.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.where(size > 0, size, 1.0)
    left = covariance / np.outer(scale, scale)
    found = np.zeros_like(left)
    for at in range(len(left)):
        # The square root would make 1e-8 of what is zero but for rounding.
        if left[at, at] > ROUNDING:
            found[at:, at] = left[at:, at] / np.sqrt(left[at, at])
            left = left - np.outer(found[:, at], found[:, at])
    return np.asarray(size[:, None] * found)


def eigen(matrix: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues in ascending order, and eigenvectors as columns whose largest component is positive."""
    values, vectors = np.linalg.eigh(matrix)
    largest = np.abs(vectors).argmax(axis=0)
    return values, np.asarray(vectors * np.sign(vectors[largest, np.arange(len(values))]))
