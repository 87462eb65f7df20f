"""A few readings far off make any fit a poor one: they are left out all the same, and nothing is found in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from response_cases import HELD_OUT, PRIORS, SHORT, runs_of, stated, truth_of

from metrology.diagnostics import Settings, response
from metrology.estimation import MeasuredRun

COUNT = 3


def spiked(run: MeasuredRun, rng: np.random.Generator, stated_as: float) -> MeasuredRun:
    """Three single readings of position and of tension each, 60 standard deviations off; so much of these is stated."""
    changed = {}
    for name in ("x", "T"):
        values = np.array(getattr(run, name))
        at = 20 * rng.choice(np.arange(2, len(values) // 20 - 2), COUNT, replace=False)
        values[at] += 60 * run.noise[name] * rng.choice([-1, 1], COUNT)
        changed[name] = values
    return replace(run, noise={name: size * stated_as for name, size in run.noise.items()}, **changed)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_null_spikes_are_no_effect_where_the_noise_is_stated_too_small(seed):
    rng = np.random.default_rng(seed)
    runs = [spiked(run, rng, 0.5) for run in runs_of(truth_of("nylon"), seed, tests=(*SHORT, *HELD_OUT))]
    settings = Settings("nylon", "r")
    found = response(stated("nylon"), runs, rng=np.random.default_rng(seed), priors=PRIORS, settings=settings)
    assert found.verdict == "nothing missing"
    (note,) = (one for one in found.notes if "outliers" in one)
    # By half of the noise a few others are as far off.
    assert 2 * COUNT * len(runs) <= int(note.split()[0]) < 4 * COUNT * len(runs)


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_planted_spikes_leave_nothing_of_a_large_effect(seed):
    """The stated model loses the motion, so that nothing is far off of it."""
    rng, truth = np.random.default_rng(seed), truth_of("nylon", quadratic=10.0)
    runs = [spiked(run, rng, 1.0) for run in runs_of(truth, seed, tests=(*SHORT, *HELD_OUT))]
    settings = Settings("nylon", "r")
    found = response(stated("nylon"), runs, rng=np.random.default_rng(seed), priors=PRIORS, settings=settings)
    assert (found.verdict, found.named) == ("explained", ("quadratic drag",))
    (note,) = (one for one in found.notes if "outliers" in one)
    assert int(note.split()[0]) == 2 * COUNT * len(runs)
