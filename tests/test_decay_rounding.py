"""Free decays read by a coarse encoder: rounding that no noise dithers is a function of the motion, and no cause."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from truth_decay import held_at_last

from metrology.decay import DecayTest
from metrology.decay.rounding import _moments
from metrology.decay.separated import Separated
from metrology.decay.separation import separate
from metrology.decay.start import refuse_clipped
from metrology.diagnostics import decay
from metrology.diagnostics.release_cut import _blocks
from metrology.gum.inputs import Input
from metrology.timeseries import Channel

J, K, C = 0.02, 0.02 * (0.5 * math.pi) ** 2, 4e-4
"""A torsion pendulum of 0.25 Hz with ζ = 0.0064: inertia / (kg·m²), stiffness, damping."""
STEP = math.radians(0.36)
"""Of an encoder of 1000 lines."""
BEFORE = 10
Force = Callable[[float, float], float]


def swing(start: float, t: np.ndarray, force: Force | None = None, dry: float = 0.0) -> np.ndarray:
    """J·x″ + C·x′ + K·x = force − dry·sign x′ from rest, each way by itself."""
    return held_at_last(
        start, t, lambda y, way: (-K * y[0] - C * y[1] + (force(*y) if force else 0.0) - way * dry) / J,
        lambda x: abs(K * x) <= dry, begun=1e-6, longest=8.0, atol=1e-13,
    )  # fmt: skip


def read(steps: float, noise: float, seed: int, force: Force | None = None, dry: float = 0.0, unit: str = "rad",
         count: int = 3) -> DecayTest:  # fmt: skip
    """Releases of a swing of so many steps of the encoder, with noise as a part of one; zero lies anywhere."""
    rng, t, records = np.random.default_rng(seed), np.arange(2400) / 20, []
    for at in range(count):
        start = steps * STEP * (1 + 0.03 * rng.standard_normal())
        x = np.concatenate([np.full(BEFORE, start), swing(start, t, force, dry)]) + rng.uniform(-0.5, 0.5) * STEP
        x += noise * STEP * rng.standard_normal(len(x))
        records.append(Channel(f"r{at}", (np.arange(len(x)) - BEFORE) / 20, STEP * np.round(x / STEP), unit))
    return DecayTest("d", tuple(records), Input("d.inertia", J, unit="kg*m^2"), "k")


def as_stated(test: DecayTest) -> np.ndarray:
    """Distances of ω and λ of the direct fits from the truth, in their standard uncertainties."""
    rate = 0.5 * C / J
    true, found = np.array([math.sqrt(K / J - rate**2), rate]), []
    for one in test.separated:
        assert isinstance(one, Separated)
        u = np.sqrt(np.diag(one.fit.covariance))
        found.append((np.array([one.fit.main.omega, one.fit.main.rate]) - true) / u)
    return np.array(found)


@pytest.mark.long
@pytest.mark.parametrize(
    ("steps", "noise", "unit", "count"),
    [(5.5, 0.055, "rad", 3), (3.0, 0.02, "rad", 3), (1.6, 0.05, "m", 3), (1.2, 0.1, "rad", 3), (2.2, 0.05, "m", 1),
     (4.0, 0.2, "rad", 3), (4.0, 0.5, "m", 3)],
)  # fmt: skip
def test_planted_nothing_read_by_a_coarse_encoder_is_found_to_be_nothing(
    steps: float, noise: float, unit: str, count: int
) -> None:
    """Of a swing of 5.5 steps it was a gain that changes with time, and c was wrong by four standard uncertainties."""
    test = read(steps, noise, 1, unit=unit, count=count)
    found = decay(test, rng=np.random.default_rng(1))
    assert (found.verdict, found.named, found.possible) == ("nothing missing", (), ())
    assert np.abs(as_stated(test)).max() < 3.5


@pytest.mark.long
def test_law_direct_fits_of_rounded_readings_are_as_far_from_the_truth_as_they_state() -> None:
    """Swings of two to four steps, the rounding of which made modes at multiples of their frequency."""
    apart = np.concatenate([as_stated(read(steps, 0.05, seed)) for seed, steps in enumerate((1.8, 2.3, 3.9))])
    assert 0.5 < np.sqrt(np.mean(apart**2)) < 1.5
    assert all(len(one.fit.modes) == 1 for one in read(2.3, 0.05, 7).separated if isinstance(one, Separated))


@pytest.mark.long
@pytest.mark.parametrize(("steps", "seed"), [(5.5, 2), (3.0, 1)])
def test_planted_friction_read_by_a_coarse_encoder_is_named(steps: float, seed: int) -> None:
    dry = (0.003 if steps > 5 else 0.006) * K * steps * STEP
    found = decay(read(steps, 0.055, seed, dry=dry), rng=np.random.default_rng(1))
    assert (found.verdict, found.named) == ("explained", ("friction",))
    assert found.extended_model["friction.force"] == pytest.approx(dry, rel=0.3)
    shifts = {one.name: one for one in found.shifts}
    assert abs(shifts["k"].after - K) < 3 * shifts["k"].u_after
    assert abs(shifts["c"].after - C) < 3 * shifts["c"].u_after


@pytest.mark.long
@pytest.mark.parametrize("steps", [1.6, 5.5])
def test_planted_cubic_stiffness_read_by_a_coarse_encoder_is_named(steps: float) -> None:
    size = steps * STEP
    found = decay(read(steps, 0.055, 3, lambda x, _v: -0.06 * K * x * (x / size) ** 2), rng=np.random.default_rng(1))
    assert (found.verdict, found.named) == ("explained", ("cubic",))
    assert found.extended_model["cubic.stiffness"] == pytest.approx(0.06 * K / size**2, rel=0.2)
    shifts = {one.name: one for one in found.shifts}
    assert abs(shifts["k"].after - K) < 3 * shifts["k"].u_after
    assert abs(shifts["c"].after - C) < 3 * shifts["c"].u_after


def test_limit_a_record_whose_noise_dithers_the_rounding_stays_as_it_is() -> None:
    (record,) = read(4.0, 0.5, 5, count=1).records
    parted = separate(record, mains=50.0)
    assert parted.rounded is None
    assert np.array_equal(parted.free.value, record.value[-len(parted.free) :])


def test_limit_a_swing_of_one_step_is_not_clipped() -> None:
    """Nothing lies between its extreme levels: how long rounding makes a peak was not asked."""
    x = STEP * np.round(swing(1.2 * STEP, np.arange(2400) / 20) / STEP)
    refuse_clipped(Channel("r", np.arange(2400) / 20, x, "rad"))


@pytest.mark.parametrize("level", [0.03, 0.2, 0.9])
def test_twice_moments_of_a_rounded_reading_are_those_of_draws(level: float) -> None:
    x, rng = np.linspace(-1.3, 1.1, 13), np.random.default_rng(1)
    mean, slope, variance = _moments(x, 1.0, level)
    drawn = np.round(x + level * rng.standard_normal((200_000, len(x))))
    assert np.abs(mean - drawn.mean(axis=0)).max() < 0.01
    assert np.abs(variance - drawn.var(axis=0)).max() < 0.01
    more, less = (_moments(x + by, 1.0, level)[0] for by in (1e-5, -1e-5))
    assert slope == pytest.approx((more - less) / 2e-5, abs=1e-4)


def test_closed_form_block_of_readings_of_unlike_weight_is_their_weighted_mean() -> None:
    rng, t = np.random.default_rng(2), np.arange(400) * 1e-3
    u = 10 ** rng.uniform(-3, 1, 400)
    y = np.exp(-3 * t) * np.cos(2 * np.pi * 9 * t)
    mean, means, of_mean, nodes, weights = _blocks(t, y, u, 4e-3 * 1.001)
    share = (1 / u**2).reshape(-1, 4)
    assert means == pytest.approx(np.sum(share * y.reshape(-1, 4), axis=1) / share.sum(axis=1))
    assert mean == pytest.approx(np.sum(share * t.reshape(-1, 4), axis=1) / share.sum(axis=1))
    assert of_mean == pytest.approx(share.sum(axis=1) ** -0.5)
    model = (weights * np.exp(-3 * nodes) * np.cos(2 * np.pi * 9 * nodes)).sum(axis=0)
    assert np.abs(model - means).max() < 2e-6
    assert ((nodes > t[::4] - 1e-9) & (nodes < t[3::4] + 1e-9)).all()
