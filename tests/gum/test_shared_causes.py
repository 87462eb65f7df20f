"""Components that share a cause: one unknown value, in the size that each input has of it."""

from math import sqrt

import pytest
from gum_models import model

from metrology.errors import MetrologyError
from metrology.gum import Normal, Rectangular, Student, evaluate
from metrology.gum.inputs import Component, Input, Knowledge


def quantity(name, value, *components):
    return Input(name, value, tuple(Component(f"part {i}", *one) for i, one in enumerate(components)))


def shared(distribution, cause="micrometer", dof=float("inf")):
    return distribution, dof, "B", "", cause


def knowledge(*inputs, **more):
    return Knowledge({item.name: item for item in inputs}, **more)


MODELS = [model("a + b", "s"), model("a - b", "d"), model("3*a - 2*b", "w"), model("a*b", "p")]


def evaluated(inputs, **options):
    return evaluate(MODELS, inputs, seed=7, digits=3, **options).estimates


def test_closed_form_sum_difference_and_weighted_difference():
    inputs = knowledge(
        quantity("a", 1.0, shared(Normal(0.02)), (Normal(0.01),)), quantity("b", 2.0, shared(Normal(0.03)))
    )
    found = evaluated(inputs)
    assert found["s"].u == pytest.approx(sqrt(0.05**2 + 0.01**2))
    assert found["d"].u == pytest.approx(sqrt(0.01**2 + 0.01**2))
    assert found["w"].u == pytest.approx(0.03)  # 3 × 0.02 − 2 × 0.03 = 0: the cause drops out
    for one in found.values():
        assert one.monte_carlo.u == pytest.approx(one.u, rel=0.01)
        assert sum(row.share for row in one.budget) == pytest.approx(1.0)


@pytest.mark.long
@pytest.mark.parametrize("distribution", [Rectangular, Normal, lambda size: Student(size, 4.0)])
def test_twice_a_cause_that_is_an_input_of_its_own_gives_the_same(distribution):
    cause = shared(distribution(0.1), dof=4.0 if isinstance(distribution(0.1), Student) else float("inf"))
    double = shared(distribution(0.2), dof=cause[1])
    by_cause = evaluated(knowledge(quantity("a", 1.0, cause), quantity("b", 2.0, double)))
    own = evaluate(
        [model("(1 + z) + (2 + 2*z)", "s"), model("(1 + z)*(2 + 2*z)", "p")],
        knowledge(quantity("z", 0.0, cause[:2])), seed=7, digits=3,
    ).estimates  # fmt: skip
    for name in own:
        assert by_cause[name].u == pytest.approx(own[name].u)
        assert by_cause[name].dof == pytest.approx(own[name].dof)
        for end in ("low", "high", "mean"):
            ours, theirs = getattr(by_cause[name].monte_carlo, end), getattr(own[name].monte_carlo, end)
            assert ours == pytest.approx(theirs, abs=0.02 * own[name].u)


def test_law_a_cause_used_once_changes_nothing():
    with_cause = evaluated(knowledge(quantity("a", 1.0, shared(Normal(0.1))), quantity("b", 2.0, (Normal(0.2),))))
    without = evaluated(knowledge(quantity("a", 1.0, (Normal(0.1),)), quantity("b", 2.0, (Normal(0.2),))))
    assert {name: one.u for name, one in with_cause.items()} == {name: one.u for name, one in without.items()}
    # Another campaign that takes the result by its budget shares the cause by its name.
    assert {row.cause for one in with_cause.values() for row in one.budget} == {"micrometer", ""}


def test_law_advice_speaks_of_the_cause_not_of_one_of_its_inputs():
    found = evaluated(knowledge(quantity("a", 1.0, shared(Normal(0.1))), quantity("b", 2.0, shared(Normal(0.1)))))
    assert "micrometer, shared by a, b, has the largest part in u(s), 100%" in found["s"].advice
    assert "would have to fall to 50%" in found["s"].advice


@pytest.mark.parametrize(
    ("inputs", "expected"),
    [
        (
            knowledge(quantity("a", 1.0, shared(Normal(0.1))), quantity("b", 1.0, shared(Rectangular(0.1)))),
            "one distribution",
        ),
        (
            knowledge(quantity("a", 1.0, shared(Student(0.1, 4.0), dof=4.0)), quantity("b", 1.0, shared(Normal(0.1)))),
            "one distribution",
        ),
        (
            knowledge(quantity("a", 1.0, shared(Normal(0.1)), shared(Normal(0.2))), quantity("b", 1.0)),
            "one component of each cause",
        ),
        (
            knowledge(
                quantity("a", 1.0, shared(Normal(0.1))),
                quantity("b", 1.0, shared(Normal(0.1))),
                correlations={("a", "b"): 0.5},
            ),
            "inputs without a shared cause",
        ),
    ],
)
def test_refusal_of_causes_that_cannot_be_one_variable(inputs, expected):
    with pytest.raises(MetrologyError, match=expected):
        evaluated(inputs)
