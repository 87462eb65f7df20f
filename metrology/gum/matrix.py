"""Roots and eigenvectors of covariances that are the same on every processor."""

from __future__ import annotations

import numpy as np

from metrology.gum.inputs import Floats


def root(covariance: Floats) -> Floats:
    """Root L with L·Lᵀ = covariance, also where that is singular; shape (n, n).

    L = D·R, D the standard deviations and R the symmetric root of the correlations: the values may have units of their
    own, of which the smallest would else be lost in the rounding of the largest. No other root is unique: one made of
    eigenvectors alone has their signs and, where eigenvalues are equal, their directions, which differ between
    processors; draws made with it would then differ as well.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.asarray(size[:, None] * ((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T))


def eigen(matrix: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues in ascending order, and eigenvectors as columns whose largest component is positive."""
    values, vectors = np.linalg.eigh(matrix)
    largest = np.abs(vectors).argmax(axis=0)
    return values, np.asarray(vectors * np.sign(vectors[largest, np.arange(len(values))]))
