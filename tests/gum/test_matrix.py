"""Roots and eigenvectors that do not depend on the processor's choice of signs."""

from __future__ import annotations

import numpy as np
import pytest

from metrology.gum.matrix import eigen, root


def covariance(rank: int) -> np.ndarray:
    parts = np.random.default_rng(1).standard_normal((5, rank))
    return parts @ parts.T


@pytest.mark.parametrize("rank", [5, 3])
def test_law_the_root_squared_is_the_covariance_also_where_that_is_singular(rank: int) -> None:
    wanted = covariance(rank)
    found = root(wanted)
    np.testing.assert_allclose(found @ found.T, wanted, atol=1e-12)


def test_law_units_of_the_values_scale_the_rows_of_the_root() -> None:
    """A compliance of 10⁻⁹ m/N beside a force of 10⁴ N: the small one keeps its digits."""
    units = np.array([1e-9, 1e4, 1.0, 1e-3, 1e6])
    scaled = root(covariance(5) * np.outer(units, units))
    np.testing.assert_allclose(scaled / units[:, None], root(covariance(5)), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("size", [1e-15, 1e-13])
def test_limit_a_change_in_the_last_digits_changes_the_root_as_little(size: float) -> None:
    """Of a matrix with equal eigenvalues, whose eigenvectors turn about with the last digit."""
    turned = np.linalg.qr(np.random.default_rng(2).standard_normal((5, 5)))[0]
    wanted = turned @ np.diag([4.0, 4.0, 4.0, 1.0, 1.0]) @ turned.T
    nudge = np.random.default_rng(3).standard_normal((5, 5)) * size
    np.testing.assert_allclose(root(wanted + nudge + nudge.T), root(wanted), atol=100 * size)


def test_law_eigenvectors_point_where_they_are_largest() -> None:
    values, vectors = eigen(covariance(5))
    np.testing.assert_allclose(vectors @ np.diag(values) @ vectors.T, covariance(5), atol=1e-12)
    assert (vectors[np.abs(vectors).argmax(axis=0), np.arange(5)] > 0).all()
