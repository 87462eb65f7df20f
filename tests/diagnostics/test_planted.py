"""An effect is hidden by generators of their own, and must be found; where nothing is hidden, nothing may be found."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
import test_decay as decays
import test_elongation as lines
from response_cases import HELD_OUT, PRIORS, SHORT, runs_of, stated, truth_of

from metrology.decay import DecayTest
from metrology.diagnostics import Settings, decay, elongation, response
from metrology.diagnostics.runs import Response
from metrology.elongation import Reading
from metrology.gum import Component, Input, Normal, Rectangular

TESTS = (*SHORT, *HELD_OUT)


def diagnosed(material: str, seed: int, *, tests=TESTS, workers: int = 2, **extra: float):
    runs = runs_of(truth_of(material, **extra), seed, tests=tests)
    settings = Settings(material, "r", workers=workers)
    return response(stated(material), runs, rng=np.random.default_rng(seed), priors=PRIORS, settings=settings)


@pytest.mark.long
@pytest.mark.parametrize(("material", "seed"), [("nylon", 1), ("peek", 2)])
def test_planted_nothing_is_found_to_be_nothing(material, seed):
    found = diagnosed(material, seed)
    assert found.verdict == "nothing missing"
    assert found.possible == ()
    assert all(test.passed for test in found.tests)


@pytest.mark.long
@pytest.mark.parametrize(
    ("material", "planted", "effect", "parameter"),
    [
        ("nylon", {"friction": 4e-4}, "friction", "friction.force"),
        # With the noise of seed 5 an unlisted pull of the line has odds of 40 to 1 beside the cubic; of seeds 6 to 8
        # and 11 to 13 none has more than even ones.
        ("spectra", {"cubic": 2e4}, "cubic", "cubic.stiffness"),
        ("peek", {"quadratic": 1.0}, "quadratic drag", "drag.quadratic"),
    ],
)
def test_planted_effect_is_named_with_its_size(material, planted, effect, parameter):
    found = diagnosed(material, 6 if effect == "cubic" else 5, **planted)
    assert found.verdict == "explained"
    assert found.named == (effect,)
    (cause,) = (one for one in found.causes if one.effect == effect)
    (size,) = (one for one in cause.parameters if one.name == parameter)
    assert abs(size.value - next(iter(planted.values()))) < 3.5 * size.u
    assert found.extended_model == {parameter: size.value}
    assert max(gain.after for gain in found.gain.values()) < 1.05


@pytest.mark.long
def test_planted_two_effects_are_both_named():
    found = diagnosed("nylon", 6, tests=SHORT, friction=1e-3, tilt=2e-5)
    assert set(found.named) == {"friction", "tilt"}


@pytest.mark.long
def test_planted_effect_of_nobody_is_left_unexplained():
    found = diagnosed("nylon", 7, tests=SHORT, ripple=0.02)
    assert found.verdict == "unexplained"
    assert found.named == ()
    assert found.missing is not None
    assert max(cause.probability for cause in found.causes) < 0.5


@pytest.mark.long
def test_twice_a_diagnosis_is_the_same_to_the_last_digit_with_any_number_of_workers():
    one, other = (diagnosed("nylon", 8, tests=SHORT, friction=1e-3, workers=workers) for workers in (1, 2))
    assert one.causes == other.causes
    assert one.tests == other.tests


def test_law_every_candidate_that_the_runs_can_show_is_screened():
    runs = tuple(runs_of(truth_of("al-1100"), 3, tests=SHORT))
    subject = Response(stated("al-1100"), runs, ("k", "c"), PRIORS)
    base = subject.fit((), [{}])
    screened = {one.effect for one in subject.directions(base, list(subject.candidates))}
    assert set(subject.candidates) - set(subject.untestable()) - screened == set()


@pytest.mark.long
def test_law_set_up_compliance_alone_is_not_testable():
    found = diagnosed("nylon", 1, tests=SHORT)
    by = {cause.effect: cause for cause in found.causes}
    assert by["setup"].verdict == "not testable"
    assert next(one.size for one in found.detectable if one.effect == "setup") is None
    # 0.1 mN of friction shows in such runs, a wrong mass only beyond several of its own uncertainties of 0.2 %.
    sizes = {one.effect: one.size for one in found.detectable}
    assert sizes["friction"] < 1e-3
    assert sizes["mass"] > 4 * 0.002


@pytest.mark.long
def test_planted_friction_of_a_single_run_is_named_and_nothing_else_predicted():
    """What a run alone lacks is seen, though it can be predicted from none: its c was 28 u off, and a limit met."""
    found = diagnosed("nylon", 1, friction=5e-3, tests=SHORT[:1])
    assert found.named == ("friction",)
    assert found.gain == {}
    nothing = diagnosed("nylon", 1, tests=SHORT[:1])
    assert nothing.verdict == "nothing missing"


LOADS = {f"{at}": 0.5 * at for at in range(1, 9)}
EXTRA = {
    "nothing": lambda force, repeat, direction, order: 0.0,
    "curvature": lambda force, repeat, direction, order: 4e-8 * force**2,
    "slip": lambda force, repeat, direction, order: 2e-5 * (repeat == 1 and order > 5),
    "misread": lambda force, repeat, direction, order: 4e-5 * (repeat == 2 and order == 5),
    "drift": lambda force, repeat, direction, order: 2e-6 * order,
}
TWINS = {"curvature": "softening"}
"""At eight loads a knee follows a bend to a third of a standard deviation of a reading: a group, the bend first."""


def stretched(kind: str, seed: int):
    orders: Counter[int] = Counter()

    def extension(force, repeat, direction, rng):
        orders[repeat] += 1
        true = force / 24734.25 + 1e-4 * repeat + EXTRA[kind](force, repeat, direction, orders[repeat] - 1)
        return true + 3e-6 * rng.standard_normal()

    readings: list[Reading] = lines.cycle(extension, seed, masses=LOADS)
    test = lines.build(
        readings,
        LOADS,
        indicator=(Component("certificate", Normal(1e-6)),),
        resolution=Component("resolution", Rectangular(5e-7)),
    )
    return elongation(test, rng=np.random.default_rng(seed))


@pytest.mark.long
@pytest.mark.parametrize("kind", EXTRA)
def test_planted_fault_of_an_elongation_is_named(kind):
    found = stretched(kind, 1)
    possible = () if kind == "nothing" else (kind,)
    assert found.possible in (possible, (*possible, TWINS.get(kind, kind)))
    assert next(cause for cause in found.causes if cause.effect == "frame").verdict == "not testable"


CLEAN = replace(decays.AL, contaminated=False)


@pytest.mark.long
@pytest.mark.parametrize(
    ("rig", "named"),
    [
        (CLEAN, set()),
        (replace(CLEAN, dry=2e-2), {"friction"}),
        (replace(CLEAN, zeta=0.02, drag=100.0), {"quadratic drag"}),
        (decays.AL, {"other", "mains", "drift"}),
    ],
)
def test_planted_shape_of_a_decay_is_named(rig, named):
    rng = np.random.default_rng(3)
    records = tuple(decays.record(rig, rng, name=f"record-{at}") for at in range(3))
    found = decay(DecayTest("d", records, Input("d.mass", 1.2, unit="kg"), "k"), rng=rng)
    assert set(found.possible) == named
