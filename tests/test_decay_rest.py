"""Free decay, a motion that stops: dry friction that holds, and a record that is much longer than its motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter
from truth_decay import held_at_last

from metrology.decay import DecayTest
from metrology.decay.modes import is_mains
from metrology.decay.oscillation import Mode
from metrology.decay.start import until_rest
from metrology.diagnostics import decay
from metrology.gum.inputs import Input
from metrology.timeseries import Channel

M, K, C, SIZE, RATE = 1.2, 750.0, 0.4, 2e-3, 500.0
PERIOD = 2 * math.pi * math.sqrt(M / K)


def sticking(force: float, start: float, t: np.ndarray) -> np.ndarray:
    """m·x″ + c·x′ + k·x = −F·sign x′ from rest, each way by itself, held where the spring pulls no more than F."""
    return held_at_last(
        start, t, lambda y, way: (-K * y[0] - C * y[1] - way * force) / M, lambda x: abs(K * x) <= force,
        begun=1e-7, longest=2 * PERIOD, atol=1e-14,
    )  # fmt: skip


def stuck(
    seed: int, halves: int, *, periods: int = 20, sigma: float = 2e-6, rho: float = 0.0, count: int = 3
) -> tuple[DecayTest, float]:
    """Releases that stop after about so many half swings, and the friction."""
    rng, force = np.random.default_rng(seed), K * SIZE / (2 * halves)
    t, records = np.arange(-round(0.5 * PERIOD * RATE), round(periods * PERIOD * RATE)) / RATE, []
    for at in range(count):
        start = SIZE * (1 + 0.05 * rng.standard_normal())
        x = np.concatenate([np.full(int((t < 0).sum()), start), sticking(force, start, t[t >= 0])])
        read = lfilter([math.sqrt(1 - rho**2)], [1, -rho], sigma * rng.standard_normal(len(t)))
        records.append(Channel(f"record-{at}", t, 1e-7 * np.round((x + read) / 1e-7), "m"))
    return DecayTest("d", tuple(records), Input("d.mass", M, unit="kg"), "k"), force


@pytest.mark.long
@pytest.mark.parametrize(
    ("seed", "halves", "more"),
    [
        (1, 6, {}), (2, 3, {}), (3, 4, {"rho": 0.5}), (2, 6, {"rho": 0.9}), (2, 8, {"sigma": 2e-5}),
        (2, 5, {"count": 1}),
        (2, 10, {"periods": 40}), (1, 6, {"periods": 6}),
    ],
)  # fmt: skip
def test_planted_friction_that_stops_the_motion_is_named_and_c_is_what_is_left(
    seed: int, halves: int, more: dict[str, Any]
) -> None:
    test, force = stuck(seed, halves, **more)
    found = decay(test, rng=np.random.default_rng(1))
    assert (found.verdict, found.named) == ("explained", ("friction",))
    assert found.extended_model["friction.force"] == pytest.approx(force, rel=0.01)
    shifts = {one.name: one for one in found.shifts}
    assert abs(shifts["k"].after - K) < 3 * shifts["k"].u_after
    assert abs(shifts["c"].after - C) < 3 * shifts["c"].u_after
    assert abs(shifts["c"].before - C) > 4.0  # as stated, it is ten times what it is


def decaying(zeta: float, length: float, seed: int = 1, drift: float = 0.0) -> Channel:
    """A decay of 5 Hz, its amplitude 1000 times its noise, over so many times ln(1000)/(ζω)."""
    rng, omega = np.random.default_rng(seed), 10 * math.pi
    t = np.arange(0.0, length * math.log(1000) / (zeta * omega), 1e-3)
    x = np.exp(-zeta * omega * t) * np.cos(omega * t) + drift * t / t[-1] + 1e-3 * rng.standard_normal(len(t))
    return Channel("r", t, x, "m")


@pytest.mark.parametrize("zeta", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("length", [4.0, 10.0])
def test_closed_form_rest_begins_where_a_decay_is_no_larger_than_its_noise(zeta: float, length: float) -> None:
    free = decaying(zeta, length)
    part, rest = until_rest(free, Mode(10 * math.pi, zeta * 10 * math.pi))
    assert rest is not None
    # Amplitude 1000 falls to one, give or take half of its logarithm and two periods.
    gone = math.log(1000) / (zeta * 10 * math.pi)
    assert 0.5 * gone < rest < 1.2 * gone + 0.4
    assert part.time[-1] == pytest.approx(2 * rest, abs=1e-3)


@pytest.mark.parametrize(("length", "drift"), [(0.05, 0.0), (0.2, 0.0), (0.5, 0.0), (1.0, 0.0), (5.0, 5.0)])
def test_limit_what_decays_or_drifts_to_the_end_has_no_rest(length: float, drift: float) -> None:
    free = decaying(0.05, length, drift=drift)
    part, rest = until_rest(free, Mode(10 * math.pi, 0.5 * math.pi))
    assert rest is None
    assert part is free


def test_law_a_hum_that_goes_on_in_the_rest_is_kept() -> None:
    """It does not stop with the motion: the record of a decay is taken apart whole."""
    free = decaying(0.1, 6.0)
    hum = 5e-3 * np.sin(2 * math.pi * 50.0 * free.time)
    test = DecayTest("d", (Channel("r", free.time, free.value + hum, "m"),), Input("d.mass", M, unit="kg"), "k")
    (parted,) = test.separated
    assert len(parted.free) > 0.9 * len(free)
    assert [is_mains(mode, 50.0) for mode, _ in parted.fit.others] == [True]


@pytest.mark.parametrize(("zeta", "start"), [(0.36, -68e-3), (0.42, -68e-3), (0.45, -60e-3), (0.45, -70e-3)])
def test_law_readings_at_rest_that_are_all_alike_are_no_measure_of_the_noise(zeta: float, start: float) -> None:
    """By them the noise of readings in whole divisions is nothing, and their rounding is an unlisted law of 10⁴ N."""
    omega, step = math.sqrt(K / M), 2e-3
    pole, t = complex(-zeta, math.sqrt(1 - zeta**2)) * omega, np.arange(0.0, 2.5, 0.25 / omega)
    x = start * (np.exp(pole * t) * complex(1.0, zeta / math.sqrt(1 - zeta**2)).conjugate()).real
    records = (Channel("release", t, step * np.round(x / step), "m"),)
    found = decay(DecayTest("d", records, Input("d.mass", M, unit="kg"), "k"), rng=np.random.default_rng(1))
    assert found.verdict == "nothing missing"


@pytest.mark.long
@pytest.mark.parametrize("start", [31e-3, 33e-3])
def test_limit_a_stop_in_whole_divisions_after_two_half_swings_is_no_step_of_the_reading(start: float) -> None:
    """Friction holds the mass beside its zero by a division or two, which readings that are all alike made certain."""
    t, step = np.arange(0.0, 17.5, 0.25) * math.sqrt(M / K), 2e-3
    x = sticking(K * start / 4, start, t)
    records = (Channel("release", t, step * np.round(x / step), "m"),)
    found = decay(DecayTest("d", records, Input("d.mass", M, unit="kg"), "k"), rng=np.random.default_rng(1))
    assert not {"hop", "drift"}.intersection(found.named)
