import numpy as np
import pytest
from gum_models import knowledge, model, quantity

from metrology import gum
from metrology.errors import MetrologyError
from metrology.gum import Normal, Rectangular, Student

A, B, C = (quantity(name, 0.0, Normal(1.0)) for name in "abc")


def ensemble(*members, covariance=None, dof=4.0, name="set"):
    return gum.Ensemble(name, members, np.eye(len(members)) if covariance is None else np.array(covariance), dof)


def refused(inputs, models=(), **options):
    with pytest.raises(MetrologyError) as error:
        gum.evaluate(models, inputs, seed=options.pop("seed", 1), **options)
    return str(error.value).splitlines()


INPUTS = [
    (gum.Knowledge({"x": A}), "inputs['x']: got an input named 'a'; expected the name under which it is listed"),
    (knowledge(gum.Input("x", float("nan"))), "x: got nan; expected a finite value"),
    (
        knowledge(gum.Input("x", 0.0, (gum.Component("c", Normal(1.0), -1.0),))),
        "x.c.dof: got -1.0; expected degrees of freedom above zero",
    ),
    (
        knowledge(gum.Input("x", 0.0, (gum.Component("c", Student(1.0, 4), 5.0),))),
        "x.c.dof: got 5.0; expected those of its Student distribution, 4",
    ),
    (
        knowledge(gum.Input("x", 0.0, (gum.Component("c", Normal(1.0)), gum.Component("c", Normal(2.0))))),
        "x.c: got 2 components of that name; expected one name for each component",
    ),
]
ENSEMBLES = [
    (
        knowledge(A, ensembles=[ensemble("a", "z")]),
        "set.members: got 'z'; expected the name of an input. Fix: inputs are a",
    ),
    (
        knowledge(A, ensembles=[ensemble("a", dof=0.0)]),
        "set.dof: got 0.0; expected finite degrees of freedom above zero",
    ),
    (
        knowledge(A, B, ensembles=[ensemble("a", "b", covariance=[[1.0]])]),
        "set.covariance: got shape (1, 1); expected shape (2, 2), a row for each member",
    ),
    (
        knowledge(A, B, ensembles=[ensemble("a", "b", covariance=[[1.0, 0.5], [0.4, 1.0]])]),
        "set.covariance: got a matrix that is not symmetric; expected a symmetric matrix without negative eigenvalues",
    ),
    (
        knowledge(A, B, ensembles=[ensemble("a", "b", covariance=[[1.0, float("inf")], [0.4, 1.0]])]),
        "set.covariance: got an element that is not finite; expected a symmetric matrix without negative eigenvalues",
    ),
    (
        knowledge(A, B, ensembles=[ensemble("a", "b", covariance=[[1.0, 2.0], [2.0, 1.0]])]),
        "set.covariance: got a matrix with a negative eigenvalue (-1 relative to the variances);"
        " expected a symmetric matrix without negative eigenvalues",
    ),
    (
        knowledge(A, B, ensembles=[ensemble("a"), ensemble("b")]),
        "ensembles['set']: got 2 ensembles of that name; expected one name for each ensemble",
    ),
    (
        knowledge(A, ensembles=[ensemble("a"), ensemble("a", name="other")]),
        "a: got 2 places in ensembles; expected one place in one ensemble",
    ),
]
CORRELATIONS = [
    (
        knowledge(A, B, correlations={("a", "b"): 1.2}),
        "correlations['a', 'b']: got 1.2; expected a correlation coefficient from -1 to 1",
    ),
    (
        knowledge(A, B, correlations={("a", "b"): float("nan")}),
        "correlations['a', 'b']: got nan; expected a correlation coefficient from -1 to 1",
    ),
    (
        knowledge(A, correlations={("a", "a"): 0.5}),
        "correlations['a', 'a']: got an input with itself; expected two different inputs",
    ),
    (
        knowledge(A, correlations={("a", "z"): 0.5}),
        "correlations['a', 'z']: got 'z'; expected the name of an input. Fix: inputs are a",
    ),
    (
        knowledge(A, B, correlations={("a", "b"): 0.5}, ensembles=[ensemble("a")]),
        "correlations['a', 'b']: got 'a', whose correlation follows from the readings of 'set';"
        " expected an input that is in no ensemble",
    ),
    (
        knowledge(A, gum.Input("b", 1.0), correlations={("a", "b"): 0.5}),
        "correlations['a', 'b']: got 'b', whose u is 0; expected an input with an uncertainty",
    ),
    (
        knowledge(A, B, correlations={("a", "b"): 1.0}),
        "correlations: got a singular matrix for a, b (smallest eigenvalue 0); expected coefficients that can hold"
        " together. Fix: correct a coefficient; where inputs share their whole uncertainty, state one input and use it"
        " in both places",
    ),
    (
        knowledge(A, B, C, correlations={("a", "b"): 0.9, ("a", "c"): 0.9, ("b", "c"): -0.9}),
        "correlations: got an indefinite matrix for a, b, c (smallest eigenvalue -0.8); expected coefficients that can"
        " hold together. Fix: correct a coefficient; where inputs share their whole uncertainty, state one input and"
        " use it in both places",
    ),
]


@pytest.mark.parametrize(("inputs", "message"), [*INPUTS, *ENSEMBLES, *CORRELATIONS])
def test_refusal_names_the_entry(inputs, message):
    assert refused(inputs) == [message]


def test_refusal_of_a_pair_stated_twice():
    lines = refused(knowledge(A, B, correlations={("a", "b"): 0.5, ("b", "a"): 0.5}))
    assert lines == [
        f"correlations[{pair}]: got the same pair twice; expected each pair once" for pair in ("'a', 'b'", "'b', 'a'")
    ]


def test_refusal_tells_every_fault_at_once():
    inputs = knowledge(gum.Input("x", float("inf")), A, B, correlations={("a", "b"): 2.0})
    assert [line.split(":")[0] for line in refused(inputs)] == ["x", "correlations['a', 'b']"]


@pytest.mark.parametrize(
    ("models", "message"),
    [
        ([model("a"), model("b")], "y: got 2 measurands of that name; expected one name for each measurand"),
        ([model("b", "a")], "a: got a measurand with the name of an input; expected a name of its own"),
    ],
)
def test_refusal_of_ambiguous_measurands(models, message):
    assert message in refused(knowledge(A, B), models)


def test_refusal_of_an_unknown_name_in_an_equation():
    unknown = gum.Measurand("y", lambda q: q["a"] + q["z"])
    assert refused(knowledge(A), [unknown]) == [
        "y: got an equation that reads 'z'; expected inputs, or measurands that come before it"
    ]


def test_refusal_of_arguments():
    lines = refused(knowledge(A), probability=1.0, seed=-1, digits=0, max_trials=10)
    assert lines == [
        "probability: got 1.0; expected a probability above 0 and below 1, such as 0.95",
        "seed: got -1; expected a whole number, zero or more",
        "digits: got 0; expected 1, 2, 3 or 4 significant digits",
        "max_trials: got 10; expected at least 1000 trials",
    ]


@pytest.mark.parametrize(
    ("a", "b", "r", "got"),
    [
        (Normal(1.0), Rectangular(1.0), 0.98, "r = 0.98 between a.c0 (normal) and b.c0 (rectangular)"),
        (
            Student(1.0, 2),
            Normal(1.0),
            0.5,
            "a correlation stated for a, known with two degrees of freedom or fewer",
        ),
    ],
)
def test_refusal_of_a_correlation_that_draws_cannot_have(a, b, r, got):
    inputs = knowledge(quantity("a", 0.0, a), quantity("b", 0.0, b), correlations={("a", "b"): r})
    (line,) = refused(inputs, [model("a + b")])
    assert line.startswith(f"correlations: got {got}; expected ")


def test_refusal_of_correlations_that_cannot_hold_together_for_their_distributions():
    names = "abcd"
    inputs = [quantity(name, 0.0, Rectangular(1.0)) for name in names]
    # Just inside positive definite as stated, outside once turned into those of the latent normals.
    pairs = {(p, q): -0.3332 for i, p in enumerate(names) for q in names[i + 1 :]}
    (line,) = refused(knowledge(*inputs, correlations=pairs), [model("a + b + c + d")])
    assert line.startswith(
        "correlations: got coefficients for a, b, c, d that their distributions cannot have together"
    )
