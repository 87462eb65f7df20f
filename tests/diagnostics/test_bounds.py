"""Normal distributions between bounds: one variable by SciPy, several by draws, a ridge in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import truncnorm

from metrology.diagnostics.bounds import truncated, within

FREE = math.inf


def bounded(mean, covariance, low, high):
    """Mean and covariance between bounds."""
    mean, covariance = np.asarray(mean, dtype=float), np.asarray(covariance, dtype=float)
    sites = within(mean, covariance, np.asarray(low, dtype=float), np.asarray(high, dtype=float))
    found = sites.gain(covariance) @ covariance
    return mean + found @ (sites.shift - sites.precision * mean), found


@pytest.mark.parametrize(
    ("mean", "variance", "low", "high"),
    [(0, 1, 0, FREE), (-3, 1, 0, FREE), (2, 4, -1, 3), (5, 1, -FREE, 0), (0, 100, 0, 1), (8, 1, 0, 1)],
)
def test_second_method_one_variable_is_that_of_scipy(mean, variance, low, high):
    size = math.sqrt(variance)
    expected = truncnorm.stats((low - mean) / size, (high - mean) / size, loc=mean, scale=size, moments="mv")
    assert truncated(mean, variance, low, high) == pytest.approx(expected, rel=1e-8)
    found, covariance = bounded([mean], [[variance]], [low], [high])
    assert (found[0], covariance[0, 0]) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("low", [-FREE, 0.9])
def test_limit_a_mean_far_outside_is_at_its_bound(low: float):
    mean, variance = truncated(1e9, 1e-6, low, 1.0)
    assert mean == pytest.approx(1.0 - 1e-5, abs=1e-8)
    assert variance == pytest.approx(1e-10, rel=1e-3)


def test_limit_a_wide_normal_is_uniform_between_its_bounds():
    assert truncated(0.0, 1e20, 3.0, 4.0) == pytest.approx((3.5, 1 / 12))


@pytest.mark.parametrize("seed", range(3))
def test_second_method_three_variables_are_those_of_draws(seed: int):
    random = np.random.default_rng(seed)
    root, mean = random.normal(size=(3, 3)), np.array([0.5, 1.0, 0.2])
    draws = random.multivariate_normal(mean, root @ root.T, 400_000)
    inside = draws[(draws > 0).all(axis=1)]
    assert len(inside) > 20_000
    found, covariance = bounded(mean, root @ root.T, np.zeros(3), np.full(3, FREE))
    assert found == pytest.approx(inside.mean(axis=0), rel=0.05)
    assert np.sqrt(np.diag(covariance)) == pytest.approx(inside.std(axis=0), rel=0.1)


def test_closed_form_two_parts_of_a_known_sum_are_each_between_zero_and_it():
    """Their sum is 1 ± 0.002, how it is parted is free: uniform, 1/√12, which the propagation makes a fifth wider."""
    apart = np.array([1.0, -1.0])
    covariance = 2000.0**2 * np.outer(apart, apart) + 2e-6 * np.eye(2)
    found, inside = bounded([0.9, 0.1], covariance, np.zeros(2), np.full(2, FREE))
    assert found == pytest.approx([0.5, 0.5], abs=1e-3)
    assert np.sqrt(np.diag(inside)) == pytest.approx(1 / math.sqrt(12), rel=0.25)
    assert math.sqrt(inside.sum()) == pytest.approx(0.002, rel=0.01)


def test_limit_far_bounds_and_variables_without_variance_change_nothing():
    sites = within(np.array([7.0, 0.0, math.nan]), np.diag([1.0, 0.0, 0.0]), np.zeros(3), np.full(3, FREE))
    assert not sites.precision.any()
    assert not sites.shift.any()
