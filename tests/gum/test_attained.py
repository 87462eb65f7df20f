"""Attained coverage: closed forms, and intervals that are plainly too narrow."""

from __future__ import annotations

from dataclasses import replace
from math import atan, erf, inf, pi, sqrt

import numpy as np
import pytest

from metrology.expression import Expression
from metrology.gum import functions
from metrology.gum.attained import Attained, attained
from metrology.gum.bounded import Rectangular
from metrology.gum.curve import curve
from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Measurand
from metrology.gum.fit import knowledge
from metrology.gum.inputs import Component, Ensemble, Input, Knowledge

CHANCE = 4 * sqrt(0.05 * 0.95 / 2000)


def _phi(z: float) -> float:
    return 0.5 * (1 + erf(z / sqrt(2)))


def _mean(dof: float, **more: object) -> Knowledge:
    """The mean of readings, u = 1, as an ensemble of one."""
    ensemble = Ensemble("readings", ("x",), np.eye(1), dof, **more)  # type: ignore[arg-type]
    return Knowledge({"x": Input("x", 10.0)}, (ensemble,))


def _share(known: Knowledge, *, by_law: bool = True, function: object = lambda q: q["x"]) -> Attained:
    return attained([Measurand("Y", function)], known, {"Y": by_law}, seed=1)["Y"]  # type: ignore[arg-type]


@pytest.mark.parametrize("dof", [1.0, 2.0, 9.0])
def test_law_interval_of_a_mean_holds_as_often_as_it_says(dof: float) -> None:
    found = _share(_mean(dof))
    assert found.repetitions == 2000
    assert found.share == pytest.approx(0.95, abs=CHANCE)
    assert not found.is_short_of(0.95)


def test_closed_form_an_interval_without_students_factor_is_found_too_narrow() -> None:
    """Two readings, and 1.96 for 12.7: P(|t₁| < 1.96) = (2/π)·atan(1.96) = 0.70."""

    def two(generator: np.random.Generator, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        drawn = sqrt(2) * generator.standard_normal((2, size))
        return drawn.mean(axis=0)[None], drawn.var(axis=0, ddof=1) / 2, np.ones((1, size))

    found = _share(_mean(1e6, again=two))
    assert found.share == pytest.approx(2 / pi * atan(1.96), abs=4 * sqrt(0.21 / 2000))
    assert found.is_short_of(0.95)


def test_component_with_degrees_of_freedom_is_estimated_anew_each_time() -> None:
    readings = Component("readings", Normal(1.0), 2.0, "A")
    known = Knowledge({"x": Input("x", 0.0, (readings,))})
    assert _share(known).share == pytest.approx(0.95, abs=CHANCE)
    assert _share(known, by_law=False).share == pytest.approx(0.95, abs=4 * sqrt(0.05 * 0.95 / 400))
    # What is stated as known is not: its interval is 1.96·u in each repetition.
    exact = Knowledge({"x": Input("x", 0.0, (replace(readings, dof=inf),))})
    assert _share(exact).share == pytest.approx(0.95, abs=CHANCE)


def test_rectangular_holds_always_what_1_96_u_reach() -> None:
    known = Knowledge({"x": Input("x", 0.0, (Component("limits", Rectangular(1.0)),))})
    assert _share(known).share == 1.0


def test_closed_form_curve_is_fitted_again() -> None:
    """y = 1/b with u(ȳ)/y = 0.3: |b̂ − b| ≤ 1.96·u(b̂) with u by each fit means z·(1 + 0.3·z) ≤ 1.96: 91.7 %."""
    fit = curve(Expression.parse("1/b + 0*x"), np.arange(4.0), np.ones(4), start={"b": 0.9}, u_y=np.full(4, 0.6))
    found = attained([Measurand("Y", lambda q: q["f.b"])], knowledge(fit, "f"), {"Y": True}, seed=3)["Y"]
    expected = _phi((-1 + sqrt(1 + 1.2 * 1.96)) / 0.6)
    assert found.share == pytest.approx(expected, abs=4 * sqrt(expected * (1 - expected) / 2000))
    assert found.is_short_of(0.95)


def test_amplitude_near_zero_is_found_too_narrow_as_by_another_way() -> None:
    """Magnitude of a vector of 0.1 u: the interval seldom reaches down to it (Hall, Metrologia 45 (2008) L5)."""
    inputs = {name: Input(name, value, (Component("noise", Normal(1.0)),)) for name, value in (("a", 0.1), ("b", 0.0))}
    found = _share(Knowledge(inputs), by_law=False, function=lambda q: functions.sqrt(q["a"] ** 2 + q["b"] ** 2))
    generator, held = np.random.default_rng(5), 0
    for _ in range(400):
        a, b = generator.standard_normal(2) + np.array([0.1, 0.0])
        draws = np.sort(np.hypot(a + generator.standard_normal(4000), b + generator.standard_normal(4000)))
        first = int(np.argmin(draws[3800:] - draws[:200]))
        held += draws[first] <= 0.1 <= draws[first + 3800]
    assert held / 400 < 0.8
    assert found.share == pytest.approx(held / 400, abs=4 * sqrt(2 * 0.25 / 400))
    assert found.is_short_of(0.95)


def test_no_statement_without_degrees_of_freedom_or_uncertainty() -> None:
    correlated = Knowledge(
        {name: Input(name, 1.0, (Component("readings", Normal(1.0), 3.0, "A"),)) for name in ("x", "y")},
        correlations={("x", "y"): 0.5},
    )
    assert attained([Measurand("Y", lambda q: q["x"] + q["y"])], correlated, {"Y": True}, seed=1) == {}
    assert attained([Measurand("Y", lambda q: q["x"])], Knowledge({"x": Input("x", 1.0)}), {"Y": True}, seed=1) == {}
