"""A second mode that dies early in a record, as of a struck cantilever: found, and no step of the reading."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from scipy.signal import lfilter

from metrology.decay import DecayTest
from metrology.decay.separation import separate
from metrology.diagnostics import decay
from metrology.gum import Component, Input, Normal
from metrology.timeseries import Channel

T = np.arange(6000) / 2000.0
OMEGA, ZETA, NOISE = 2 * pi * 18.0, 0.004, 3e-6


def record(second: float, ratio: float, colour: float, seed: int) -> Channel:
    """1 mm of the first mode, and so much of the second, with noise of first order of one standard deviation."""
    rng = np.random.default_rng(seed)
    first = np.exp(-ZETA * OMEGA * T) * np.cos(OMEGA * T)
    other = np.exp(-3 * ZETA * ratio * OMEGA * T) * np.cos(ratio * OMEGA * T)
    noise = lfilter([np.sqrt(1 - colour**2)], [1, -colour], rng.standard_normal(T.size + 500))[500:]
    return Channel("r", T, 1e-3 * (first + second * other) + NOISE * noise, "m")


@pytest.mark.parametrize("colour", [0.0, 0.6])
@pytest.mark.parametrize("ratio", [6.27, 6.5])  # 6.27: of a cantilever
def test_planted_a_mode_that_dies_early_is_found(ratio, colour):
    for seed in range(4):
        found = separate(record(0.03, ratio, colour, seed), mains=50.0)
        ((mode, size),) = found.fit.others
        assert mode.omega == pytest.approx(ratio * OMEGA, rel=5e-3)
        assert mode.rate == pytest.approx(3 * ZETA * ratio * OMEGA, rel=0.25)
        assert size == pytest.approx(3e-5, rel=0.1)
        assert not found.hops


@pytest.mark.parametrize("colour", [0.0, 0.6])
def test_null_noise_is_no_mode_at_the_beginning_either(colour):
    # Three looks at a chance of 10⁻⁴ each: of thirty records none is to be expected.
    assert not any(separate(record(0.0, 6.5, colour, seed), mains=50.0).fit.others for seed in range(100, 130))


@pytest.mark.long
@pytest.mark.parametrize(("second", "named"), [(0.03, ("other",)), (0.0, ())])
def test_planted_a_mode_that_dies_early_is_no_step(second, named):
    mass = Input("mass", 0.15, (Component("source", Normal(3e-7)),), "kg")
    for seed in (1, 2, 5):
        test = DecayTest(name="d", records=(record(second, 6.5, 0.6, seed),), mass=mass, stiffness="d.k")
        found = decay(test, rng=np.random.default_rng(seed))
        assert found.named == named
        assert found.verdict == ("explained" if named else "nothing missing")


def test_planted_a_mode_of_a_short_record_is_found():
    t = np.arange(300) / 100.0
    value = np.exp(-0.3 * t) * np.cos(2 * pi * 4 * t) + 0.03 * np.cos(2 * pi * 9.3 * t)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(t.size)
    ((mode, size),) = separate(Channel("r", t, 1e-3 * (value + noise), "m"), mains=50.0).fit.others
    assert mode.frequency == pytest.approx(9.3, rel=1e-3)
    assert size == pytest.approx(3e-5, rel=0.05)
