"""Parts of the engine by themselves: faults told whole, advice, matrices, least squares, roundings, copulas."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan, pi, sqrt

import numpy as np
import pytest
from gum_models import knowledge, model, quantity
from scipy import stats

from metrology import gum
from metrology.elongation.line import Layout, average, compare
from metrology.errors import MetrologyError
from metrology.gum import Arcsine, Normal, Rectangular, Student, Triangular, regression
from metrology.gum.advice import Lever
from metrology.gum.copula import expansion, latent, transform
from metrology.gum.intervals import ranks
from metrology.gum.law import propagate
from metrology.gum.monte_carlo import Plan, histogram, moments, scatter
from metrology.gum.points import quality, whitening
from metrology.gum.readings import mean, standard_deviation
from metrology.gum.rounding import readable


def refused(action: Callable[[], object]) -> list[str]:
    with pytest.raises(MetrologyError) as caught:
        action()
    return [str(fault) for fault in caught.value.faults]


# ---------------------------------------------------------------- faults


def test_refusal_names_only_the_inputs_of_the_correlations_that_cannot_hold() -> None:
    inputs = [quantity(name, 0.0, Normal(1.0)) for name in "abcde"]
    pairs = {("d", "e"): 0.5, ("a", "b"): 0.9, ("a", "c"): 0.9, ("b", "c"): -0.9}
    (line,) = refused(lambda: gum.evaluate([], knowledge(*inputs, correlations=pairs), seed=1))
    assert line.startswith("correlations: got an indefinite matrix for a, b, c (smallest eigenvalue -0.8); expected")


def test_refusal_of_names_lists_eight_of_those_there_are() -> None:
    inputs = [quantity(name, 0.0, Normal(1.0)) for name in "abcdefghi"]
    for count, known in ((8, "a, b, c, d, e, f, g, h"), (9, "a, b, c, d, e, f, g, h, …")):
        state = knowledge(*inputs[:count], correlations={("a", "z"): 0.5})
        assert refused(lambda state=state: gum.evaluate([], state, seed=1)) == [
            f"correlations['a', 'z']: got 'z'; expected the name of an input. Fix: inputs are {known}"
        ]


def test_refusal_of_readings_and_of_covariances_is_told_whole() -> None:
    assert refused(lambda: gum.observed("x", [1.0, nan])) == ["x[1]: got nan; expected a finite number"]
    assert refused(lambda: gum.simultaneous("set", {"V": [1.0, 2.0], "I": [1.0, inf]})) == [
        "set.I[1]: got inf; expected a finite number"
    ]
    expected = "expected a symmetric positive definite matrix"
    for matrix, got in (
        (np.eye(4), "the shape (4, 4); expected the shape (3, 3)"),
        (np.diag([1.0, 0.0, 1.0]), f"an entry that is not finite, or a variance not above zero; {expected}"),
        (np.diag([1.0, inf, 1.0]), f"an entry that is not finite, or a variance not above zero; {expected}"),
        (np.eye(3) + np.eye(3, k=1) / 4, f"a matrix that is not symmetric; {expected}"),
        (np.ones((3, 3)), "a singular matrix (least eigenvalue of the correlation "),
    ):
        (line,) = refused(lambda matrix=matrix: whitening(matrix, 3))
        assert line.startswith(f"covariance: got {got}")
    assert line.endswith(f"; {expected}. Fix: drop one of two points that carry the same information")


def test_law_repeatability_carries_its_name_and_source() -> None:
    found = gum.type_a("repeatability", [1.0, 2.0, 4.0], source="a.csv")
    assert (found.name, found.kind, found.dof, found.source) == ("repeatability", "A", 2.0, "a.csv")
    assert found.u == pytest.approx(sqrt(7 / 3 / 3))
    means, ensemble = gum.simultaneous("set", {"V": [1.0, 2.0], "I": [3.0, 5.0]})
    assert (means, ensemble.name, ensemble.members, ensemble.source) == ({"V": 1.5, "I": 4.0}, "set", ("V", "I"), "")


def test_closed_form_whitening_makes_a_covariance_one() -> None:
    root = np.random.default_rng(1).standard_normal((5, 5)) * np.array([1e-6, 1.0, 1e3, 1.0, 1e-3])[:, None]
    whiten = whitening(root @ root.T, 5)
    np.testing.assert_allclose(whiten @ root @ root.T @ whiten.T, np.eye(5), atol=1e-9)


def test_closed_form_quality_with_a_single_degree_of_freedom() -> None:
    assert quality(0.5, 1)[0] == pytest.approx(stats.chi2.sf(0.5, 1), rel=1e-12)
    assert quality(0.5, 0)[0] is None


def test_refusal_of_numbers_that_cannot_be_held() -> None:
    (line,) = refused(lambda: regression.polynomial([1e-200, 2e-200, 3e-200], [1e200, 2e200, 4e200], degree=2, u_y=1.0))
    assert line.startswith("fit: got points so large or so small that a parameter or its variance cannot be held (")
    assert line.endswith(
        "); expected values for which squares of the parameters lie between 1e-300 and 1e300. Fix: use units in which"
        " the values are nearer to one"
    )


# ---------------------------------------------------------------- advice


@pytest.mark.parametrize(("own", "share", "target"), [(0.9, 0.9, 0.25), (0.6, 0.75, 0.25), (1.4, 1.1, 0.3)])
def test_closed_form_lever_scales_u_to_its_target(own: float, share: float, target: float) -> None:
    """With the cause scaled by s: own·s² + 2(share − own)·s + (1 − own − 2(share − own)) of u² is left."""
    lever = Lever("a", 1.0, "1", "", own, share)
    s = lever.scaling(target)
    assert s is not None
    assert own * s**2 + 2 * (share - own) * s + 1 - own - 2 * (share - own) == pytest.approx(target, rel=1e-9)
    assert lever.rest == pytest.approx(1 - 2 * share + own)
    assert Lever("a", 1.0, "1", "", 0.1, 0.1).scaling(0.25) is None
    assert Lever("a", 1.0, "1", "", 0.0, 0.5).scaling(0.25) is None
    assert Lever("a", 1.0, "1", "", 0.2, 0.7).rest == 0.0


def test_law_readings_without_a_name_of_their_own_are_the_readings() -> None:
    ensemble = gum.Ensemble("readings", ("V",), np.array([[0.01]]), 4.0)
    state = knowledge(gum.Input("V", 1.0), ensembles=[ensemble])
    assert gum.evaluate([model("V")], state, seed=1, max_trials=1000).estimates["y"].advice == (
        "The scatter of the readings (V) has the largest part in u(y), 100% of u²; for u(y) to halve to 0.050, it would"
        " have to fall to 50% of what it is, as by 4 times as many readings."
    )


# ---------------------------------------------------------------- law


def test_closed_form_effective_degrees_of_freedom() -> None:
    """ν = u⁴/Σ u_j⁴/ν_j (G.4.1), simultaneous readings as one contribution."""
    a, b = quantity("a", 1.0, Normal(0.3), Rectangular(0.2), dof=(5.0,)), quantity("b", 1.0, Normal(0.1), dof=(9.0,))
    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    state = knowledge(a, b, ensembles=[gum.Ensemble("set", ("a", "b"), covariance, 7.0)])
    law = propagate([model("2*a - b")], state)
    together = 4 * 0.04 + 0.09 - 4 * 0.01
    u2 = together + 4 * (0.09 + 0.04 / 3) + 0.01
    expected = u2**2 / (together**2 / 7 + (4 * 0.09) ** 2 / 5 + 0.01**2 / 9)
    assert law.u(0) == pytest.approx(sqrt(u2), rel=1e-12)
    assert law.dof(0) == (pytest.approx(expected, rel=1e-12), "")
    found = law.coverage(0, 0.9)
    k = stats.t.ppf(0.95, expected)
    assert (found.p, found.k, found.low, found.high) == pytest.approx(
        (0.9, k, 1 - k * sqrt(u2), 1 + k * sqrt(u2)), rel=1e-9
    )


DOF = {
    "exact": ([quantity("a", 1.0, Normal(0.3))], {}, "a", "infinite: every contribution is taken as exactly known"),
    "nothing": ([quantity("a", 0.0, Normal(0.3))], {}, "a*a", "undefined: the GUM uncertainty framework gives u = 0"),
    "no derivative": (
        [quantity("a", 0.0, Normal(0.3))], {}, "sqrt(a)",
        "undefined: The derivative with respect to a does not exist at the estimates.",
    ),
    "no value": (
        [quantity("a", -1.0, Normal(0.3))], {}, "1/(a + 1)",
        "undefined: The equation has no value at the estimates of its inputs (float division by zero).",
    ),
    "correlated": (
        [quantity("a", 1.0, Normal(0.3), dof=(5.0,)), quantity("b", 1.0, Normal(0.3))], {("a", "b"): 0.5}, "a + b",
        "undefined: a correlation is stated for a, of finite degrees of freedom; the Welch–Satterthwaite formula asks"
        " for independent inputs, so there is no coverage factor and the Monte Carlo interval is used. Simultaneous"
        " readings given as an ensemble would have ν = n − 1",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", DOF)
def test_law_degrees_of_freedom_say_why_there_are_none(name: str) -> None:
    inputs, correlations, expression, note = DOF[name]
    law = propagate([model(expression)], knowledge(*inputs, correlations=correlations))
    assert law.dof(0) == (None, note)
    if note.startswith("undefined") and name != "nothing":
        assert law.coverage(0, 0.95).k is None
        assert law.coverage(0, 0.95).low is None


def test_closed_form_correlation_of_outputs() -> None:
    state = knowledge(quantity("a", 1.0, Normal(0.3)), quantity("b", 1.0, Normal(0.4)), gum.Input("c", 1.0))
    law = propagate([model("a + b", "s"), model("a - b", "d"), model("c", "e"), model("2*s", "t")], state)
    r = (0.09 - 0.16) / 0.25
    assert law.coefficients() == (
        (1.0, pytest.approx(r), None, pytest.approx(1.0)),
        (pytest.approx(r), 1.0, None, pytest.approx(r)),
        (None, None, None, None),
        (pytest.approx(1.0), pytest.approx(r), None, 1.0),
    )


# ---------------------------------------------------------------- draws


def test_limit_ranks_of_few_draws_and_means_of_whole_numbers() -> None:
    assert [ranks(size, 0.95) for size in (2, 3, 20, 40)] == [(1, 0), (2, 0), (19, 0), (38, 0)]
    assert ranks(100, 0.9) == (90, 4)
    assert mean(np.array([3, 1, 2], dtype=np.uint8)) == 2.0
    assert standard_deviation(np.array([3, 1, 2], dtype=np.uint8)) == 1.0


def test_closed_form_moments_of_blocks_are_those_of_all_draws() -> None:
    draws = 1e6 + np.random.default_rng(1).standard_normal((8, 50))
    batches = np.column_stack([draws.mean(axis=1), draws.std(axis=1, ddof=1), draws.min(axis=1), draws.max(axis=1)])
    assert moments(batches, 50) == pytest.approx((draws.mean(), draws.std(ddof=1)), rel=1e-10)
    np.testing.assert_allclose(scatter(batches), 2 * batches.std(axis=0, ddof=1) / sqrt(8))


def test_closed_form_histogram_is_a_density_between_the_cut_tails() -> None:
    values = np.random.default_rng(2).permutation(np.linspace(0.0, 1.0, 10_001))
    edges, density = histogram(values, 0.95)
    assert (edges[0], edges[-1], len(density)) == (0.001, 0.999, 100)
    np.testing.assert_allclose(density, 1.0, rtol=0.02)
    assert histogram(np.full(1000, 3.0), 0.95) == ((3.0,), ())


def test_closed_form_blocks_of_a_plan() -> None:
    """J ≥ 100/(1 − p), at least 10⁴, at most a tenth of the trials allowed (JCGM 101, 7.9.4 b)."""
    assert [Plan(p, 1).block for p in (0.95, 0.99, 0.999)] == [10_000, 10_000, 100_000]
    assert [Plan(0.95, 1, max_trials=n).block for n in (1000, 99_999, 100_000, 5)] == [100, 9999, 10_000, 1]
    assert Plan(0.95, 1, max_trials=25_000).most_blocks == 10


@pytest.mark.parametrize(("a", "b", "rho"), [
    (Rectangular(1.0), Rectangular(3.0), lambda r: 2 * np.sin(pi * r / 6)),
    (Normal(1.0), Rectangular(2.0), lambda r: r / sqrt(3 / pi)),
    (Normal(1.0), Normal(2.0), lambda r: r),
])  # fmt: skip
@pytest.mark.parametrize("r", [-0.9, -0.3, 0.0, 0.5, 0.95])
def test_closed_form_latent_correlation(a: gum.Normal, b: gum.Normal, rho: Callable[[float], float], r: float) -> None:
    assert latent(a, b, r) == pytest.approx(rho(r), abs=1e-9)


@pytest.mark.parametrize("shape", [Rectangular(2.0), Triangular(1.0), Arcsine(3.0), Student(1.0, 8.0)])
def test_twice_expansion_in_hermite_polynomials_by_quadrature(shape: gum.Rectangular) -> None:
    """a_k = E[f(z)·h_k(z)]/σ for normal z, by Gauss–Hermite nodes; Σa² = 1."""
    z, weight = np.polynomial.hermite_e.hermegauss(180)
    weight = weight / weight.sum()
    value = transform(shape, z) / shape.deviation
    found = expansion(shape)
    assert found @ found == pytest.approx(1.0, rel=1e-12)
    assert found[:-1:2] == pytest.approx(0.0, abs=1e-15)
    assert found[1] == pytest.approx((weight * value * z).sum(), abs=5e-3)
    assert found[3] == pytest.approx((weight * value * (z**3 - 3 * z)).sum() / sqrt(6), abs=5e-3)


# ---------------------------------------------------------------- lines and texts


def test_law_an_f_test_does_not_hang_on_units_of_its_columns() -> None:
    rng = np.random.default_rng(3)
    x = np.arange(12.0)
    y = 2 + 3 * x + 0.1 * x**2 + rng.standard_normal(12)
    small, large = np.column_stack([np.ones(12), x]), np.column_stack([np.ones(12), x, x**2])
    plain = compare(y, small, large, floor=1e-12)
    scaled = compare(y, small * [1e-9, 1e9], large * [1e9, 1e-9, 1e-12], floor=1e-12)
    assert (plain.extra, plain.dof) == (scaled.extra, scaled.dof) == (1, 9)
    assert (scaled.statistic, scaled.p_value) == pytest.approx((plain.statistic, plain.p_value), rel=1e-6)
    rest = np.linalg.lstsq(large, y, rcond=None)[1][0]
    for floor, tested in ((0.99, True), (1.01, False)):
        assert (compare(y, small, large, floor=floor * sqrt(rest / 9)).p_value is not None) is tested
    assert compare(y, small, small, floor=0.0).statistic is None
    assert compare(y[:4], small[:4], large[:4], floor=1e-12).p_value is not None  # one degree of freedom is enough
    twice = np.column_stack([small, 2 * x])
    assert compare(y, small, twice, floor=0.0).extra == 0


def test_twice_means_and_leverage_by_the_hat_matrix() -> None:
    layout = Layout.of([0, 1, 2, 0, 1, 2, 0, 2], [0, 0, 0, 1, 1, 1, 2, 2])
    readings = np.array([1.0, 2.1, 2.9, 1.3, 2.2, 3.4, 0.8, 2.9])
    found = average(readings, layout, np.array([1.0, 2.0, 3.0]))
    loads, repeats = np.eye(3)[layout.loads], np.eye(3)[layout.repeats]
    design = np.hstack([loads, repeats])
    hat = design @ np.linalg.pinv(design)
    np.testing.assert_allclose(found.leverage, np.diag(hat), atol=1e-12)
    np.testing.assert_allclose(found.leftover, readings - hat @ readings, atol=1e-12)
    assert found.dof == 3
    assert found.variance == pytest.approx(float(((readings - hat @ readings) ** 2).sum()) / 3)
    assert found.shifts.sum() == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(loads @ found.values + repeats @ found.shifts, hat @ readings, atol=1e-12)


@pytest.mark.parametrize(("value", "unit", "digits", "text"), [
    (0.0, "m", 2, "0 m"), (nan, "m", 2, "nan m"), (0.5, "kg", 2, "500 g"), (1.5, "kg", 2, "1.5 kg"),
    (-2.66e-6, "m", 2, "-2.7 µm"), (99.6, "1", 2, "100"), (0.00012, "1", 2, "0.00012"), (1.2e-5, "1", 2, "1.2e-5"),
    (123456.0, "1", 2, "1.2e5"), (12345.0, "1", 3, "12300"), (1.234e6, "Hz", 3, "1.23 MHz"),
    (2.0e15, "Pa", 1, "2e15 Pa"), (3.4e-10, "s", 2, "340 ps"), (5.0, "m/s", 1, "5 m/s"),
    (4e-7, "N·s/m", 1, "400 nN·s/m"),
])  # fmt: skip
def test_closed_form_numbers_for_a_sentence(value: float, unit: str, digits: int, text: str) -> None:
    assert readable(value, unit, digits) == text


def test_law_residuals_of_a_polynomial_are_plain_floats() -> None:
    fit = regression.polynomial([1.0, 2.0, 3.0, 4.0], [1.0, 2.1, 2.9, 4.2], degree=1)
    assert fit.residuals.dtype == fit.values.dtype == np.float64
    np.testing.assert_allclose(fit.residuals, fit.y - fit.values[0] - fit.values[1] * fit.x, atol=1e-14)
    covariance = regression.line([1.0, 2.0], [1.0, 2.0], covariance=np.eye(2))
    assert covariance.residual_dof == 0
