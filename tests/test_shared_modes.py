"""Oscillations that one record of a decay shows, sought in the others: planted, absent, and on the limit."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from metrology.decay.modes import disentangle
from metrology.decay.oscillation import Mode
from metrology.decay.separated import Separated
from metrology.decay.separation import separate
from metrology.decay.shared_modes import with_shared
from metrology.decay.test import DecayTest
from metrology.gum import Component, Input, Normal
from metrology.timeseries import Channel

T = np.arange(2000) / 1000.0
MAIN, RING = Mode(2 * pi * 22.9, 8.0), Mode(2 * pi * 61.3, 0.4)
NOISE = 1e-6


def record(ring: float, seed: int, main: float = 400.0, frequency: float = 61.3) -> Channel:
    """A decay with a ring of some amplitude in standard deviations of the noise, its phase its own."""
    rng = np.random.default_rng(seed)
    swing = main * np.exp(-MAIN.rate * T) * np.cos(MAIN.omega * T)
    ring_ = ring * np.exp(-RING.rate * T) * np.cos(2 * pi * frequency * T + rng.uniform(0, 2 * pi))
    return Channel(f"r{seed}", T, NOISE * (swing + ring_ + rng.standard_normal(T.size)), "m")


def parted(ring: float, seed: int) -> Separated:
    return separate(record(ring, seed), mains=50.0)


def rings(one: Separated) -> list[float]:
    """Amplitudes, in standard deviations of the noise, at the frequency of the ring."""
    return [size / NOISE for mode, size in one.fit.others if abs(mode.frequency - 61.3) < 0.5]


def test_planted_what_one_record_shows_is_found_in_the_others():
    alone = [parted(1.0, 1), *(parted(0.28, seed) for seed in range(100, 130))]
    assert len(rings(alone[0])) == 1
    found = with_shared(alone)
    assert found[0] is alone[0]
    by_itself, in_company = (sum(len(rings(one)) for one in every[1:]) for every in (alone, found))
    # By themselves they lie below the limit of one false alarm in 10⁴ searches, d²/2 = 16.7; 20 are above ln 3n = 8.7.
    assert by_itself <= 10
    assert in_company >= 24
    sizes = [size for one in found[1:] for size in rings(one)]
    assert np.mean(sizes) == pytest.approx(0.28, abs=0.04)
    for one, fewer in zip(found, alone, strict=True):
        assert one.fit.squares <= fewer.fit.squares
        assert abs(one.fit.main.omega - fewer.fit.main.omega) < np.sqrt(fewer.fit.covariance[0, 0])


def test_null_what_one_record_alone_has_is_found_in_no_other():
    shown = parted(1.0, 7)
    others = [parted(0.0, seed) for seed in range(1000, 1060)]
    found = with_shared([shown, *others])
    # One of 3·n is asked for: of sixty records of noise none is to be expected.
    assert not any(len(again.fit.modes) > len(one.fit.modes) for one, again in zip(others, found[1:], strict=True))


def test_null_another_frequency_is_another_oscillation():
    shown, other = parted(1.0, 7), separate(record(1.0, 8, frequency=64.0), mains=50.0)
    found = with_shared([shown, other])
    assert [len(one.fit.modes) for one in found] == [len(shown.fit.modes), len(other.fit.modes)] == [2, 2]


def test_law_a_test_shares_what_its_records_show_and_leaves_unusable_ones():
    mass = Input("mass", 1.0, (Component("source", Normal(1e-4)),))
    records = (record(1.0, 1), Channel("rest", T, NOISE * np.random.default_rng(3).standard_normal(T.size), "m"),
               record(0.3, 204))  # fmt: skip
    test = DecayTest(name="d", records=records, mass=mass, stiffness="d.k")
    first, unusable, last = test.separated
    assert not isinstance(unusable, Separated)
    assert isinstance(first, Separated)
    assert isinstance(last, Separated)
    assert len(rings(first)) == len(rings(last)) == 1
    assert not rings(separate(records[2], mains=50.0))
    assert len(disentangle(records[2], MAIN).modes) == 1
