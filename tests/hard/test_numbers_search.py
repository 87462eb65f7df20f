"""The search of the identification on the nonlinear Statistical Reference Datasets of NIST.

What `gum.regression.curve` gives in ten digits (`test_numbers_strd`) the search must reach as well, or say that it
stalled: a valley so long that the steps are used up is no minimum.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import certified
import numpy as np
import pytest
import strd
import strd_long
from certified import numbers

from metrology.estimation.problem import Array, Block, Problem, Segment, Unknown, evaluate
from metrology.estimation.solver import solve
from metrology.expression import Expression

NONLINEAR = {**certified.NONLINEAR, **strd.NONLINEAR, **strd_long.NONLINEAR}

PLATEAUS = {("BoxBOD", 0), ("MGH17", 0), ("MGH10", 0)}
"""Far starts from which the first steps run to where an exponential is lost in rounding: flat, and so a minimum."""

STALLED = {("Eckerle4", 0)}
"""A start from which the peak lies beyond all readings: no step of any damping leads back to it."""

SETS = [(name, start) for name in NONLINEAR for start in (0, 1) if (name, start) not in PLATEAUS]


def names(count: int) -> list[str]:
    return [f"b{i}" for i in range(1, count + 1)]


def problem(name: str, start: int) -> Problem:
    """A set as the search takes it: residuals weighted with the certified standard deviation, no prior, no bound."""
    model, x_text, y_text, starts, *_, s = NONLINEAR[name]
    x, y, u = np.array(numbers(x_text)), np.array(numbers(y_text)), float(s)
    begin, expression = starts[start], Expression.parse(model)

    def at(theta: Sequence[complex]) -> Any:
        with np.errstate(all="ignore"):
            found = expression.evaluate({"x": x, **dict(zip(names(len(theta)), theta, strict=True))})
        return np.broadcast_to(found, x.shape)

    def residuals(theta: Array) -> Array | None:
        try:
            found = (y - at(list(theta))) / u
        except (ArithmeticError, ValueError):
            return None
        return found if np.all(np.isfinite(found)) else None

    def derivatives(theta: Array) -> Array:
        moved = [[complex(v, 1e-100 * (i == j)) for i, v in enumerate(theta)] for j in range(len(theta))]
        return -np.column_stack([np.imag(at(values)) for values in moved]) / 1e-100 / u

    unknowns = tuple(Unknown(key, float(value)) for key, value in zip(names(len(begin)), begin, strict=True))
    block = Block(name, tuple(range(len(begin))), residuals, derivatives, (Segment("y", 0, len(y)),), len(y))
    return Problem(unknowns, (block,))


def off(name: str, theta: Array) -> float:
    """Largest distance from the certified values, in certified standard deviations."""
    *_, values, deviations, _ = NONLINEAR[name]
    return float(np.max(np.abs(theta - numbers(values)) / numbers(deviations)))


@pytest.mark.parametrize(("name", "start"), SETS)
def test_law_a_search_that_says_converged_is_at_the_certified_minimum(name: str, start: int) -> None:
    found = solve(problem(name, start))
    assert found.point is not None
    assert found.status != "converged" or off(name, found.point.theta) < 1e-3
    if found.status != "converged":
        assert "not converged" in found.sentence


@pytest.mark.parametrize(("name", "start"), [entry for entry in SETS if entry not in STALLED])
def test_reference_search_from_both_starts(name: str, start: int) -> None:
    found = solve(problem(name, start), close=1e-10, steps=200)
    assert found.point is not None
    assert found.status == "converged"
    assert off(name, found.point.theta) < 1e-6


def test_limit_residuals_beyond_the_largest_square_are_no_answer() -> None:
    block = Block("far", (0,), lambda at: at * 1e200, lambda _: np.full((1, 1), 1e200), (Segment("y", 0, 1),), 1)
    assert evaluate(Problem((Unknown("a", 1.0),), (block,)), np.ones(1)) is None


def test_law_a_search_ends_where_rounding_hides_the_rest() -> None:
    """Residuals that move in steps of 1e-9: whatever is closer than that is the minimum, and no reason to go on."""

    def residuals(theta: Array) -> Array:
        return np.array([4.0, np.round((theta[0] - 1.0) / 1e-9) * 1e-9 + 3e-10])

    block = Block("coarse", (0,), residuals, lambda _: np.array([[0.0], [1.0]]), (Segment("y", 0, 2),), 2)
    found = solve(Problem((Unknown("a", 1.7),), (block,)), close=1e-14)
    assert found.status == "converged"
    assert found.point is not None
    assert found.point.theta[0] == pytest.approx(1.0, rel=0, abs=1e-8)


@pytest.mark.parametrize(("bend", "status"), [(0.9, "converged"), (0.97, "stalled")])
def test_limit_short_steps_of_a_model_that_does_not_fit_converge_by_its_misfit(bend: float, status: str) -> None:
    """(θ, aθ²) far from the readings: each step goes to the other side of the minimum, `bend` times as far off."""
    away = 1e3
    a = bend / (2 * away)

    def residuals(theta: Array) -> Array:
        return np.array([theta[0] - 1.0, a * theta[0] ** 2 + away])

    def derivatives(theta: Array) -> Array:
        return np.array([[1.0], [2 * a * theta[0]]])

    block = Block("bent", (0,), residuals, derivatives, (Segment("y", 0, 2),), 2)
    found = solve(Problem((Unknown("b", 3000.0),), (block,)), close=1e-2, steps=25)
    assert found.point is not None
    assert found.status == status
    left = abs(found.point.theta[0] - 1 / (1 + bend)) / (away / np.sqrt(2))
    assert left < 0.1 if status == "converged" else left > 0.05
