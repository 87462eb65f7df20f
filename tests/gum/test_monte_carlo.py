from math import isfinite, isnan, sqrt

import numpy as np
import pytest
from gum_models import knowledge, model, quantity
from scipy import stats

from metrology import gum
from metrology.gum import Arcsine, CurvilinearTrapezoid, Normal, Rectangular, Student, Trapezoidal, Triangular, engine
from metrology.gum.copula import latent
from metrology.gum.intervals import intervals, ranks, symmetric
from metrology.gum.law import propagate
from metrology.gum.monte_carlo import HIGH, LOW, Plan, moments, run, scatter
from metrology.gum.sampling import sampler


def draws(inputs, trials=200_000, seed=5):
    drawn = sampler(inputs, propagate([model("+".join(inputs.inputs))], inputs).joint)
    return drawn.draw(np.random.Generator(np.random.SFC64(seed)), trials)


def trials_of(models, inputs, **plan):
    law = propagate(models, inputs)
    return run(models, sampler(inputs, law.joint), Plan(0.95, **plan), lambda _: 1e9)


NONLINEAR = knowledge(
    quantity("a", 1.0, Normal(0.1), Rectangular(0.2), dof=(4,)),
    quantity("b", 2.0, Arcsine(0.3)),
    quantity("c", 0.0, Triangular(0.1)),
    gum.Input("v", 3.0),
    gum.Input("w", 4.0),
    ensembles=[gum.Ensemble("set", ("v", "w"), np.array([[0.01, 0.004], [0.004, 0.02]]), 6.0)],
    correlations={("b", "c"): 0.4},
)


def test_twice_results_do_not_depend_on_the_number_of_threads():
    models = [model("a*b/v + c*w", "y"), model("sqrt(y + 10)", "z")]
    one, three = (trials_of(models, NONLINEAR, seed=11, max_trials=60_000, threads=n) for n in (1, 3))
    np.testing.assert_array_equal(one.outputs, three.outputs)
    np.testing.assert_array_equal(one.batches, three.batches)
    assert not np.array_equal(one.outputs, trials_of(models, NONLINEAR, seed=12, max_trials=60_000).outputs)


def test_twice_trials_made_in_two_goes_are_those_made_in_one():
    models = [model("a*b")]
    law = propagate(models, NONLINEAR)
    factors = iter([1.7, 1.0])
    inputs = sampler(NONLINEAR, law.joint)
    twice = run(models, inputs, Plan(0.95, 3, max_trials=200_000), lambda _: next(factors))
    once = run(models, inputs, Plan(0.95, 3, max_trials=twice.number), lambda _: 1e9)
    np.testing.assert_array_equal(twice.outputs, once.outputs)


def test_twice_moments_of_blocks_are_those_of_all_draws():
    found = trials_of([model("a*b")], NONLINEAR, seed=2, max_trials=50_000)
    mean, u = moments(found.batches[:, 0], 5_000)
    assert mean == pytest.approx(found.outputs[0].mean(), rel=1e-13)
    assert u == pytest.approx(found.outputs[0].std(ddof=1), rel=1e-12)


def test_law_adaptive_procedure_stops_when_two_digits_stand():
    linear = knowledge(quantity("a", 0.0, Normal(1.5)))
    mc = gum.evaluate([model("a")], linear, seed=4).estimates["y"].monte_carlo
    assert mc.converged
    assert mc.trials < 200_000
    assert mc.tolerance == 0.05
    assert mc.law_valid
    assert mc.verdict.startswith(
        "The GUM uncertainty framework is confirmed: its interval differs from the Monte Carlo one by"
    )
    finer = gum.evaluate([model("a")], linear, seed=4, digits=3, max_trials=300_000).estimates["y"].monte_carlo
    assert finer.trials == 300_000
    assert not finer.converged
    assert "not stable to the digits asked for" in finer.verdict
    assert "inconclusive" in finer.verdict
    assert gum.evaluate([model("a")], linear, seed=4, digits=1).estimates["y"].monte_carlo.trials == 100_000


def test_law_adaptive_procedure_waits_for_the_slowest_output():
    inputs = knowledge(quantity("a", 0.0, Normal(1.0)), quantity("b", 0.0, Normal(9.4)))
    alone = gum.evaluate([model("a")], inputs, seed=4).estimates["y"].monte_carlo
    both = gum.evaluate([model("a"), model("b", "z")], inputs, seed=4).estimates
    assert both["y"].monte_carlo.trials == both["z"].monte_carlo.trials > alone.trials


def test_closed_form_scatter_shrinks_with_the_blocks():
    batches = np.zeros((4, 4))
    batches[:, LOW] = [1.0, 2.0, 3.0, 4.0]
    assert scatter(batches)[LOW] == pytest.approx(2 * np.std([1, 2, 3, 4], ddof=1) / 2)
    assert scatter(batches)[HIGH] == 0


def test_limit_blocks_of_high_probability_hold_a_hundred_draws_beyond_the_ends():
    assert Plan(0.95, 1).block == 10_000
    assert Plan(0.999, 1).block == 100_000
    assert Plan(0.9999, 1).block == 100_000
    assert Plan(0.95, 1, max_trials=2_000).block == 200


@pytest.mark.parametrize("readings", [(-1.0, 1.0), (-1.0, 0.0, 1.0)])
def test_limit_no_scale_for_the_tolerance_where_the_law_is_blind_and_no_deviation_exists(readings):
    inputs = gum.Knowledge({"x": gum.observed("x", readings)})
    y = gum.evaluate([model("x**2")], inputs, seed=1).estimates["y"].monte_carlo
    assert isnan(y.tolerance)
    assert not y.law_valid
    assert "not valid here" in y.verdict
    # x = s·t with ν = n − 1, so that y/s² is of the F distribution with 1 and ν degrees of freedom.
    n = len(readings)
    assert y.high == pytest.approx(np.var(readings, ddof=1) / n * stats.f.ppf(0.975, 1, n - 1), rel=0.05)


def test_closed_form_blind_law_is_noticed():
    inputs = knowledge(quantity("a", 0.0, Normal(2.0)), quantity("b", 0.0, Normal(3.0)))
    y = gum.evaluate([model("a*b")], inputs, seed=1).estimates["y"]
    assert y.u == 0
    assert (y.dof, y.dof_note) == (None, "undefined: the GUM uncertainty framework gives u = 0")
    assert y.monte_carlo.u == pytest.approx(6.0, rel=0.01)
    assert not y.monte_carlo.law_valid
    assert y.monte_carlo.verdict.startswith(
        "The GUM uncertainty framework is not valid here: every sensitivity is zero"
    )
    assert (y.coverage.k, y.advice) == (None, "")


def test_planted_failing_draws_are_counted_and_told():
    inputs = knowledge(quantity("a", 1.0, Normal(1.0)), quantity("b", 1.0, Normal(0.1)))
    estimates = gum.evaluate([model("sqrt(a)", "root"), model("b", "fine")], inputs, seed=1).estimates
    root = estimates["root"].monte_carlo
    assert all(isnan(x) for x in (root.mean, root.u, root.low, root.high, root.shortest_low, root.shortest_high))
    assert not root.converged
    assert not root.law_valid
    count = int(root.verdict.split(" of ")[0])
    assert count / root.trials == pytest.approx(stats.norm.cdf(-1), abs=0.01)
    assert "trials gave no finite number: the equation has no value over the whole range of its inputs" in root.verdict
    assert estimates["fine"].monte_carlo.law_valid


def test_planted_failure_of_every_trial_is_told():
    # A function of numbers alone fails in the draws as in the law.
    inputs = knowledge(quantity("a", 1.0, Normal(1.0)), gum.Input("zero", 0.0))
    y = gum.evaluate([model("a + 1/zero")], inputs, seed=1, max_trials=10_000).estimates["y"]
    assert y.monte_carlo.verdict.startswith(
        "The equation has no value at the estimates of its inputs (float division by zero). 10000 of 10000 trials"
    )


@pytest.mark.parametrize("dof", [1.0, 2.0, 3.0, 7.5])
def test_limit_few_degrees_of_freedom_have_an_interval_even_without_a_deviation(dof):
    y = gum.evaluate([model("a")], knowledge(quantity("a", 10.0, Normal(2.0), dof=(dof,))), seed=3).estimates["y"]
    end = 2.0 * stats.t.ppf(0.975, dof)
    assert (y.coverage.low, y.coverage.high) == pytest.approx((10 - end, 10 + end))
    mc = y.monte_carlo
    assert (mc.low, mc.high) == pytest.approx((10 - end, 10 + end), abs=0.02 * end if dof > 1 else 0.05 * end)
    assert mc.law_valid
    if dof > 2:
        assert mc.u == pytest.approx(2.0 * sqrt(dof / (dof - 2)), rel=0.05)
    else:
        assert mc.u == float("inf")
        assert isnan(mc.mean) is (dof <= 1)
        assert f"Readings with ν = {dof:g} enter" in mc.verdict


def test_closed_form_ensemble_draws_share_their_chi_squared():
    covariance = np.array([[4.0, 1.5], [1.5, 1.0]])
    inputs = knowledge(
        gum.Input("a", 1.0), gum.Input("b", 2.0), ensembles=[gum.Ensemble("set", ("a", "b"), covariance, 9.0)]
    )
    drawn = draws(inputs)
    np.testing.assert_allclose(np.cov(drawn["a"], drawn["b"]), covariance * 9 / 7, rtol=0.03)
    combined = (drawn["a"] - 1) - 3 * (drawn["b"] - 2)
    scale = sqrt(4 + 9 - 2 * 3 * 1.5)
    assert stats.kstest(combined[:40_000] / scale, stats.t(9).cdf).pvalue > 1e-3
    # Uncorrelated combinations of a multivariate t still scatter together.
    rotated = (drawn["a"] - 1) - 1.5 * (drawn["b"] - 2)
    assert np.corrcoef(rotated**2, (drawn["b"] - 2) ** 2)[0, 1] > 0.05


def test_limit_ensemble_with_a_singular_covariance_keeps_its_relation():
    covariance = np.array([[1.0, 2.0], [2.0, 4.0]])
    inputs = knowledge(
        gum.Input("a", 0.0), gum.Input("b", 0.0), ensembles=[gum.Ensemble("set", ("a", "b"), covariance, 5.0)]
    )
    drawn = draws(inputs, 100)
    np.testing.assert_allclose(drawn["b"], 2 * drawn["a"], atol=1e-6)


@pytest.mark.parametrize(
    ("first", "second", "r"),
    [
        ((Normal(1.0),), (Normal(2.0),), 0.9),
        ((Rectangular(1.0),), (Rectangular(3.0),), -0.7),
        ((Triangular(1.0),), (Arcsine(3.0),), 0.5),
        ((Trapezoidal(1.0, 0.3),), (CurvilinearTrapezoid(3.0, 1.0),), 0.95),
        ((Student(1.0, 7.0),), (Rectangular(3.0),), 0.6),
        ((Normal(1.0), Rectangular(2.0)), (Normal(1.5), Triangular(1.0), Arcsine(0.5)), 0.8),
    ],
)
def test_twice_draws_have_the_correlation_stated(first, second, r):
    inputs = knowledge(quantity("a", 1.0, *first), quantity("b", 2.0, *second), correlations={("a", "b"): r})
    drawn = draws(inputs, 400_000)
    assert np.corrcoef(drawn["a"], drawn["b"])[0, 1] == pytest.approx(r, abs=0.006)
    for name in "ab":
        parts = inputs.inputs[name].components
        assert drawn[name].std() == pytest.approx(sqrt(sum(c.drawn.deviation**2 for c in parts)), rel=0.01)
    if len(first) == 1:
        sample = drawn["a"][:20_000] - 1.0
        p = np.array([0.05, 0.5, 0.9])
        np.testing.assert_allclose((sample[:, None] < first[0].quantile(p)).mean(axis=0), p, atol=0.012)


@pytest.mark.parametrize("r", [-0.999, -0.3, 0.2, 0.99])
def test_closed_form_latent_correlation_of_rectangles(r):
    assert latent(Rectangular(1.0), Rectangular(7.0), r) == pytest.approx(2 * np.sin(np.pi * r / 6), abs=1e-9)


def test_limit_latent_correlation_at_the_edge_of_reach():
    assert latent(Rectangular(1.0), Rectangular(1.0), 1.0) == 1.0
    assert latent(Rectangular(1.0), Rectangular(1.0), -1.0) == -1.0
    assert latent(Normal(1.0), Rectangular(1.0), 0.98) is None
    assert latent(Normal(1.0), Rectangular(1.0), 0.97) == pytest.approx(0.97 / sqrt(3 / np.pi), rel=1e-6)


@pytest.mark.parametrize("p", [0.2, 0.5, 0.95, 0.99])
def test_twice_intervals_agree_with_a_full_sort(p):
    values = np.random.default_rng(3).gamma(2.0, size=20_001)
    ordered = np.sort(values)
    inside, first = ranks(values.size, p)
    widths = ordered[inside:] - ordered[: values.size - inside]
    best = widths.argmin()
    found = intervals(values.copy(), p)
    assert (found.low, found.high) == (ordered[first], ordered[first + inside])
    assert symmetric(values.copy(), p) == (found.low, found.high)
    assert (found.shortest_low, found.shortest_high) == (ordered[best], ordered[best + inside])


def test_law_histogram_is_a_density():
    mc = gum.evaluate([model("a*b/v + c*w")], NONLINEAR, seed=1, max_trials=50_000).estimates["y"].monte_carlo
    assert len(mc.edges) == len(mc.density) + 1
    assert np.sum(np.diff(mc.edges) * mc.density) == pytest.approx(0.998, abs=1e-3)
    assert mc.edges[0] < mc.low < mc.high < mc.edges[-1]


def test_limit_inputs_that_no_measurand_reads_are_not_drawn():
    alone = knowledge(quantity("a", 0.0, Normal(1.0)))
    more = knowledge(quantity("z", 0.0, Normal(1.0)), quantity("a", 0.0, Normal(1.0)))
    results = [gum.evaluate([model("a")], inputs, seed=1).estimates["y"].monte_carlo for inputs in (alone, more)]
    # The test's model reads every name; only what an equation reads itself counts.
    reading = gum.Measurand("y", lambda q: q["a"])
    lean = [gum.evaluate([reading], inputs, seed=1).estimates["y"].monte_carlo for inputs in (alone, more)]
    assert lean[0] == lean[1]
    assert results[0] != results[1]


def test_closed_form_plan_without_adaptation_makes_every_trial():
    models, plan = [model("a*b")], Plan(0.95, 1, max_trials=30_000, adaptive=False)
    found = run(models, sampler(NONLINEAR, propagate(models, NONLINEAR).joint), plan, lambda _: 0.0)
    assert found.number == 30_000
    assert found.batches.shape == (10, 1, 6)


@pytest.mark.parametrize("readings", [(9.9, 10.3), (9.9, 10.1, 10.3)])
def test_limit_law_with_an_u_is_not_called_blind_where_the_draws_have_none(readings):
    inputs = gum.Knowledge({"x": gum.observed("x", readings)})
    y = gum.evaluate([model("x")], inputs, seed=1).estimates["y"]
    assert y.u > 0
    assert not isfinite(y.monte_carlo.u)
    # One mean of readings: the interval by Student's t is exact, and the trials cannot but agree.
    assert y.monte_carlo.verdict.startswith("The GUM uncertainty framework is ")
    assert "not valid here" not in y.monte_carlo.verdict
    assert y.monte_carlo.law_valid
    assert "the standard deviation of the draws does not exist" in y.monte_carlo.verdict


def test_limit_draws_of_many_outputs_stay_within_their_memory(monkeypatch):
    monkeypatch.setattr(engine, "MEMORY", 8 * 20_000 * 3)
    models = [model("a*b", "y"), model("a + b", "z"), model("a - b", "x")]
    found = gum.evaluate(models, NONLINEAR, seed=3, digits=2)
    made = found.estimates["y"].monte_carlo
    assert made.trials == 20_000
    assert not made.converged
