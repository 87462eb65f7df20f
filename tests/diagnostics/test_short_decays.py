"""Linear decays of few periods with white noise: there is nothing to name in them."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from metrology.decay import DecayTest
from metrology.diagnostics import decay
from metrology.gum import Component, Input, Normal
from metrology.timeseries import Channel

MASS, RATE, OMEGA = 1.0, 0.6, sqrt(30.0**2 - 0.6**2)
NOISE = 1e-5


def released(seed: int, periods: float = 3.0, step: float = 0.0) -> DecayTest:
    """Three releases of few periods, m·x″ + c·x′ + k·x = 0 in closed form; the second with a step of the reading."""
    rng, t = np.random.default_rng(seed), np.arange(0, periods * 2 * pi / OMEGA, 2e-3)
    swing = np.exp(-RATE * t) * (np.cos(OMEGA * t) + RATE / OMEGA * np.sin(OMEGA * t))
    values = [a * swing + NOISE * rng.standard_normal(t.size) for a in (5e-3, 5.2e-3, 4.9e-3)]
    values[1] += step * (t > 0.55 * t[-1])
    records = tuple(Channel(name, t, value, "m") for name, value in zip("abc", values, strict=True))
    mass = Input("m", MASS, (Component("source", Normal(1e-6)),), "kg")
    return DecayTest(name="d", records=records, mass=mass, stiffness="d.k")


@pytest.mark.parametrize("seed", [4, pytest.param(7, marks=pytest.mark.long), pytest.param(9, marks=pytest.mark.long)])
def test_planted_nothing_is_found_in_three_periods(seed: int) -> None:
    """What the fit takes out of the noise at low frequencies was a quiet, over which noise was a drift or a step."""
    found = decay(released(seed), rng=np.random.default_rng(seed))
    assert found.verdict == "nothing missing"
    assert not found.named


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_planted_step_is_found_in_six_periods(seed: int) -> None:
    found = decay(released(seed, 6.0, NOISE), rng=np.random.default_rng(seed))
    assert "hop" in {*found.named, *(name for group in found.groups for name in group)}
