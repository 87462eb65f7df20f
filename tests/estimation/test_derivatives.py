"""Derivatives of the readings by what the instruments add; those of the motion stand in tests/rig."""

from __future__ import annotations

import numpy as np

from metrology.estimation.response import slopes
from metrology.rig import Force, Rig, Run, simulate

T = np.arange(0.0, 14.0, 0.01)
RUN = Run(0.0, force=Force([1.0], [0.62]), t_x=T, t_v=T, t_T=T)
READS = {
    "cell.gain": 1.01, "cell.zero": 0.02, "cell.drift": 1e-3, "motion.scale": 1.002, "hum.T": 4e-3, "hum.x": 1e-4,
    "hum.frequency": 38.0, "hum.phase": 0.3,
}  # fmt: skip
NAMES = ("k", "c", "hum.T", "hum.x", "hum.frequency", "hum.phase", "cell.gain", "cell.drift", "motion.scale")


def test_closed_form_derivatives_by_what_the_instruments_add():
    """T_read = γ·T + T₀ + T₁·(t − t₀) + a_T·sin(2πf·t + ψ), x_read = κ·x + a_x·sin(2πf·t + ψ)."""
    found = slopes(Rig(25.0, 167.64, 8.0, 0.1, effects=READS), RUN, NAMES, {})
    true = simulate(Rig(25.0, 167.64, 8.0, 0.1), RUN)
    turn = 2 * np.pi * 38.0 * T + 0.3
    expected = {
        ("hum.T", "T"): np.sin(turn), ("hum.x", "T"): 0 * T, ("hum.x", "x"): np.sin(turn), ("hum.T", "x"): 0 * T,
        ("hum.phase", "T"): 4e-3 * np.cos(turn), ("hum.frequency", "x"): 1e-4 * 2 * np.pi * T * np.cos(turn),
        ("cell.gain", "T"): true.T, ("cell.drift", "T"): T, ("motion.scale", "x"): true.x,
    }  # fmt: skip
    for (name, channel), wanted in expected.items():
        column = getattr(found, channel)[:, NAMES.index(name)]
        close = 1e-7 * max(np.abs(wanted).max(), 1e-3)
        np.testing.assert_allclose(column, wanted, rtol=0, atol=close, err_msg=f"{channel} by {name}")


def test_law_a_line_that_never_pulls_has_derivatives_of_exactly_zero():
    """A last digit in their place is information, however little, and a search runs away along it."""
    rig = Rig(25.0, 167.64, 8.0, 0.1)
    short = Run(0.0, force=Force([1.0, 2.0], [0.5, 0.0]), t_x=np.arange(0.0, 4.0, 0.02), t_T=np.arange(0.0, 4.0, 0.05))
    found = slopes(rig, short, ("k", "c"), {})
    assert not found.x.any()
    assert not found.T.any()


def test_limit_impossible_values_and_motions_have_no_derivatives():
    assert slopes(Rig(25.0, 167.64, 8.0, 0.1), RUN, ("k",), {"k": -1.0}) is None
    lost = Rig(1.0, 10.0, 0.0, 0.0, attachment="both ways", effects={"cubic.stiffness": -1e4})
    assert slopes(lost, Run.sampled(T, 0.5), ("k",), {}) is None
