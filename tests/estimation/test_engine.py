import math

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import multivariate_normal

from metrology.estimation import Block, Problem, Segment, Unknown, covariance, interval, log_evidence, solve
from metrology.estimation.covariance import correlation_length


def line_problem(design, y, u, unknowns):
    """y = design·θ as a block whose residuals and derivatives are written out."""
    block = Block(
        "line",
        tuple(range(design.shape[1])),
        lambda theta: (y - design @ theta) / u,
        lambda theta: -design / u,
        (Segment("y", 0, len(y)),),
        len(y),
        len(y) * math.log(u * math.sqrt(2 * math.pi)),
    )
    return Problem(unknowns, (block,))


@pytest.fixture
def line():
    rng = np.random.default_rng(4)
    x = np.linspace(0, 1, 40)
    design = np.column_stack([np.ones_like(x), x])
    return design, design @ [2.0, -1.0] + 0.1 * rng.standard_normal(40)


def test_closed_form_weighted_straight_line(line):
    design, y = line
    problem = line_problem(design, y, 0.1, (Unknown("a", 0.0), Unknown("b", 5.0)))
    found = solve(problem)
    assert found.status == "converged"
    np.testing.assert_allclose(found.point.theta, np.linalg.lstsq(design, y, rcond=None)[0], rtol=1e-10)
    np.testing.assert_allclose(covariance(problem, found).bread, 0.01 * np.linalg.inv(design.T @ design), rtol=1e-9)


def test_closed_form_prior_is_one_more_observation(line):
    design, y = line
    problem = line_problem(design, y, 0.1, (Unknown("a", 0.0, mean=1.5, u=0.02), Unknown("b", 0.0)))
    extended, reading, weight = np.vstack([design, [1.0, 0.0]]), np.append(y, 1.5), np.append(np.full(40, 10.0), 50.0)
    expected = np.linalg.lstsq(extended * weight[:, None], reading * weight, rcond=None)[0]
    np.testing.assert_allclose(solve(problem).point.theta, expected, rtol=1e-10)


def test_law_bound_holds_and_the_rest_is_the_conditional_optimum(line):
    design, y = line
    problem = line_problem(design, y, 0.1, (Unknown("a", 0.0), Unknown("b", 0.0, low=-0.5)))
    found = solve(problem)
    assert found.point.theta[1] == -0.5
    assert found.point.theta[0] == pytest.approx(np.mean(y + 0.5 * design[:, 1]), rel=1e-9)


def test_closed_form_evidence_of_a_linear_model(line):
    design, y = line
    unknowns = (Unknown("a", 0.0, mean=1.0, u=2.0), Unknown("b", 0.0, mean=0.0, u=3.0))
    problem = line_problem(design, y, 0.1, unknowns)
    spread = 0.01 * np.eye(40) + design @ np.diag([4.0, 9.0]) @ design.T
    expected = multivariate_normal(design @ [1.0, 0.0], spread).logpdf(y)
    assert log_evidence(problem, solve(problem)) == pytest.approx(expected, rel=1e-9)


def test_closed_form_correlation_length_of_an_autoregressive_series():
    rng, series = np.random.default_rng(2), np.zeros(200_000)
    kicks = rng.standard_normal(len(series))
    for at in range(1, len(series)):
        series[at] = 0.6 * series[at - 1] + kicks[at]
    assert correlation_length(series) == pytest.approx((1 + 0.6) / (1 - 0.6), rel=0.06)
    assert correlation_length(kicks) == pytest.approx(1.0, abs=0.02)


@pytest.mark.long
def test_law_covariance_holds_for_slow_noise():
    """The estimate of a level under autocorrelated noise scatters as the sandwich says, not as white noise would."""
    rng = np.random.default_rng(7)
    n, estimates, claimed = 600, [], []
    for _ in range(300):
        noise = np.convolve(rng.standard_normal(n + 9), np.ones(10) / math.sqrt(10), "valid")
        problem = line_problem(np.ones((n, 1)), noise, 1.0, (Unknown("level", 0.0),))
        found = solve(problem)
        estimates.append(found.point.theta[0])
        claimed.append(math.sqrt(covariance(problem, found).total[0, 0]))
    assert np.median(claimed) == pytest.approx(np.std(estimates), rel=0.12)
    assert np.median(claimed) > 2.5 / math.sqrt(n)


def exponential(y, t, u, start):
    block = Block(
        "decay",
        (0,),
        lambda theta: (y - np.exp(-theta[0] * t)) / u,
        lambda theta: (t * np.exp(-theta[0] * t) / u)[:, None],
        (Segment("y", 0, len(y)),),
        len(y),
    )
    return Problem((Unknown("rate", start, low=0.0),), (block,))


def test_limit_profile_replaces_a_parabola_that_is_wrong():
    """One late reading of a decay: the rate is known far better from below than from above."""
    t, u = np.array([1.0]), 0.05
    problem = exponential(np.exp(-2.0 * t), t, u, 1.0)
    found = solve(problem)
    standard = math.sqrt(covariance(problem, found).total[0, 0])
    ends = interval(problem, found, 0, standard, standard)
    exact = [-math.log(math.exp(-2.0) + sign * 1.96 * u) for sign in (1, -1)]
    assert ends.kind == "profile"
    assert (ends.low, ends.high) == pytest.approx(exact, rel=0.05)


def test_twice_profile_of_two_unknowns_against_a_search_of_scipy():
    """Rate and size of a decay seen late: at both ends the sum, minimised anew by SciPy, has risen by 1.96²."""
    t, u = np.linspace(0.5, 2.0, 12), 0.06
    y = 1.3 * np.exp(-1.5 * t) + u * np.random.default_rng(3).standard_normal(12)
    block = Block(
        "decay", (0, 1), lambda theta: (y - theta[1] * np.exp(-theta[0] * t)) / u,
        lambda theta: np.column_stack([theta[1] * t, -np.ones_like(t)]) * np.exp(-theta[0] * t)[:, None] / u,
        (Segment("y", 0, 12),), 12,
    )  # fmt: skip
    problem = Problem((Unknown("rate", 1.0, low=0.0), Unknown("size", 1.0)), (block,))
    found = solve(problem)
    standard = math.sqrt(covariance(problem, found).bread[0, 0])
    ends = interval(problem, found, 0, standard, standard)
    assert ends.kind == "profile"
    for end in (ends.low, ends.high):
        held = least_squares(lambda size, rate=end: block.residuals(np.array([rate, size[0]])), [1.0], xtol=1e-12)
        assert math.sqrt(2 * held.cost - found.cost) == pytest.approx(1.96, rel=0.1)


def test_limit_parabola_stays_where_it_is_right(line):
    design, y = line
    problem = line_problem(design, y, 0.1, (Unknown("a", 0.0), Unknown("b", 5.0)))
    found = solve(problem)
    u = math.sqrt(covariance(problem, found).bread[0, 0])
    ends = interval(problem, found, 0, u, u)
    assert ends.kind == "parabola"
    assert ends.high - ends.low == pytest.approx(2 * 1.96 * u, rel=1e-3)


def test_law_profile_does_not_hang_on_the_units_of_the_other_unknowns():
    """A straight model has the parabola for its profile; other units once cost directions, and the interval halved."""
    x = np.linspace(0, 1, 40)
    design = np.column_stack([np.ones_like(x), x, x**2]) * [1e6, 1.0, 1e-6]
    y = design @ [2e-6, -1.0, 1e6] + 0.1 * np.random.default_rng(4).standard_normal(40)
    unknowns = tuple(Unknown(name, 0.0, scale=scale) for name, scale in (("a", 1e-6), ("b", 1.0), ("d", 1e6)))
    problem = line_problem(design, y, 0.1, unknowns)
    found = solve(problem)
    for at, u in enumerate(np.sqrt(np.diag(covariance(problem, found).bread))):
        ends = interval(problem, found, at, u, u)
        assert ends.kind == "parabola"
        assert ends.high - ends.low == pytest.approx(2 * 1.96 * u, rel=1e-3)


def test_limit_range_that_ends_leaves_a_one_sided_bound():
    t = np.linspace(0, 1, 50)
    problem = exponential(np.exp(-0.01 * t), t, 0.5, 0.3)
    found = solve(problem)
    u = math.sqrt(covariance(problem, found).total[0, 0])
    ends = interval(problem, found, 0, u, u)
    assert (ends.kind, ends.low) == ("one-sided", None)
    assert ends.high == pytest.approx(found.point.theta[0] + 1.645 * u, rel=0.15)


def test_refusal_model_without_an_answer_is_a_value():
    block = Block("none", (0,), lambda theta: None, lambda theta: None, (), 0)
    found = solve(Problem((Unknown("a", 0.0),), (block,)))
    assert found.status == "failed"
    assert found.sentence == "the model has no answer at the start values"
