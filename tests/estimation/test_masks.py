"""Tension readings beside a contact carry no weight, unless a line comes straight so slowly that they follow it."""

from __future__ import annotations

import numpy as np
import pytest

from metrology.estimation import MeasuredRun, lay_out
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
