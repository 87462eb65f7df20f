"""A model that loses the motion: bounces that come late lead nowhere, and yet the cause has to be found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from response_cases import PRIORS, SHORT, runs_of, stated, truth_of

from metrology.diagnose import Response, Settings, response
from metrology.identify import Prior

GIVEN = (*PRIORS, Prior("k", 1.0), Prior("c", 0.05))
"""k and c are known, so that they cannot take over what a model lacks."""
FRICTION = 0.03


@pytest.fixture(scope="module")
def runs():
    return runs_of(truth_of("nylon", friction=FRICTION), 3, tests=SHORT)


@pytest.mark.long
def test_planted_friction_is_named_though_the_base_model_loses_the_motion(runs):
    found = response(
        stated("nylon", on_k=1.0, on_c=1.0),
        runs,
        rng=np.random.default_rng(3),
        free=(),
        priors=GIVEN,
        settings=Settings(),
    )
    assert found.chi_squared[0] > 10
    assert found.named == ("friction",)
    (cause,) = (one for one in found.causes if one.effect == "friction")
    (size,) = (one for one in cause.parameters if one.name == "friction.force")
    assert abs(size.value - FRICTION) < 3.5 * size.u
    assert max(gain.after for gain in found.gain.values()) < 1.05


@pytest.mark.parametrize("far", [0.6, 1.5])
def test_law_a_fit_from_far_off_ends_where_one_from_nearby_does(far):
    measured = runs_of(truth_of("nylon"), 3, tests=SHORT)
    rig = stated("nylon")
    near = Response(rig, tuple(measured), ("k", "c"), PRIORS).fit((), [{}])
    away = Response(replace(rig, k=far * rig.k, c=4 * rig.c), tuple(measured), ("k", "c"), PRIORS).fit((), [{}])
    assert away.cost == pytest.approx(near.cost, abs=0.1)
    assert away.values["k"] == pytest.approx(near.values["k"], rel=1e-4)
