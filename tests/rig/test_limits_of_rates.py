"""A line that is faster than anything that can be followed is no motion, and says so at once."""

from __future__ import annotations

import numpy as np
import pytest

from metrology.rig import Rig, Run, simulate, simulate_many

STAMPS = np.arange(0.0, 2.0, 0.01)


@pytest.mark.parametrize("engine", ["compiled", "numpy"])
def test_limit_a_damper_of_a_lost_fit_is_not_followed(engine):
    """A mass in grams for kilograms led a fit to 10²⁴ N·s/m: a motion of it took minutes."""
    run = Run(0.05, t_x=STAMPS)
    found = simulate(Rig(0.025, 1e16, 1e24, taut=0.04), run, engine=engine)
    assert found.status == "invalid"
    assert "too fast" in found.message
    assert np.isnan(found.x).all()


def test_limit_the_other_motions_of_a_call_are_what_they_are_alone():
    run = Run(0.05, t_x=STAMPS)
    rig = Rig(0.025, 1000.0, 2.0, taut=0.04)
    found = simulate_many(rig, run, ("k", "c"), np.array([[1000.0, 2.0], [1e16, 1e24], [900.0, 1.0]]))
    assert found.valid.tolist() == [True, False, True]
    alone = simulate_many(rig, run, ("k", "c"), np.array([[1000.0, 2.0], [900.0, 1.0]]))
    assert np.array_equal(found.x[[0, 2]], alone.x)
    assert np.isnan(found.x[1]).all()
