"""A model that loses the motion: bounces that come late lead nowhere, and yet the cause has to be found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from response_cases import PRIORS, SHORT, runs_of, stated, truth_of
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from metrology.decay import DecayTest
from metrology.diagnostics import Response, Settings, response
from metrology.diagnostics.blocks import plain_values
from metrology.diagnostics.decay import Decay
from metrology.diagnostics.plain import Plain
from metrology.diagnostics.search import Search
from metrology.diagnostics.sets import NONE
from metrology.diagnostics.subject import LOST
from metrology.estimation import MeasuredRun, Prior
from metrology.gum.inputs import Input
from metrology.rig import Force, Rig, Run
from metrology.timeseries import Channel

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


@pytest.mark.long
@pytest.mark.parametrize("far", [0.6, 1.5])
def test_law_a_fit_from_far_off_ends_where_one_from_nearby_does(far):
    measured = runs_of(truth_of("nylon"), 3, tests=SHORT)
    rig = stated("nylon")
    near = Response(rig, tuple(measured), ("k", "c"), PRIORS).fit((), [{}])
    away = Response(replace(rig, k=far * rig.k, c=4 * rig.c), tuple(measured), ("k", "c"), PRIORS).fit((), [{}])
    assert away.cost == pytest.approx(near.cost, abs=0.1)
    assert away.values["k"] == pytest.approx(near.values["k"], rel=1e-4)


LINE = {"k": 15e3, "c": 20.0, "weight": 0.033, "length": 3.0}


def hanging(name: str, thrust: float, until: float, rng: np.random.Generator) -> MeasuredRun:
    """A module on an elastic catenary, which the slack line of the paper resembles at first sight."""
    k, c, q, s = LINE.values()
    pull = np.logspace(-2, 2.5, 4000)
    w = 0.5 * q * s / pull
    beyond = pull / k - s * (1 - np.arcsinh(w) / w)
    law = CubicSpline(beyond, np.log(pull))

    def tension(x: float, v: float) -> float:
        static = float(np.exp(law(x - s)))
        share = static * float(law(x - s, 1)) / k  # of the line's own strain in what the ends move apart
        return static + c * share**2 * v

    def rate(t: float, y: np.ndarray) -> list[float]:
        return [y[1], ((thrust if t < until else 0.0) - tension(*y)) / 25.0]

    t, found, y = np.arange(0.0, 16.0, 0.01), [], np.array([s - 0.1, 0.0])
    for first, last in ((0.0, until), (until, 16.0)):
        inside = t[(t >= first) & (t < last)]
        done = solve_ivp(
            rate, (first, last), y, "DOP853", t_eval=[*inside, last], rtol=1e-10, atol=1e-12, max_step=0.02
        )
        found.append(done.y[:, :-1])
        y = done.y[:, -1]
    x, v = np.hstack(found)
    T = np.array([tension(*one) for one in zip(x, v, strict=True)])
    noise = {"x": 2e-4, "v": 2e-3, "T": 4e-3}
    read = {name: one + noise[name] * rng.standard_normal(len(t)) for name, one in zip("xvT", (x, v, T), strict=True)}
    run = Run.sampled(t, s - 0.1, force=Force([0.0, until], [thrust, 0.0]))
    return MeasuredRun(name, run, noise=noise, **read)


@pytest.mark.long
def test_planted_sag_is_the_next_to_be_tried_where_the_straight_line_does_not_lead_to_it():
    """A little of a catenary is no catenary: only a fit of the first moments tells what a whole one does."""
    rng = np.random.default_rng(5)
    runs = (hanging("step", 0.5, 15.9, rng), hanging("impulse", 0.6, 4.0, rng))
    rig = Rig(25.0, LINE["k"], LINE["c"], 3.0, length=3.0, weight=LINE["weight"], line_weight="catenary")
    subject = Response(rig, runs, ("k", "c"), PRIORS)
    base = subject.fit((), [{}])
    assert base.mean_cost > LOST
    search = Search(subject, 8, 1, lambda _text: None, fits={NONE: base})
    here = search.view(base)
    assert frozenset({"sag"}) == search.promising(here)[0]
    (found,) = search.fit_sets(here, [frozenset({"sag"})])
    assert found.mean_cost < 1.1
    assert found.values["sag.weight"] == pytest.approx(LINE["weight"], rel=0.02)
    assert found.values["k"] == pytest.approx(LINE["k"], rel=0.02)


@pytest.mark.long
def test_planted_compliance_that_only_the_stated_stiffness_contradicts_is_the_next_to_be_tried():
    """To the readings it is a softer line; the line as stated is 1.6 times as stiff, and more damped."""
    rng = np.random.default_rng(6)
    runs = (hanging("step", 0.5, 15.9, rng), hanging("impulse", 0.6, 4.0, rng))
    stiffer = 1.6
    compliance = (1 - 1 / stiffer) / LINE["k"]
    sagging = Rig(
        25.0, stiffer * LINE["k"], stiffer**2 * LINE["c"], 3.0, length=3.0, weight=LINE["weight"],
        line_weight="elastic catenary",
    )  # fmt: skip
    subject = Response(sagging, runs, (), (*PRIORS, Prior("k", 300.0), Prior("c", 0.4)))
    base = subject.fit((), [{}])
    search = Search(subject, 8, 1, lambda _text: None, fits={NONE: base})
    here = search.view(base)
    assert here.scores["setup"].z > 20
    (found,) = search.fit_sets(here, search.promising(here)[:1])
    assert found.effects == ("setup",)
    assert found.values["setup.compliance"] == pytest.approx(compliance, rel=0.05)


def on_a_moving_floor() -> DecayTest:
    """Releases on a floor that moves about the resonance: no listed effect follows the motion that it makes."""
    rng, m, omega, t, records = np.random.default_rng(7), 2.0, 12.0, np.arange(0.0, 20.0, 0.02), []
    for at in range(2):
        floor, pushes = np.zeros(len(t)), rng.standard_normal(len(t))
        for one in range(2, len(t)):
            floor[one] = 1.96 * np.cos(12.2 * 0.02) * floor[one - 1] - 0.98**2 * floor[one - 2] + pushes[one]
        floor *= 6e-5 / floor.std()
        moved = solve_ivp(
            lambda s, y, floor=floor: [y[1], -(omega**2) * (y[0] - np.interp(s, t, floor)) - 0.1 * y[1]], (0.0, 20.0),
            [5e-3, 0.0], t_eval=t, rtol=1e-9, atol=1e-12, max_step=0.02,
        ).y[0]  # fmt: skip
        records.append(Channel(f"record-{at}", t, moved + 1e-5 * rng.standard_normal(len(t)), "m"))
    return DecayTest("d", tuple(records), Input("d.mass", m, unit="kg"), "k")


def test_law_a_beginning_of_a_decay_is_the_first_part_of_the_whole():
    posed = Decay(on_a_moving_floor()).subject()
    fit = posed.fit((), [{}])
    counts = [len(posed.blocks[0].y)]
    for beginning in posed.beginnings[::-1]:
        for at, data in enumerate(beginning.blocks):
            own, unknowns = plain_values(fit.values, data.name), beginning.unknowns((), fit.values)
            whole = posed.predict(at, own)[: len(data.y)]
            np.testing.assert_allclose(beginning.predict(at, own), whole, atol=1e-9 * np.ptp(whole))
            some, slopes = (one.slopes(at, own, unknowns[:2]) for one in (beginning, posed))
            np.testing.assert_allclose(some, slopes[:, : len(data.y)], atol=1e-9 * np.ptp(slopes))
        counts.append(len(beginning.blocks[0].y))
    assert (np.diff(counts) < 0).all()


def counted(posed: Plain, readings: list[int]) -> Plain:
    """The same, with the readings of every derivative written down."""

    def slopes(at, values, unknowns):
        readings.append(len(posed.blocks[at].y))
        return posed.slopes(at, values, unknowns)

    return replace(posed, slopes=slopes, beginnings=tuple(counted(one, readings) for one in posed.beginnings))


def test_law_the_derivatives_that_a_fit_and_a_glance_take_are_counted():
    """Each counted as one fit, or as none, whatever it took: 300 s of CPU went into a budget of 60."""
    readings: list[int] = []
    posed = counted(Decay(on_a_moving_floor()).subject(), readings)
    away = posed.fit((), [{"k": 1.4 * posed.common[0].start}])
    assert away.steps > len(posed.beginnings)
    # Another derivative may follow the last step of each of the four searches.
    assert sum(readings) / posed.count == pytest.approx(away.steps, abs=1 + len(posed.beginnings))
    readings.clear()
    _, steps = posed.glance(("cubic",), away.values)
    assert 0 < steps == pytest.approx(sum(readings) / posed.count, abs=posed.beginnings[0].count / posed.count)


@pytest.mark.parametrize(("derivatives", "at_once"), [(0, 2), (150, 1)])
def test_law_no_more_fits_are_begun_than_the_budget_has_left_for(derivatives, at_once):
    """Two that took 14 of a budget of 40 each were begun at 31 of them."""
    texts: list[str] = []
    posed = Decay(on_a_moving_floor()).subject()
    base = posed.fit((), [{}])
    search = Search(posed, 8, 1, texts.append)
    first = search.view(base)
    search.run(replace(first.fit, steps=derivatives), first)
    assert texts[0].count(";") == at_once - 1
