from math import inf, isnan, sqrt

import numpy as np
import pytest
from gum_models import knowledge, model, quantity

from metrology import gum
from metrology.gum import Arcsine, Normal, Rectangular, Student
from metrology.gum.law import propagate


def law_of(models, inputs):
    return propagate(models if isinstance(models, list) else [models], inputs)


def test_closed_form_correlated_inputs():
    inputs = knowledge(quantity("a", 1.0, Normal(3.0)), quantity("b", 2.0, Normal(4.0)), correlations={("a", "b"): 0.5})
    assert law_of(model("a + b"), inputs).u(0) == pytest.approx(sqrt(9 + 16 + 12))
    assert law_of(model("a - b"), inputs).u(0) == pytest.approx(sqrt(9 + 16 - 12))


def test_closed_form_correlation_of_inputs_with_several_components_is_the_one_stated():
    inputs = knowledge(
        quantity("a", 1.0, Normal(3.0), Rectangular(2.0), Normal(0.0)),
        quantity("b", 2.0, Normal(4.0), Arcsine(1.0)),
        correlations={("a", "b"): -0.8},
    )
    u_a, u_b = inputs.inputs["a"].u, inputs.inputs["b"].u
    law = law_of(model("2*a + b"), inputs)
    assert law.u(0) ** 2 == pytest.approx(4 * u_a**2 + u_b**2 - 4 * 0.8 * u_a * u_b)
    rows_a, rows_b = law.joint.of_input("a"), law.joint.of_input("b")
    for rows in (rows_a, rows_b):
        np.testing.assert_array_equal(law.joint.correlation[np.ix_(rows, rows)], np.eye(len(rows)))
    assert np.linalg.eigvalsh(law.joint.correlation)[0] > -1e-12


def test_law_shares_add_up_to_one_and_cross_terms_are_split_evenly():
    inputs = knowledge(
        quantity("a", 1.0, Normal(3.0)), quantity("b", 2.0, Normal(1.0)), correlations={("a", "b"): -0.9}
    )
    rows = gum.evaluate([model("a + b")], inputs, seed=1).estimates["y"].budget
    variance = 9 + 1 - 2 * 0.9 * 3
    assert [row.share for row in rows] == pytest.approx([(9 - 2.7) / variance, (1 - 2.7) / variance])
    assert rows[1].share < 0


def test_closed_form_outputs_that_share_an_input_are_correlated():
    inputs = knowledge(quantity("k", 10.0, Normal(1.0)), quantity("L", 2.0, Normal(0.5)))
    models = [model("k*L", "E"), model("k", "again"), model("E/again", "length"), model("3.0", "number")]
    evaluation = gum.evaluate(models, inputs, seed=1)
    r = evaluation.correlation
    assert r[0][1] == pytest.approx(2.0 / sqrt(4 + 25))
    assert r[1][2] == pytest.approx(0.0, abs=1e-12)
    assert [r[i][i] for i in range(4)] == [1.0, 1.0, 1.0, None]
    assert evaluation.estimates["length"].u == pytest.approx(0.5)
    assert evaluation.names == ("E", "again", "length", "number")


def test_closed_form_welch_satterthwaite():
    inputs = knowledge(quantity("a", 0, Normal(2.0), dof=(5,)), quantity("b", 0, Normal(1.0), Normal(1.0), dof=(10,)))
    dof, note = law_of(model("a + b"), inputs).dof(0)
    assert dof == pytest.approx(36 / (16 / 5 + 1 / 10))
    assert note == ""


def test_closed_form_ensemble_is_one_contribution_beside_others():
    means, ensemble = gum.simultaneous("set", {"a": [1.0, 2.0, 4.0, 3.0], "b": [2.0, 1.0, 1.5, 4.0]})
    inputs = knowledge(
        quantity("a", means["a"], Normal(0.3)),
        gum.Input("b", means["b"]),
        quantity("c", 0, Normal(0.5), dof=(7,)),
        ensembles=[ensemble],
    )
    law = law_of(model("a - 2*b + c"), inputs)
    sums = np.array([1.0, 2.0, 4.0, 3.0]) - 2 * np.array([2.0, 1.0, 1.5, 4.0])
    readings = sums.var(ddof=1) / 4
    assert law.u(0) ** 2 == pytest.approx(readings + 0.09 + 0.25)
    assert law.dof(0)[0] == pytest.approx(law.u(0) ** 4 / (readings**2 / 3 + 0.25**2 / 7))


def test_limit_ensemble_member_that_cancels_leaves_infinite_degrees_of_freedom():
    means, ensemble = gum.simultaneous("set", {"a": [1.0, 2.0, 3.0], "b": [11.0, 12.0, 13.0]})
    inputs = knowledge(
        *(gum.Input(k, v) for k, v in means.items()), quantity("c", 0, Normal(1.0)), ensembles=[ensemble]
    )
    law = law_of(model("a - b + c"), inputs)
    assert law.u(0) == pytest.approx(1.0)
    assert law.dof(0)[0] is None or law.dof(0)[0] > 1e12


def test_refusal_of_degrees_of_freedom_for_a_stated_correlation_with_few_readings():
    inputs = knowledge(
        quantity("a", 0, Normal(1.0), dof=(5,)), quantity("b", 0, Normal(1.0)), correlations={("a", "b"): 0.5}
    )
    y = gum.evaluate([model("a + b")], inputs, seed=1).estimates["y"]
    assert y.u == pytest.approx(sqrt(3))
    assert y.dof is None
    assert y.dof_note.startswith("undefined: a correlation is stated for a, of finite degrees of freedom; the Welch")
    assert (y.coverage.k, y.coverage.low, y.coverage.high) == (None, None, None)
    assert not y.monte_carlo.law_valid
    assert y.monte_carlo.d_low is None
    assert y.monte_carlo.verdict.startswith(
        "The GUM uncertainty framework gives no interval to compare; degrees of freedom are undefined"
    )


def test_limit_correlation_that_does_not_enter_leaves_degrees_of_freedom_defined():
    inputs = knowledge(
        quantity("a", 0, Normal(1.0), dof=(5,)), quantity("b", 0, Normal(1.0)), correlations={("a", "b"): 0.5}
    )
    assert law_of(model("a + 0*b"), inputs).dof(0)[0] == pytest.approx(5)
    infinite = knowledge(
        quantity("a", 0, Normal(1.0)),
        quantity("b", 0, Normal(1.0)),
        quantity("c", 0, Normal(1.0), dof=(4,)),
        correlations={("a", "b"): 0.5},
    )
    assert law_of(model("a + b + c"), infinite).dof(0)[0] == pytest.approx(16 * 4)


def test_closed_form_student_brings_its_own_degrees_of_freedom():
    assert gum.Component("x", Student(1.0, 4)).dof == 4
    assert gum.Component("x", Normal(1.0)).dof == inf
    assert gum.Component("x", Normal(2.0), 4).drawn == Student(2.0, 4)


def test_law_failure_is_a_value_with_a_sentence():
    inputs = knowledge(quantity("a", 0.0, Normal(1.0)))
    models = [model("1/a", "inverse"), model("sqrt(a)", "root"), model("log(a)", "log"), model("inverse + 1", "after")]
    estimates = gum.evaluate(models, inputs, seed=1, max_trials=10_000).estimates
    assert isnan(estimates["inverse"].value)
    assert estimates["root"].value == 0.0
    assert all(isnan(estimate.u) for estimate in estimates.values())
    assert estimates["inverse"].dof_note == (
        "undefined: The equation has no value at the estimates of its inputs (float division by zero)."
    )
    assert estimates["root"].dof_note == "undefined: The derivative with respect to a does not exist at the estimates."
    assert estimates["after"].dof_note == "undefined: The equation has no finite value at the estimates."
    assert estimates["inverse"].coverage.low is None
    assert not any(estimate.monte_carlo.law_valid for estimate in estimates.values())
    assert all(row.share == 0 for row in estimates["root"].budget)
    assert estimates["root"].advice == ""


def test_model_that_asks_for_a_name_with_a_default_reads_what_there_is():
    inputs = knowledge(quantity("a", 3.0, Normal(1.0)))
    law = law_of(gum.Measurand("y", lambda q: q["a"] * q.get("factor", 2.0)), inputs)
    assert law.u(0) == pytest.approx(2.0)
    assert law.linear[0].reads == {"a"}


def test_limit_of_no_uncertainty_at_all():
    y = gum.evaluate([model("2*a")], knowledge(gum.Input("a", 3.0)), seed=1).estimates["y"]
    assert (y.value, y.u, y.monte_carlo.u, y.budget) == (6.0, 0.0, 0.0, ())
    assert (y.coverage.low, y.coverage.high) == (6.0, 6.0)
    assert y.monte_carlo.law_valid
    assert y.monte_carlo.verdict == "The uncertainty is zero by the GUM uncertainty framework and by Monte Carlo."
    assert (y.monte_carlo.edges, y.monte_carlo.density) == ((6.0,), ())


def test_limit_no_measurands():
    assert gum.evaluate([], knowledge(), seed=1).names == ()


def test_law_budget_keeps_the_degrees_of_freedom_of_each_component() -> None:
    inputs = knowledge(quantity("a", 0, Normal(2.0), dof=(5,)), quantity("b", 0, Normal(1.0)))
    found = gum.evaluate([model("a + b")], inputs, seed=1, max_trials=1000)
    (estimate,) = found.estimates.values()
    assert {row.input: row.dof for row in estimate.budget} == {"a": 5, "b": None}
