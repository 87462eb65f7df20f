"""Law and Monte Carlo agree for linear models, over every structure of inputs that a laboratory states."""

from math import inf, sqrt

import numpy as np
import pytest
from gum_models import knowledge
from hypothesis import given, settings
from hypothesis import strategies as st

from metrology import gum
from metrology.gum import Arcsine, CurvilinearTrapezoid, Normal, Rectangular, Student, Trapezoidal, Triangular
from metrology.gum.engine import simulate
from metrology.gum.law import propagate
from metrology.gum.monte_carlo import Plan

TRIALS = 60_000
SHAPES = {
    "normal": lambda u, nu: Normal(u),
    "student": lambda u, nu: Student(u, nu) if nu < inf else Normal(u),
    "rectangular": lambda u, nu: Rectangular(u),
    "triangular": lambda u, nu: Triangular(u),
    "trapezoidal": lambda u, nu: Trapezoidal(u, 0.5),
    "arcsine": lambda u, nu: Arcsine(u),
    "curvilinear": lambda u, nu: CurvilinearTrapezoid(u, 0.3 * u),
}
sizes = st.floats(0.2, 2.0)
freedom = st.sampled_from([6.0, 12.0, 30.0, inf])


@st.composite
def components(draw):
    """One to three components: readings and Type B in any mixture."""
    found = []
    for index in range(draw(st.integers(1, 3))):
        nu = draw(freedom)
        shape = SHAPES[draw(st.sampled_from(sorted(SHAPES)))](draw(sizes), nu)
        found.append(gum.Component(f"c{index}", shape, nu if isinstance(shape, Normal | Student) else inf))
    return tuple(found)


@st.composite
def structures(draw):
    """Two inputs read simultaneously, two correlated by statement, one alone; each with components of its own."""
    inputs = [gum.Input(name, draw(st.floats(-3, 3)), draw(components())) for name in "abcde"]
    s_a, s_b, r_ab = draw(sizes), draw(sizes), draw(st.floats(-0.95, 0.95))
    covariance = np.array([[s_a**2, r_ab * s_a * s_b], [r_ab * s_a * s_b, s_b**2]])
    ensembles = [gum.Ensemble("set", ("a", "b"), covariance, draw(st.sampled_from([6.0, 15.0])))]
    correlations = {("c", "d"): draw(st.floats(-0.6, 0.6))}
    coefficients = [draw(st.floats(-2, 2)) for _ in inputs]
    state = knowledge(
        *inputs,
        ensembles=ensembles if draw(st.booleans()) else [],
        correlations=correlations if draw(st.booleans()) else {},
    )
    return state, dict(zip("abcde", coefficients, strict=True))


def variance(state, coefficients, deviation, widen):
    """Variance of Σ c_i x_i from first principles; `deviation` of a component, `widen` of an ensemble's variance."""
    spread = {n: sqrt(sum(deviation(c) ** 2 for c in item.components)) for n, item in state.inputs.items()}
    total = sum((coefficients[name] * spread[name]) ** 2 for name in spread)
    for (p, q), r in state.correlations.items():
        total += 2 * r * coefficients[p] * coefficients[q] * spread[p] * spread[q]
    for ensemble in state.ensembles:
        c = np.array([coefficients[name] for name in ensemble.members])
        total += widen(ensemble.dof) * float(c @ ensemble.covariance @ c)
    return total


@pytest.mark.long
@given(structures())
@settings(max_examples=50, deadline=None, derandomize=True)
def test_twice_law_and_monte_carlo_agree_for_linear_models(structure):
    state, coefficients = structure
    linear = gum.Measurand("y", lambda q: sum(c * q[name] for name, c in coefficients.items()))
    law = propagate([linear], state)
    by_law = variance(state, coefficients, lambda c: c.u, lambda nu: 1.0)
    by_draws = variance(state, coefficients, lambda c: c.drawn.deviation, lambda nu: nu / (nu - 2))
    np.testing.assert_allclose(law.u(0), sqrt(by_law), rtol=1e-9, atol=1e-12)
    ((mc, _),) = simulate(law, state, Plan(0.95, 20261120, max_trials=TRIALS))
    u = sqrt(by_draws)
    value = sum(c * state.inputs[name].value for name, c in coefficients.items())
    np.testing.assert_allclose(mc.u, u, rtol=0.04, atol=1e-12)
    np.testing.assert_allclose(mc.mean, value, atol=5 * u / sqrt(mc.trials) + 1e-12)


@pytest.mark.long
@given(structures())
@settings(max_examples=30, deadline=None, derandomize=True)
def test_law_shares_of_every_structure_add_up_to_one(structure):
    state, coefficients = structure
    linear = gum.Measurand("y", lambda q: sum(c * q[name] for name, c in coefficients.items()))
    y = gum.evaluate([linear], state, seed=1, max_trials=2000).estimates["y"]
    if y.u > 0:
        assert abs(sum(row.share for row in y.budget) - 1) < 1e-9
        assert len(y.budget) == sum(len(i.components) for i in state.inputs.values()) + 2 * len(state.ensembles)
