"""Records of free decays that a laboratory spoils: a zero that settles, a knock, samples missing behind even stamps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from truth_decay import MATERIALS, Vibrometer, releases

from metrology import decay as methods
from metrology.decay import DecayTest
from metrology.decay.separated import Separated, left_out
from metrology.decay.separation import separate
from metrology.diagnostics import decay
from metrology.gum.inputs import Input
from metrology.timeseries import Channel

M, F, ZETA = 0.35, 1.3, 0.006
"""A mass on a spring: mass / kg, frequency / Hz, damping ratio."""
W = 2 * math.pi * F
K, C = M * W**2, 2 * ZETA * M * W
A, NOISE = 0.03, 3e-5
T = np.arange(2400) / (50 * F)
"""48 periods of 50 readings each."""


def swing(t: np.ndarray, knock: tuple[float, float] = (math.inf, 0.0)) -> np.ndarray:
    """M·x″ + C·x′ + K·x = F from rest at A; `knock`: when a push of a twentieth of a period begins, and its impulse."""
    begun, impulse = knock
    x, now, state = np.empty(len(t)), 0.0, np.array([A, 0.0])
    for end in (min(begun, t[-1]), min(begun + 0.05 / F, t[-1]), t[-1]):
        if end > now:
            push = impulse * F / 0.05 if begun <= now < begun + 0.05 / F else 0.0
            path = solve_ivp(lambda _t, y, push=push: (y[1], (push - C * y[1] - K * y[0]) / M), (now, end), state,
                             "DOP853", rtol=1e-11, atol=1e-14, dense_output=True)  # fmt: skip
            inside = (t >= now) & (t <= end)
            x[inside] = path.sol(t[inside])[0]
            now, state = end, path.y[:, -1]
    return x


def made(*values: np.ndarray, seed: int) -> DecayTest:
    rng = np.random.default_rng(seed)
    records = (Channel(f"r{at}", T, x + 2e-4 + NOISE * rng.standard_normal(len(T)), "m")
               for at, x in enumerate(values))  # fmt: skip
    return DecayTest("d", tuple(records), Input("d.mass", M, unit="kg"), "d.k")


def parted(test: DecayTest) -> list[Separated]:
    found = [one for one in test.separated if isinstance(one, Separated)]
    assert len(found) == len(test.records)
    return found


def are_right(test: DecayTest) -> bool:
    """Whether ω and λ of all direct fits, and so k and c, are within 3.5 standard uncertainties."""
    true = np.array([W * math.sqrt(1 - ZETA**2), ZETA * W])
    return all((np.abs(np.array([one.fit.main.omega, one.fit.main.rate]) - true)
                < 3.5 * np.sqrt(np.diag(one.fit.covariance))).all() for one in parted(test))  # fmt: skip


@pytest.mark.parametrize(("size", "part"), [(0.3, 0.1), (0.3, 0.3), (0.03, 0.1)])
def test_planted_zero_that_settles_is_drift_and_no_motion(size: float, part: float) -> None:
    """It was a transverse motion and a step, each with a probability of 1."""
    test = made(*(swing(T) + size * way * A * np.exp(-T / (part * T[-1])) for way in (1, 1.3)), seed=3)
    for one in parted(test):
        # A slower one is mostly what the polynomial follows.
        assert part > 0.1 or 1 / one.fit.settling == pytest.approx(part * T[-1], rel=0.1)
        assert len(one.fit.modes) == 1
    found = decay(test, rng=np.random.default_rng(1))
    assert (found.verdict, found.named) == ("explained", ("drift",))
    assert are_right(test)


def test_limit_a_zero_that_stays_does_not_settle() -> None:
    assert [one.fit.settling for one in parted(made(swing(T), swing(T), swing(T), seed=4))] == [0.0] * 3


@pytest.mark.parametrize("missing", [1, 7])
def test_planted_samples_missing_behind_even_stamps_are_found(missing: int) -> None:
    """Seven of them made a cubic stiffness of probability 1."""
    at = 700
    later = np.concatenate([T[:at], T[at:] + missing * T[1]])
    test = made(swing(later), seed=5)
    (one,) = parted(test)
    (jump,) = one.jumps
    assert jump.time == pytest.approx(T[at], abs=1.5 * T[1])
    assert jump.keeps_later
    assert float(one.free.time[0]) >= T[at]
    assert "jumps" in one.describe(50.0)
    (said,) = left_out(test)
    assert f"before {jump.time:.4g} s is not evaluated" in said
    assert are_right(test)


def test_planted_knock_is_left_out_and_nothing_else_is_found() -> None:
    """Lines beside the decay that a jump makes had been taken for modes."""
    knocks = ((12.3 / F, 0.1), (31.4 / F, -0.1), (14.15 / F, 0.07))
    test = made(*(swing(T, (begun, size * M * W * A)) for begun, size in knocks), seed=6)
    assert [one.jumps[0].keeps_later for one in parted(test)] == [True, False, True]
    assert [one.jumps[0].time for one in parted(test)] == pytest.approx([begun for begun, _ in knocks], abs=0.1 / F)
    found = decay(test, rng=np.random.default_rng(1))
    assert (found.verdict, found.named) == ("nothing missing", ())
    assert are_right(test)
    finding = methods.analyse(test).finding
    assert all("left out" in record.others for record in finding.records)


@pytest.mark.parametrize("law", [{"stop": 200.0}, {"friction": 3e-3}, {"quadratic": 10.0}, {"cubic": 2e7}])
def test_limit_no_law_of_the_motion_jumps(law: dict[str, float]) -> None:
    """A stop that is touched no longer, and what friction stops, turn the phase otherwise."""
    for t, x in releases(replace(MATERIALS["nylon"], **law), Vibrometer(), 1, np.random.default_rng(19)):
        assert separate(Channel("r", t, x, "m"), mains=50.0).jumps == ()


def test_limit_a_step_of_the_gain_is_no_jump_of_the_phase() -> None:
    (one,) = parted(made(swing(T) * np.where(T > 20.3 / F, 1.05, 1.0), seed=7))
    assert one.jumps == ()
