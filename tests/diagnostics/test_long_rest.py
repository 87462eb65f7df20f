"""Swings with dry friction: one of large angles that came to rest long ago, one over a zero that swings slowly."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from metrology.decay import DecayTest
from metrology.diagnostics import decay
from metrology.gum import Component, Input, Normal
from metrology.timeseries import Channel

J, K, C, FRICTION = 0.02, 0.4, 0.004, 1e-3
STEPS = 4096


def swung(amplitude: float, stamps: np.ndarray, friction: float = FRICTION) -> np.ndarray:
    """J·θ″ + C·θ′ + F·sign(θ′) + K·sin θ = 0 from rest at an amplitude, half a swing at a time, until it sticks."""
    angle = np.full(len(stamps), amplitude)
    start, at, way = 0.0, amplitude, -1.0

    def moves(_: float, y: np.ndarray, way: float) -> list[float]:
        return [y[1], -(C * y[1] + way * friction + K * np.sin(y[0])) / J]

    def turns(_: float, y: np.ndarray, way: float) -> float:
        return way * y[1] if abs(y[1]) > 1e-12 else 1.0

    turns.terminal, turns.direction = True, -1.0  # type: ignore[attr-defined]
    while K * abs(np.sin(at)) > friction:
        found = solve_ivp(
            moves, (start, stamps[-1] + 1.0), [at, 1e-9 * way], method="DOP853", events=turns, args=(way,), rtol=1e-11,
            atol=1e-13, dense_output=True,
        )  # fmt: skip
        inside = (stamps >= start) & (stamps <= found.t[-1])
        angle[inside] = found.sol(stamps[inside])[0]
        if not found.t_events[0].size:
            return angle
        start, at, way = found.t[-1], float(found.y[0, -1]), -way
    angle[stamps > start] = at
    return angle


def test_motion_ends_where_friction_holds_it():
    angle = swung(1.3, np.arange(0.0, 40.0, 0.01))
    assert K * abs(np.sin(angle[-1])) <= FRICTION
    assert np.ptp(angle[-500:]) == 0.0
    assert np.max(np.abs(angle[:200])) == pytest.approx(1.3, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("seed", [3, 5, 7])
def test_planted_friction_and_a_pendulum_are_found_beside_a_long_rest(seed):
    """The sine takes away a misfit of 10⁵ noise variances, beside which what friction does is small."""
    rng = np.random.default_rng(seed)
    stamps = np.arange(0.0, 45.0, 0.02)
    step = 2 * np.pi / STEPS
    truth = swung(rng.uniform(1.2, 1.4), stamps)
    read = step * np.round((truth + 0.3 * step * rng.standard_normal(len(stamps))) / step)
    mass = Input("J", J, (Component("source", Normal(2e-6 * J)),), "kg*m^2")
    records = (Channel("r", stamps, read, "rad"),)
    test = DecayTest(name="d", records=records, mass=mass, stiffness="d.k", resolution=step)
    found = decay(test, rng=np.random.default_rng(seed))
    named = {*found.named, *(name for group in found.groups for name in group)}
    assert "friction" in named
    assert named & {"pendulum", "cubic"}
    assert named <= {"friction", "pendulum", "cubic"}
    assert found.verdict in ("explained", "explained in the main", "ambiguous")
    sizes = {one.name: one.value for cause in found.causes for one in cause.parameters}
    assert sizes["friction.force"] == pytest.approx(FRICTION, rel=0.03)
    assert found.supported is not None
    values = {
        name: (value, u)
        for name, value, u in zip(found.supported.names, found.supported.values, found.supported.u, strict=True)
    }
    for name, true in (("k", K), ("c", C)):
        value, u = values[name]
        assert abs(value - true) < 4 * u + 4 * 2e-6 * true, name


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1, 3])
def test_null_a_zero_that_swings_slowly_has_no_step(seed):
    """Less than twice in the record: neither a polynomial follows it, nor is it a line."""
    rng = np.random.default_rng(seed)
    stamps = np.arange(0, 30, 0.02)
    zero = 6e-3 * np.sin(2 * np.pi * stamps / 17 + rng.uniform(0, 2 * np.pi))
    read = swung(0.3, stamps, 3e-4) + zero + 3e-4 * rng.standard_normal(len(stamps))
    mass = Input("J", J, (Component("source", Normal(2e-6 * J)),), "kg*m^2")
    test = DecayTest(name="d", records=(Channel("r", stamps, read, "rad"),), mass=mass, stiffness="d.k")
    found = decay(test, rng=np.random.default_rng(seed))
    assert "friction" in found.named
    assert "hop" not in {*found.named, *(name for group in found.groups for name in group)}
