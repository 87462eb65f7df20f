"""Tension readings beside a contact carry no weight, unless a line comes straight so slowly that they follow it."""

from __future__ import annotations

import numpy as np
import pytest

from metrology.estimation import MeasuredRun, lay_out
from metrology.estimation.repeats import REPEATED, without_repeats
from metrology.estimation.response import View, masks
from metrology.rig import Rig, Run, simulate

T = np.arange(0.0, 3.0, 0.005)


def masked(c: float, speed: float, **effects: float) -> int:
    """How many tension readings of a module that coasts into its line carry no weight."""
    rig = Rig(25.0, 24734.25, c, 1.5, length=3.0, effects={name.replace("_", "."): at for name, at in effects.items()})
    run = Run(1.49, v0=speed, t_x=T, t_v=T, t_T=T)
    moved = simulate(rig, run)
    assert "taut" in [event.kind for event in moved.events]
    seen = MeasuredRun("a", run, x=moved.x, v=moved.v, T=moved.T, noise={"x": 2e-4, "v": 2e-3, "T": 5e-3})
    layout = lay_out(rig, ["a"], ("k", "c"), ())
    (use,) = masks(rig, [seen], layout, np.array([one.start for one in layout.unknowns]), View())
    assert use["x"].all()
    return int((~use["T"]).sum())


# (q²·s³/(24·k²))^⅓ = 0.13 mm for 33 mN/m over 3 m: 3.1 N at k; c·v is 1.5 N or 9 N; 0.1 m/s is too quick for 200 Hz.
@pytest.mark.parametrize(
    ("c", "speed", "effects", "some"),
    [
        (48.81, 0.03, {}, True),
        (48.81, 0.03, {"sag_weight": 0.033}, False),
        (300.0, 0.03, {"sag_weight": 0.033}, True),
        (10.0, 0.1, {"sag_weight": 0.033}, True),
    ],
    ids=["no sag", "catenary", "pulled straight by its dashpot", "too quick"],
)
def test_closed_form_a_line_that_comes_straight_slowly_keeps_its_readings(c, speed, effects, some):
    assert (masked(c, speed, **effects) > 0) == some


def test_law_readings_are_masked_where_the_clock_of_the_cell_shows_the_contact():
    """A reading stamped t is of t − clock.T: the jump at the taut line stands so much later among the stamps."""
    rig, run = Rig(25.0, 24734.25, 48.81, 1.5, effects={"clock.T": 0.02}), Run(1.49, v0=0.03, t_x=T, t_v=T, t_T=T)
    moved = simulate(rig, run)
    (taut,) = (event.t for event in moved.events if event.kind == "taut")
    seen = MeasuredRun("a", run, x=moved.x, v=moved.v, T=moved.T, noise={"x": 2e-4, "v": 2e-3, "T": 5e-3})
    layout = lay_out(rig, ["a"], ("k", "c"), ())
    (use,) = masks(rig, [seen], layout, np.array([one.start for one in layout.unknowns]), View())
    jump = T[int(np.argmax(np.diff(moved.T)[: np.searchsorted(T, taut + 0.05)])) + 1]
    assert jump == pytest.approx(taut + 0.02, abs=0.0105)
    assert not use["T"][np.searchsorted(T, jump)]
    assert use["T"][np.searchsorted(T, taut)]


@pytest.mark.parametrize(("noise", "few"), [(0.2, True), (0.8, False)])
def test_law_equal_readings_in_a_row_count_once_where_noise_does_not_carry_them_over_a_division(noise, few):
    """A module at rest: by 600 readings of one rounding its position was known to a fortieth of what it is."""
    t, rng = np.arange(600) / 200.0, np.random.default_rng(5)
    x = 1e-3 * np.round(100.2 + noise * rng.standard_normal(len(t)))
    kept, left_out = without_repeats(MeasuredRun("a", Run(0.1, t_x=t), x=x, noise={"x": 1e-3}))
    assert kept.used("x").sum() == len(t) - left_out
    assert (left_out > 300) == few
    moving = 1e-3 * np.round(1e3 * t + noise * rng.standard_normal(len(t)))
    assert without_repeats(MeasuredRun("a", Run(0.1, t_x=t), x=moving, noise={"x": 1e-3}))[1] == 0


@pytest.mark.parametrize("seed", range(3))
def test_law_readings_at_rest_keep_their_mean(seed):
    """Where equal readings counted once, the few others had the weight: 1.2 mN off in steps of 10 mN."""
    t, rng = np.arange(2000) / 200.0, np.random.default_rng(seed)
    x = 1e-3 * np.round(0.1 + 0.25 * rng.standard_normal(len(t)))
    kept, left_out = without_repeats(MeasuredRun("a", Run(0.1, t_x=t), x=x, noise={"x": 4e-4}))
    counted = kept.used("x")
    assert left_out > 1000
    assert abs(x[counted].mean() - x.mean()) < 3 * 4e-4 / np.sqrt(counted.sum())


def test_law_of_equal_readings_the_middle_one_stays():
    t = np.arange(30) / 200.0
    x = np.concatenate([np.linspace(0.0, 1e-3, 10), np.full(REPEATED, 5e-3), np.linspace(2e-3, 3e-3, 20 - REPEATED)])
    kept, left_out = without_repeats(MeasuredRun("a", Run(0.1, t_x=t), x=x, noise={"x": 1e-5}))
    assert left_out == REPEATED - 1
    assert np.flatnonzero(~kept.used("x")).tolist() == [
        at for at in range(10, 10 + REPEATED) if at != 10 + REPEATED // 2
    ]
