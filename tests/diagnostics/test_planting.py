"""What the blind studies plant and take for known is what the model calls so, though two codes compute it."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from metrology.rig import simulate

sys.path.insert(0, str(Path(__file__).parents[2] / "studies"))

from planting import EVERY, MATERIALS, PLANS, QUIET, distance, drawn, known, stated, unlike

COMMON = replace(PLANS["usual"][0], mass_run=0.0, thrust_run=0.0, length_run=0.0, zero_run=0.0, start_run=0.0)


@pytest.mark.long
@pytest.mark.parametrize("material", MATERIALS)
def test_twice_inputs_drawn_for_all_runs_by_generator_and_rig(material):
    """Mass, thrust, free length, gain, scale and clock drawn by seed: readings without noise are those of the rig."""
    rig = stated(material, on_k=1.0, on_c=1.0)
    errors = known("usual", 3)
    for run in drawn(material, COMMON, {}, 3, **QUIET):
        for values, close in ((errors, True), ({}, False)):
            moved = simulate(rig.with_values(values), run.run)
            far = {
                channel: np.median(np.abs(run.readings(channel) - getattr(moved, channel))) for channel in run.channels
            }
            assert all(part < 2e-3 * run.noise[channel] for channel, part in far.items()) == close, far


@pytest.mark.long
def test_planted_listed_effect_is_not_unlike_the_listed_ones():
    fields = EVERY["friction"].fields(4e-4, "nylon", np.random.default_rng(1))
    assert distance("nylon", "few", fields) > 10
    assert unlike("nylon", "few", fields) < 1


@pytest.mark.long
def test_planted_unlisted_effect_is_unlike_the_listed_ones():
    plant = EVERY["cell curve"]
    fields = plant.fields(plant.amount, "nylon", np.random.default_rng(1))
    assert unlike("nylon", "few", fields) > 0.5 * distance("nylon", "few", fields) > 10
