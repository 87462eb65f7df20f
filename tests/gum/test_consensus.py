"""One value by several methods: a published example, shared scales, coverage, and a scatter between the methods."""

from __future__ import annotations

import numpy as np
import pytest

from metrology.gum.consensus import combine

BCG = (
    (-0.8893, 0.3256), (-1.5854, 0.1946), (-1.3481, 0.4154), (-1.4416, 0.0200), (-0.2175, 0.0512), (-0.7861, 0.0069),
    (-1.6209, 0.2230), (0.0120, 0.0040), (-0.4694, 0.0564), (-1.3713, 0.0730), (-0.3394, 0.0124), (0.4459, 0.5325),
    (-0.0173, 0.0714),
)  # fmt: skip
"""ln of the risk ratio of 13 trials of the BCG vaccine with its variance (Colditz et al., JAMA 271 (1994) 698)."""


def test_reference_paule_mandel_of_the_trials_of_bcg():
    """Package metafor gives τ² = 0.318, ln of the mean −0.715 ± 0.181 by the method of Paule and Mandel."""
    logs, variances = np.array(BCG).T
    y = np.exp(logs)
    found = combine(y, np.diag(variances * y**2))
    assert found.between**2 == pytest.approx(0.3181, abs=2e-4)
    assert np.log(found.value) == pytest.approx(-0.7150, abs=2e-4)
    assert found.u / found.value == pytest.approx(0.181, abs=5e-4)
    assert not found.consistent


def test_closed_form_two_independent_results():
    found = combine(np.array([100.0, 101.0]), np.diag([1.0, 4.0]))
    weight = (1 / 0.01**2) / (1 / 0.01**2 + 1 / (2 / 101) ** 2)
    assert found.weights[0] == pytest.approx(weight, rel=1e-12)
    assert found.value == pytest.approx(100 * 1.01 ** (1 - weight), rel=1e-12)
    apart = np.log(1.01) / np.hypot(0.01, 2 / 101)
    assert found.birge == pytest.approx(apart, rel=1e-12)
    assert found.en == pytest.approx([-apart / 1.959964, apart / 1.959964], rel=1e-6)


def test_law_a_shared_scale_leaves_the_mean_between_the_results_and_its_u_in_the_consensus():
    """Peelle's puzzle: by the values themselves the mean of 1.0 and 1.5 with a scale of 20 % would be 0.88."""
    y = np.array([1.0, 1.5])
    found = combine(y, np.diag((0.1 * y) ** 2) + np.outer(0.2 * y, 0.2 * y))
    assert y[0] < found.value < y[1]
    many = np.full(50, 9000.0)
    shared = combine(many, np.diag(np.full(50, 9.0**2)) + 90.0**2)
    assert shared.u == pytest.approx(90.0, rel=0.01)


def drawn(rng, n, *, shared=0.006, between=0.0, k=9000.0):
    """Results of k with uncertainties of their own, of which the first two share a certificate."""
    own = 0.004 * np.linspace(0.7, 1.5, n)
    of = np.where(np.arange(n) < 2, shared, 0.0)
    y = k * (1 + of * rng.standard_normal()) * (1 + own * rng.standard_normal(n))
    y *= 1 + between * rng.standard_normal(n)
    return y, np.diag((own * y) ** 2) + np.outer(of * y, of * y)


@pytest.mark.long
@pytest.mark.parametrize(("n", "seed"), [(2, 1), (3, 2), (5, 3)])
def test_planted_consistent_results_are_covered_in_95_of_100_campaigns(n, seed):
    rng = np.random.default_rng(seed)
    found = [combine(*drawn(rng, n)) for _ in range(1500)]
    assert 0.93 < np.mean([one.low <= 9000 <= one.high for one in found]) < 0.97
    assert 0.03 < np.mean([not one.consistent for one in found]) < 0.07


@pytest.mark.long
def test_planted_scatter_between_the_methods_is_covered_where_the_results_show_it():
    rng = np.random.default_rng(4)
    found = [combine(*drawn(rng, 6, shared=0.0, between=0.04)) for _ in range(800)]
    assert 0.93 < np.mean([one.low <= 9000 <= one.high for one in found]) < 0.97
    assert np.mean([one.consistent for one in found]) < 0.01


def test_planted_without_the_covariance_a_shared_certificate_counts_twice():
    """The test above can fail: two results that share a certificate, taken as independent."""
    rng = np.random.default_rng(5)
    found = []
    for _ in range(800):
        y, covariance = drawn(rng, 2)
        found.append(combine(y, np.diag(np.diag(covariance))))
    assert np.mean([one.low <= 9000 <= one.high for one in found]) < 0.92
