"""Extreme scales against closed forms, with float errors raised: what cannot be trusted is refused with a reason."""

from __future__ import annotations

import math
import tracemalloc
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from metrology import decay, gum
from metrology.decay.test import DecayTest
from metrology.elongation.analysis import analyse
from metrology.elongation.test import ElongationTest, Load, Reading
from metrology.errors import MetrologyError
from metrology.expression import Expression
from metrology.gum import Component, Input, Knowledge, Measurand, Normal, Rectangular, regression
from metrology.timeseries import Channel

FEW = settings(max_examples=25, deadline=None, derandomize=True)
POWERS = st.integers(-12, 12).map(lambda power: 10.0**power)
GRAVITY, AIR, STEEL = Input("g", 9.8, (), "m/s²"), Input("air", 1.2, (), "kg/m³"), Input("steel", 8e3, (), "kg/m³")


@pytest.fixture(autouse=True)
def _float_errors_are_raised() -> Iterator[None]:
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield


def known(name: str, value: float, u: float) -> Input:
    return Input(name, value, (Component("stated", Normal(u)),))


# The GUM uncertainty framework


@FEW
@given(scale=POWERS, relative=st.sampled_from([1e-12, 1e-9, 1e-3, 0.1, 1.0, 10.0]))
def test_closed_form_sum_product_and_quotient(scale: float, relative: float) -> None:
    x, y = known("x", scale, scale * relative), known("y", -2 * scale, 3 * scale * relative)
    models = {
        "sum": (lambda q: q["x"] + q["y"], math.sqrt(10) * scale * relative),
        "product": (lambda q: q["x"] * q["y"], math.sqrt(13) * scale**2 * relative),
        "quotient": (lambda q: q["x"] / q["y"], math.sqrt(13) / 4 * relative),
    }
    measurands = [Measurand(name, function) for name, (function, _) in models.items()]
    found = gum.evaluate(measurands, Knowledge({"x": x, "y": y}), seed=1, max_trials=1000).estimates
    for name, (_, expected) in models.items():
        assert found[name].u == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_closed_form_difference_of_nearly_equal_inputs(gap: float) -> None:
    inputs = {name: known(name, 1.0, 2.0) for name in ("x", "y")}
    difference = Measurand("d", lambda q: q["x"] - q["y"])
    together = Knowledge(inputs, correlations={("x", "y"): 1 - gap})
    found = gum.evaluate([difference], together, seed=1, max_trials=20_000).estimates["d"]
    assert found.u == pytest.approx(2 * math.sqrt(2 * gap), rel=1e-6)
    assert found.monte_carlo.u == pytest.approx(found.u, rel=0.05)


@pytest.mark.parametrize("gap", [1e-12, 1e-15, 0.0])
def test_refusal_of_a_correlation_that_leaves_no_digit_of_the_difference(gap: float) -> None:
    inputs = {name: known(name, 1.0, 2.0) for name in ("x", "y")}
    difference = Measurand("d", lambda q: q["x"] - q["y"])
    with pytest.raises(MetrologyError, match="singular matrix for x, y"):
        gum.evaluate([difference], Knowledge(inputs, correlations={("x", "y"): 1 - gap}), seed=1, max_trials=1000)


# Readings


@pytest.mark.parametrize("count", [3, 4, 1001, 10**6])
def test_closed_form_readings_at_a_billion_times_their_scatter(count: int) -> None:
    # 0, 1, …, n − 1 have the mean (n − 1)/2 and s² = n·(n + 1)/12; offsets are exact.
    for offset in (0.0, 1e9 * count):
        readings = offset + np.arange(float(count))
        assert gum.mean(readings) == offset + (count - 1) / 2
        assert gum.standard_deviation(readings) == pytest.approx(math.sqrt(count * (count + 1) / 12), rel=1e-12)


@pytest.mark.study
def test_closed_form_ten_million_readings_and_points() -> None:
    n = 10**7
    readings = 1e9 + np.arange(float(n))
    assert gum.mean(readings) == 1e9 + (n - 1) / 2
    assert gum.standard_deviation(readings) == pytest.approx(math.sqrt(n * (n + 1) / 12), rel=1e-12)
    fit = regression.line(readings, 3.0 * np.arange(float(n)) + np.where(np.arange(n) % 2, 1.0, -1.0))
    assert fit.values[1] == pytest.approx(3.0, rel=1e-9)
    assert fit.s == pytest.approx(1.0, rel=1e-6)


def test_law_memory_of_a_line_is_bounded_for_each_point() -> None:
    x = np.arange(1e5)
    tracemalloc.start()
    try:
        regression.line(x, x)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak / (8 * x.size) < 40


# Lines


def fits(sx: float, sy: float) -> dict[str, Any]:
    steps = np.arange(10.0)
    x, y = sx * steps, sy * (3 * steps + np.array([1, -1, 0, 2, -2, 0, 1, 0, -1, 0]))
    return {
        "scatter": lambda: regression.line(x, y),
        "stated": lambda: regression.line(x, y, u_y=sy),
        "both": lambda: regression.line(x, y, u_x=0.1 * sx, u_y=sy),
        "cubic": lambda: regression.polynomial(x, y, degree=3),
        "curve": lambda: regression.curve(Expression.parse("a + b*x"), x, y, start={"a": sy, "b": sy / sx}),
    }


@FEW
@given(sx=POWERS, sy=POWERS)
def test_law_units_change_nothing_but_the_numbers(sx: float, sy: float) -> None:
    plain, moved = fits(1.0, 1.0), fits(sx, sy)
    for name, fit in moved.items():
        there, here = fit(), plain[name]()
        unit = sy / sx ** np.arange(len(here.values))
        np.testing.assert_allclose(there.u, here.u * unit, rtol=1e-9)
        np.testing.assert_allclose(there.values, here.values * unit, atol=0, rtol=1e-9)


@pytest.mark.parametrize("name", ["scatter", "stated", "both", "cubic", "curve"])
@pytest.mark.parametrize(("sx", "sy"), [(1e-150, 1e150), (1e150, 1e-150)])
def test_refusal_of_fits_whose_variances_cannot_be_held(name: str, sx: float, sy: float) -> None:
    with pytest.raises(MetrologyError, match=r"cannot be held|values nearer|not settle|finite"):
        regression.predict(fits(sx, sy)[name](), 0.0)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_closed_form_line_through_points_that_share_their_error(gap: float) -> None:
    # V = r·11ᵀ + (1 − r)·1: what is common moves the intercept only, so u²(b) = (1 − r)/Σ(x − x̄)².
    n = 8
    x, shared = np.arange(float(n)), (1 - gap) * np.ones((n, n)) + gap * np.eye(n)
    fit = regression.line(x, 1 + 3 * x, covariance=shared)
    assert fit.values == pytest.approx([1.0, 3.0], rel=1e-12)
    assert fit.u[1] == pytest.approx(math.sqrt(gap / 42), rel=1e-15 / gap + 1e-12)


def test_refusal_of_points_that_share_their_whole_error() -> None:
    with pytest.raises(MetrologyError, match="singular matrix"):
        regression.line(np.arange(8.0), np.arange(8.0), covariance=(1 - 1e-15) * np.ones((8, 8)) + 1e-15 * np.eye(8))


# Elongation and decay


def elongation(k: float, largest: float, offset: float) -> tuple[ElongationTest, float]:
    """A test of five loads, three cycles, and k by the exact least-squares line through all readings."""
    forces = [k * largest * part / 5 for part in range(1, 6)]
    scatter, generator, readings = 1e-3 * largest, np.random.default_rng(1), []
    for repeat in ("1", "2", "3"):
        for direction, order in (("loading", range(5)), ("unloading", range(4, -1, -1))):
            for i in order:
                value = scatter * (offset + generator.standard_normal()) + forces[i] / k
                readings.append(Reading(f"L{i}", repeat, direction, value))
    loads = tuple(Load(f"L{i}", Input(f"t.L{i}", force, (), "N")) for i, force in enumerate(forces))
    rounding = Component("resolution", Rectangular(0.1 * scatter))
    x = [Fraction(forces[int(reading.load[1])]) for reading in readings]
    y = [Fraction(reading.value) for reading in readings]
    centre = sum(x) / len(x)
    spread = sum((a - centre) ** 2 for a in x)
    exact = float(spread / sum((a - centre) * b for a, b in zip(x, y, strict=True)))
    return ElongationTest("t", loads, tuple(readings), rounding, GRAVITY, AIR, STEEL), exact


@pytest.mark.parametrize("k", [1e-3, 1.0, 1e6, 1e12])
@pytest.mark.parametrize("largest", [1e-12, 1e-3, 1e3])
@pytest.mark.parametrize("offset", [0.0, 1e9])
def test_twice_stiffness_by_exact_arithmetic(k: float, largest: float, offset: float) -> None:
    test, exact = elongation(k, largest, offset)
    analysis = analyse(test)
    inputs = {item.name: item for item in analysis.inputs}
    knowledge = Knowledge(inputs, analysis.ensembles, analysis.correlations)
    found = gum.evaluate(analysis.measurands, knowledge, seed=1, max_trials=1000).estimates["t.k"]
    # A reading of a billion scatters is held to 1e-7 of the scatter.
    assert found.value == pytest.approx(exact, rel=1e-14 if offset == 0 else 1e-5 * found.u / found.value)
    plain, _ = elongation(1.0, 1e-3, 0.0)
    means = {item.name: item.value for item in analyse(plain).inputs}
    assert found.u / found.value == pytest.approx(relative_u(plain, means), rel=1e-5)


def relative_u(test: ElongationTest, means: dict[str, float]) -> float:
    """u(k)/k of a test without offset, by s/√Σ(F − F̄)² of the line with a zero for each repeat, and rounding."""
    forces = np.array([load.quantity.value for load in test.loads])
    rows = [(int(reading.load[1]), int(reading.repeat) - 1, reading.value) for reading in test.readings]
    design = np.zeros((len(rows), 7))
    for row, (load, repeat, _) in enumerate(rows):
        design[row, load] = 1.0
        design[row, 5:] = [(repeat == 0) - (repeat == 2), (repeat == 1) - (repeat == 2)]
    value = np.array([reading for *_, reading in rows])
    _, rest, *_ = np.linalg.lstsq(design, value, rcond=None)
    variance = float(rest[0]) / (len(rows) - 7) + test.resolution.u**2
    slope = np.polyfit(forces, [means[f"t.reading.L{i}"] for i in range(5)], 1)[0]
    return math.sqrt(variance / (6 * np.sum((forces - forces.mean()) ** 2))) / slope


def released(size: float, speed: float, offset: float, seed: int) -> Channel:
    """22.9 Hz with ζ = 0.01 and noise of a thousandth, at another size, clock and zero."""
    t, omega = np.arange(3000) / 1000, 2 * np.pi * 22.9
    swing = np.exp(-0.01 * omega * t) * np.cos(omega * math.sqrt(1 - 1e-4) * t)
    noise = 1e-3 * (np.random.default_rng(seed).standard_normal(t.size) + offset)
    return Channel("r", t / speed, size * (swing + noise), "m")


def decayed(size: float = 1.0, speed: float = 1.0, offset: float = 0.0) -> Any:
    records = tuple(released(size, speed, offset, seed) for seed in (1, 2))
    return decay.analyse(DecayTest("d", records, Input("d.mass", 1.2, (), "kg"), "d.k", mains=50.0 * speed))


@pytest.mark.long
@pytest.mark.parametrize(
    ("size", "speed", "offset"),
    [(2.0**-100, 1.0, 0.0), (2.0**100, 1.0, 0.0), (1.0, 2.0**-5, 0.0), (1.0, 2.0**30, 0.0), (1.0, 1.0, 1e9)],
)
def test_law_decay_does_not_depend_on_size_clock_and_zero(size: float, speed: float, offset: float) -> None:
    plain, moved = decayed(), decayed(size, speed, offset)
    names = ("d.log_decrement", "d.omega_d")
    here, there = ({item.name: item for item in found.inputs} for found in (plain, moved))
    for name, unit in zip(names, (1.0, speed), strict=True):
        assert there[name].value == pytest.approx(here[name].value * unit, rel=1e-10)
    assert plain.finding.records[0].zeta_fit == pytest.approx(0.01, rel=2e-3)


def test_refusal_of_a_clock_that_leaves_no_frequency() -> None:
    found = decayed(speed=2.0**-10)
    assert not found.finding.records
    assert "No frequency is left" in found.finding.failures[0]
