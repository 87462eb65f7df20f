"""Elongation tests as laboratories have them: knees, yields, dials, rooms that warm up and cool down again."""

from __future__ import annotations

import numpy as np
import pytest
import truth_elongation
from plain_cases import stretched

from metrology.diagnosis import Diagnosis
from metrology.diagnostics import elongation
from metrology.diagnostics.elongation import Elongation
from metrology.effect import Readings
from metrology.effects import periodic, plasticity, softening

SINGLE = {"load", "exchange", "misread"}
"""Faults of single loads or readings."""


def diagnosed(material: str, seed: int, planted: dict[str, float]) -> Diagnosis:
    return elongation(stretched(material, seed, planted), rng=np.random.default_rng(seed))


def size(material: str, name: str, d: float) -> float:
    """Of an effect that moves the readings by so many standard deviations."""
    one = truth_elongation.MATERIALS[material]
    return 1e-5 * d / truth_elongation.distance(name, one, 1e-5)


def off(found: Diagnosis, material: str) -> float:
    """Deviation of the compliance in its standard uncertainties."""
    assert found.supported is not None
    at = found.supported.names.index("slope")
    return abs(found.supported.values[at] - 1 / truth_elongation.MATERIALS[material].k) / found.supported.u[at]


@pytest.mark.parametrize(("material", "seed"), [("al-1100", 21), ("spectra", 22)])
def test_planted_knee_is_softening_and_no_wrong_load(material: str, seed: int) -> None:
    found = diagnosed(material, seed, {"knee": size(material, "knee", 30)})
    assert found.possible[0] == "softening"
    assert not SINGLE & set(found.possible)
    assert off(found, material) < 3


@pytest.mark.parametrize(("material", "seed"), [("al-1100", 23), ("spectra", 24)])
def test_planted_yield_in_every_mounting_is_no_creep(material: str, seed: int) -> None:
    found = diagnosed(material, seed, {"yields": size(material, "yields", 30)})
    assert found.named == ("yield",)
    assert off(found, material) < 3


@pytest.mark.parametrize("seed", [27, 28])
def test_planted_error_of_each_turn_of_a_dial_is_no_group_of_loads(seed: int) -> None:
    """Ten loads over one turn and a fifth of a dial of 0.5 mm; the sample stays in its clamps between repeats."""
    loads = tuple(0.15 * at for at in range(1, 11))
    found = diagnosed("al-1100", seed, {"masses": loads, "screw": 1e-5, "zero": 2e-6})
    assert found.named == ("periodic",)
    (cause,) = (one for one in found.causes if one.effect == "periodic")
    assert abs(cause.parameters[0].value) == pytest.approx(1e-5, rel=0.3)
    assert off(found, "al-1100") < 3


def test_limit_turns_that_the_readings_cannot_show_are_not_tried() -> None:
    """Five loads 0.1 mm apart: 0.2 mm holds two of them, 0.5 mm is longer than all; 1 mm apart, none is left."""
    loads = np.tile(np.arange(1.0, 6.0), 2)
    for apart, turns in ((0.0999e-3, [0.2e-3]), (1e-3, [])):
        seen = Readings(loads, loads, 0 * loads, np.repeat([0, 1], 5), apart * loads)
        assert [periodic.TURNS[at] for at in periodic.turns(seen)] == turns
    assert "periodic" in Elongation(stretched("peek", 1, {})).reasons()


@pytest.mark.parametrize(("material", "seed"), [("al-1100", 29), ("peek", 30)])
def test_planted_swing_of_the_temperature_is_no_mounting(material: str, seed: int) -> None:
    found = diagnosed(material, seed, {"swing": size(material, "swing", 60)})
    assert set(found.named) <= {"drift"}
    assert found.remainder is not None
    assert "order" in str(found.remainder.law)


@pytest.mark.parametrize("count", [3, 4, 10])
def test_limit_a_knee_lies_between_loads_that_show_it(count: int) -> None:
    """A softening in the upper half, a yield from a quarter of the range on with two loads beyond it."""
    loads = np.arange(1.0, count + 1)
    seen = Readings(loads, loads, 0 * loads, np.zeros(count, dtype=np.intp), 1e-4 * loads)
    for least, beyond in ((softening.LEAST * seen.most, 1), (plasticity.least(seen), plasticity.BEYOND)):
        low, high = softening.within(seen, least, beyond=beyond)
        assert max(loads[1], least) == low <= high == max(loads[-1 - beyond], low)
        assert all(low <= one <= high for one in softening.between(seen, least, beyond=beyond))


@pytest.mark.parametrize(("material", "seed"), [("al-1100", 203), ("peek", 203)])
def test_planted_slip_before_the_largest_load_is_no_yield(material: str, seed: int) -> None:
    """A yield with one load beyond it would be the same step; with so few places it was the more probable one."""
    assert diagnosed(material, seed, {"slip": size(material, "slip", 15)}).named == ("slip",)


def test_planted_nothing_at_three_loads_is_found_to_be_nothing() -> None:
    """The fewest that a test may have."""
    assert diagnosed("al-1100", 32, {"masses": (0.5, 1.0, 1.5)}).verdict == "nothing missing"
