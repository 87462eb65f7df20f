"""A force of any form that is missing: how large it is, and where, whatever thrusters and instruments make of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from metrology.diagnostics import Response, free_force
from metrology.diagnostics.families import families
from metrology.diagnostics.laws import Law, of_families, together
from metrology.diagnostics.likelihood import noise
from metrology.diagnostics.line import line
from metrology.diagnostics.subject import Fit
from metrology.estimation import MeasuredRun, Prior
from metrology.rig import Force, Rig, Run, simulate

T = np.arange(0.0, 12.0, 0.03)
NOISE = {"x": 2e-4, "v": 1e-3, "T": 0.02}
PUSH = Force(np.array([-1.0, 4.0, 4.2, 6.0, 6.2, 100.0]), np.array([0.0, 0.0, 0.01, 0.01, 0.0, 0.0]), "linear")


def fitted(effects: dict[str, float]) -> tuple[Response, Fit]:
    """Two runs in which a force of 10 mN from 4 to 6 s is not in the model."""
    rig, rng, runs = Rig(25.0, 167.64, 8.0, taut=1.5, effects=effects), np.random.default_rng(2), []
    for at in range(2):
        start, force = (1.4, 0.12 + 0.03 * at), Force.step(0.3, 1.0)
        moved = simulate(rig, Run.sampled(T, *start, force=force, added=PUSH))
        seen = {name: getattr(moved, name) + u * rng.standard_normal(T.size) for name, u in NOISE.items()}
        runs.append(MeasuredRun(f"run-{at}", Run.sampled(T, *start, force=force), noise=NOISE, **seen))
    subject = Response(rig, tuple(runs), ("k", "c"), (Prior("start.x", per_run=3e-4),))
    fit = subject.fit((), [{}])
    assert fit is not None
    return subject, fit


def forms(effects: dict[str, float]) -> dict[str, free_force.Form]:
    subject, fit = fitted(effects)
    return {one.family: one for one in free_force.forms(fit, subject.families(fit))}


@pytest.fixture(scope="module")
def plain():
    return forms({})


@pytest.mark.long
@pytest.mark.parametrize(
    "effects",
    [
        {"thrust.gain": 0.8},
        {"thrust.delay": 0.5},
        {"free_length.shift": 0.05},
        {"motion.scale": 1.05},
        {"clock.x": 0.1},
    ],
    ids=lambda one: next(iter(one)),
)
def test_law_a_missing_force_is_that_on_the_motion_itself(plain, effects):
    found = forms(effects)
    by_time, stated = found["force of time"], plain["force of time"]
    largest = int(np.argmax(stated.amounts))
    assert stated.at[largest] == pytest.approx(5.0, abs=1.0)
    assert stated.amounts[largest] == pytest.approx(0.01, abs=5e-3)
    np.testing.assert_allclose(by_time.amounts, stated.amounts, rtol=0, atol=0.6 * float(np.median(stated.u)))
    most = [one["tension of elongation"].at.max() for one in (found, plain)]
    assert most[0] == pytest.approx(most[1], rel=0.04)


@pytest.mark.long
@pytest.mark.parametrize(("law", "parameter"), [("tension of elongation", "k"), ("tension of rate of elongation", "c")])
@pytest.mark.parametrize("effects", [{}, {"clock.T": 0.08, "cell.gain": 1.1}], ids=["plain", "cell"])
def test_limit_a_pull_that_is_straight_in_what_it_depends_on_is_a_change_of_k_or_c(law, parameter, effects):
    """Motion and reading of the cell follow a pull of the line: Σ at·hat(at) is the elongation, or its rate, itself.

    A clock that is late by more than one reading has several stamps before the start.
    """
    subject, fit = fitted(effects)
    family = next(one for one in subject.families(fit) if one.effect == law)
    place = fit.index(parameter)
    for number, slope in enumerate(fit.slopes):
        at = fit.problem.blocks[number].uses.index(place)
        found = family.rows[number] @ np.array(list(family.values.values())) / family.amount
        exact = slope[:, at]
        for segment in fit.problem.blocks[number].segments:
            rows = slice(segment.first, segment.last)
            left = np.linalg.norm(found[rows] - exact[rows])
            # Steps of force of 1/40 of a period follow the motion to a hundredth.
            assert left < 0.02 * np.linalg.norm(exact[rows]), segment.name


def test_closed_form_the_straight_part_that_a_law_has_not_is_as_large_as_the_law():
    at = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    law = Law("tension of elongation", 0.0, at, 3.0 * at, np.ones(5), straight={"k": 1.0, "c": -2.0})
    assert law.off == pytest.approx({"k": 3.0, "c": 6.0})
    assert replace(law, straight={}).off == {}
    subject, fit = fitted({})
    families = {one.effect: one.straight for one in subject.families(fit)}
    assert (families["tension of elongation"], families["tension of rate of elongation"]) == ({"k": 1.0}, {"c": 1.0})
    assert not families["force of position"]


def test_limit_more_families_of_laws_are_no_evidence_for_one():
    """Twice the same family is one; a family that explains nothing takes half of the prior from one that does."""
    subject, fit = fitted({})
    here = line(fit, subject.candidates, (), noise(fit, fit.residuals), fit.used)
    every = {one.direction.effect: one for one in families(here, subject.families(fit), fit.used)}
    by_time, of_tension = every["force of time"], every["curve of tension"]
    tried = ([by_time], [by_time, by_time], [by_time, of_tension])
    alone, twice, both = (together(of_families(here, one, frozenset())[0]) for one in tried)
    assert alone.log_bayes > 20
    assert twice.log_bayes == pytest.approx(alone.log_bayes)
    assert both.log_bayes == pytest.approx(alone.log_bayes - np.log(2))
    assert both.family == "force of time"
