"""The zero of a load cell that swings slowly, as an amplifier does by the room: no pull of the line, no curve of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from response_cases import HELD_OUT, PRIORS, SHORT, runs_of, stated, truth_of

from metrology.diagnostics import Settings, response
from metrology.estimation import MeasuredRun


def swinging(run: MeasuredRun, size: float, phase: float) -> MeasuredRun:
    """The same readings with a sine of the cell's zero that turns less than once in the run."""
    t = run.stamps("T")
    assert run.T is not None
    return replace(run, T=run.T + size * np.sin(2 * np.pi * (t - t[0]) / 18.0 + phase))


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_planted_a_zero_that_swings_moves_no_stiffness(seed):
    truth, rng = truth_of("nylon"), np.random.default_rng(seed)
    runs = [swinging(run, 0.02, rng.uniform(0, 2 * np.pi)) for run in runs_of(truth, seed, tests=(*SHORT, *HELD_OUT))]
    settings = Settings("nylon", "r")
    found = response(stated("nylon"), runs, rng=np.random.default_rng(seed), priors=PRIORS, settings=settings)
    assert set(found.named) <= {"cell drift", "cell zero"}
    assert "wander of tension" in found.sentence
    assert found.supported is not None
    known = zip(found.supported.names, found.supported.values, found.supported.u, strict=True)
    for name, value, u in known:
        if name in ("k", "c"):
            assert abs(value - getattr(truth, name)) < 3 * u
