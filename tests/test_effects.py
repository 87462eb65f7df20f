"""Every effect and every duty: a walk over the files of `metrology/effects`, so that a new one is tested unasked."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent / "rig"))

from independent_rig import Reference

from metrology import effects, units
from metrology.diagnostics.candidate import Candidate, table
from metrology.diagnostics.runs import Response
from metrology.effect import Cause, Effect, Parameter, Pulled, Readings
from metrology.effect.whole import faults
from metrology.errors import MetrologyError
from metrology.estimation import MeasuredRun
from metrology.rig import EFFECTS, Force, Rig, Run, documentation, simulate, simulate_many
from metrology.rig.added_readings import slope
from metrology.rig.hooks import READ

MODEL = Path(__file__).parents[1] / "docs" / "model.md"
EVERY = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
LINES = ("tether", "both ways")
T = np.arange(1201) / 200.0
NYLON, SPECTRA, PEEK, ALUMINIUM = (167.64, 8.0), (753.33, 35.0), (1810.91, 0.37), (24734.25, 48.81)
CASES: dict[str, list[tuple[tuple[float, float], dict[str, float]]]] = {
    "mass": [(NYLON, {"mass.factor": 1.02})],
    "free_length": [(NYLON, {"free_length.shift": 0.003})],
    "friction": [
        (NYLON, {"friction.force": 0.02}),
        (ALUMINIUM, {"friction.force": 0.02}),
        (NYLON, {"friction.force": 0.05, "friction.static_ratio": 1.5}),
        (NYLON, {"friction.force": 0.05, "friction.static_ratio": 1.2, "friction.bias": 0.3}),
    ],
    "drag": [(NYLON, {"drag.viscous": 0.3}), (NYLON, {"drag.quadratic": 3.0}), (ALUMINIUM, {"drag.quadratic": 3.0})],
    "hose": [(NYLON, {"hose.stiffness": 0.4, "hose.rest": 1.2}), (SPECTRA, {"hose.stiffness": 5.0, "hose.rest": 1.5})],
    "stop": [
        (NYLON, {"stop.stiffness": 40.0, "stop.gap": 1.52}),
        (SPECTRA, {"stop.stiffness": 90.0, "stop.gap": -0.01}),
    ],
    "slack": [
        (NYLON, {"slack.share": 0.4, "slack.place": 0.02, "slack.damping": 0.5}),
        (SPECTRA, {"slack.share": 1.0, "slack.place": -0.01}),
    ],
    "tilt": [(PEEK, {"tilt.angle": 1e-3})],
    "appendage": [
        (NYLON, {"appendage.mass": 2.0, "appendage.frequency": 4.0, "appendage.damping": 0.03}),
        (NYLON, {"appendage.mass": 2.0, "appendage.frequency": 4.0, "friction.force": 0.05}),
    ],
    "setup": [(ALUMINIUM, {"setup.compliance": 8e-6})],
    "frame": [(PEEK, {"frame.compliance": 8e-5, "frame.frequency": 100.0})],
    "cubic": [(SPECTRA, {"cubic.stiffness": 3e5}), (NYLON, {"cubic.stiffness": -3e2})],
    "toe": [(SPECTRA, {"toe.extent": 0.003, "toe.ratio": 0.4})],
    "zener": [
        (NYLON, {"zener.stiffness": 40.0, "zener.time": 0.5}),
        (ALUMINIUM, {"zener.stiffness": 4000.0, "zener.time": 0.05}),
    ],
    "second_branch": [
        (NYLON, {"second_branch.stiffness": 30.0, "second_branch.time": 0.3}),
        (NYLON, {"zener.stiffness": 40.0, "zener.time": 0.5, "second_branch.stiffness": 25.0,
                 "second_branch.time": 4.0}),
        (NYLON, {"second_branch.stiffness": 30.0, "second_branch.time": 0.3, "frame.compliance": 8e-5,
                 "frame.frequency": 100.0}),
    ],
    "damping": [(NYLON, {"damping.amplitude": 300.0}), (NYLON, {"damping.amplitude": 300.0, "setup.compliance": 1e-3})],
    "asymmetric_damping": [
        (NYLON, {"asymmetric_damping.outward": 3.0}),
        (ALUMINIUM, {"asymmetric_damping.outward": -20.0, "frame.compliance": 8e-6, "frame.frequency": 300.0}),
        (SPECTRA, {"asymmetric_damping.outward": 10.0, "setup.compliance": 1e-4}),
    ],
    "hysteresis": [(NYLON, {"hysteresis.stiffness": 60.0, "hysteresis.yield": 0.002})],
    "sag": [(PEEK, {"sag.weight": 0.016})],
    "thrust": [(NYLON, {"thrust.gain": 1.05}), (NYLON, {"thrust.lag": 0.05}), (NYLON, {"thrust.delay": 0.0334}),
               (NYLON, {"thrust.fading": 0.02}), (PEEK, {"thrust.fading": 0.05, "thrust.lag": 0.05})],
    "slip": [(NYLON, {"slip.set": 2e-3})],
    "yaw": [(NYLON, {"yaw.arm": 0.05})],
    "cell": [(NYLON, {"cell.gain": 1.02, "cell.zero": 0.01, "cell.drift": 1e-3})],
    "gain_drift": [(NYLON, {"gain_drift.rate": 1e-3})],
    "motion": [(NYLON, {"motion.scale": 1.01})],
    "hum": [(NYLON, {"hum.T": 0.01, "hum.x": 1e-3, "hum.v": 1e-3})],
    "cell_lag": [
        (NYLON, {"cell_lag.time": 0.02}), (SPECTRA, {"cell_lag.time": 0.2, "clock.T": -0.003}),
        (SPECTRA, {"cell_lag.time": 0.02, "cubic.stiffness": 3e5}),
    ],
    "clock": [(PEEK, {"clock.T": -0.0043, "clock.x": -0.0021, "clock.v": -0.001})],
    "start": [(NYLON, {"start.x": 0.002, "start.v": 0.003})],
    "even": [(SPECTRA, {"even.stiffness": 3e3})],
    "line_damping": [
        (NYLON, {"line_damping.quadratic": 200.0}),
        (NYLON, {"line_damping.quadratic": 200.0, "setup.compliance": 1e-3}),
    ],
    "sine": [(NYLON, {"sine.rate": 5.0})],
}  # fmt: skip
"""Effect → stiffness and damping of a line, and values at which it shows; sizes of all effects stand here."""
TETHER_ONLY = ("sag",)


# ---- what it does to the motion -------------------------------------------------------------------------------------
def rig_with(effect: Effect, line: str, values: dict[str, float]) -> Rig:
    return Rig(25.0, 753.33, 5.0, 1.5, length=3.0, attachment=line, effects=values)


@EVERY
@pytest.mark.parametrize("line", LINES)
def test_limit_it_vanishes_exactly_at_its_null(effect: Effect, line: str) -> None:
    # shapes away from their customary values, sizes at their null
    run = Run.sampled(T, 1.45, force=Force.impulse(0.62, stop=3.0))
    given = {p.name: p.null if i < effect.sizes else p.null * 1.1 for i, p in enumerate(effect.parameters)}
    base, there = (simulate(rig_with(effect, line, values), run) for values in ({}, given))
    for name in "xvT":
        np.testing.assert_array_equal(getattr(base, name), getattr(there, name))


@EVERY
def test_limit_it_grows_from_its_null(effect: Effect) -> None:
    run = Run.sampled(T, 1.45, force=Force.step(0.62))
    base = simulate(rig_with(effect, "tether", {}), run)
    for size in effect.parameters[: effect.sizes]:
        change = []
        for share in (1e-6, 1e-2, 1.0):
            moved = simulate(rig_with(effect, "tether", {size.name: size.null + share * size.scale}), run)
            assert moved.status == "ok"
            change.append(max(np.abs(getattr(moved, n) - getattr(base, n)).max() for n in "xvT"))
        # the sag goes as a power of its weight, and T jumps by c·v where contact shifts past a sample
        assert change[0] < change[2]
        assert change[2] > 1e-9, size.name


@pytest.mark.long
@EVERY
@pytest.mark.parametrize("line", LINES)
def test_reference_an_independent_integrator_finds_the_same_to_1e_7(effect: Effect, line: str) -> None:
    if line == "both ways" and effect.name in TETHER_ONLY:
        return
    for (k, c), values in CASES[effect.name]:
        rig = Rig(25.0, k, c, 1.5, length=3.0, attachment=line, effects=values)
        named = {name.replace(".", "__"): value for name, value in values.items()}
        x0 = 1.45 if line == "tether" else 1.5 - 0.3 * 0.62 / k
        truth = Reference(25.0, k, c, 1.5, line=line, **named).solve(T, x0, 0.0, [(1.0, 0.62)])
        motion = simulate(rig, Run.sampled(T, x0, force=Force.step(0.62, 1.0)))
        assert motion.status == "ok", motion.message
        for name in "xvT":
            expected = getattr(truth, name)
            error = np.abs(getattr(motion, name) - expected).max()
            assert error <= 1e-7 * np.abs(expected).max(), (values, name)


# ---- its derivatives ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("effect", [one for one in EFFECTS if one.tension], ids=lambda effect: effect.name)
def test_law_its_slope_is_the_derivative_of_its_tension(effect: Effect) -> None:
    names = {one.short: CASES[effect.name][0][1][one.name] for one in effect.parameters}
    names |= {"k": 167.64} if effect.name == "sine" else {}
    e = np.linspace(-0.1, 0.1, 21)
    h = 1e-5
    wide = (effect.tension(e + h, **names) - effect.tension(e - h, **names)) / (2 * h)
    found = effect.slope(e, **names)
    assert np.abs(found - wide).max() <= 1e-6 * np.abs(found).max()


@pytest.mark.parametrize("name", sorted(READ))
def test_twice_its_readings_derivative_and_that_of_whole_motions(name: str) -> None:
    values = {"hum.T": 4e-3, "hum.x": 1e-4, "hum.v": 1e-3, "hum.frequency": 38.0, "cell.gain": 1.01}
    rig, run = Rig(25.0, 167.64, 8.0, 1.5, effects=values), Run.sampled(T, 1.45, force=Force.step(0.62))
    true = simulate(Rig(25.0, 167.64, 8.0, 1.5), run)
    found = slope(name, {c: getattr(true, c) for c in "xvT"}, dict.fromkeys("xvT", T), 0.0, rig.vector())
    h = 0.02 * rig.parameters[name].scale
    moved = simulate_many(rig, run, [name], rig.value(name) + h * np.array([[-2.0], [-1.0], [1.0], [2.0]]))
    whole = {c: np.array([1.0, -8.0, 8.0, -1.0]) @ getattr(moved, c) / (12.0 * h) for c in "xvT"}
    largest = max(np.abs(part).max() for part in whole.values())
    for channel in "xvT":
        assert np.abs(found[channel] - whole[channel]).max() <= 1e-6 * largest


# ---- as a cause -----------------------------------------------------------------------------------------------------
@lru_cache
def tried(line: str) -> tuple[Response, set[str]]:
    """Response tests of a rig that has every channel, and the causes that a diagnosis of it tries."""
    t = np.arange(0.0, 6.0, 0.02)
    rig = Rig(25.0, 167.64, 8.0, 1.5, length=3.0, attachment=line)
    runs = []
    for number, thrust in enumerate((0.5, 0.62)):
        run = Run.sampled(t, 1.47, force=Force.step(thrust, 0.5))
        moved, rng = simulate(rig, run), np.random.default_rng(number)
        read = {name: getattr(moved, name) + 1e-5 * rng.standard_normal(t.size) for name in "xvT"}
        runs.append(MeasuredRun(f"r{number}", run, **read, noise=dict.fromkeys("xvT", 1e-5)))
    subject = Response(rig, tuple(runs), ("k", "c"), ())
    fit = subject.fit((), [{}])
    return subject, {one.effect for one in subject.directions(fit, list(subject.candidates))}


def test_law_every_cause_of_a_response_test_is_tried() -> None:
    testable = {one.name for one in table("response").values() if not one.cause.alone}
    found = tried("tether")[1] | tried("both ways")[1]
    assert testable - found == set()
    for line in LINES:
        subject, some = tried(line)
        assert set(subject.candidates) - set(subject.untestable()) == some


@pytest.mark.parametrize("one", table("elongation").values(), ids=lambda one: one.name)
def test_law_every_cause_of_an_elongation_test_adds_to_its_readings(one: Candidate) -> None:
    loads = np.tile([10.0, 20.0, 30.0, 30.0, 20.0, 10.0], 2)
    seen = Readings(loads, np.tile(np.arange(6.0), 2), np.tile([0.0, 0, 0, 1, 1, 1], 2), np.repeat([0, 1], 6))
    shapes = one.shapes(seen, ())
    assert shapes
    assert one.amount(seen) > 0
    columns = [one.cause.reading(seen, *(shape[size.name] for size in one.parameters[1:])) for shape in shapes]
    assert all(np.isfinite(column).all() and np.abs(column).max() > 0 for column in columns)
    assert len({column.tobytes() for column in columns}) == len(columns)


@pytest.mark.parametrize("one", table("tension").values(), ids=lambda one: one.name)
def test_law_every_cause_of_a_tension_test_adds_to_its_readings(one: Candidate) -> None:
    if one.cause.alone:
        assert one.cause.reading is None
        return
    force = np.tile(np.linspace(1.0, 100.0, 50), 2)
    before = [np.linspace(0.0, 60.0, 30), np.linspace(60.0, 1.0, 30), force[:50]]
    past = (np.concatenate(before), np.linspace(-6.0, 10.0, 110))
    seen = Pulled(force, force / 10, np.repeat([1.0, 0.0], 50), most=100.0, middle=50.0, u=1e-6, rate=0.5, history=past)
    shapes = one.shapes(seen, ())
    assert shapes
    assert one.amount(seen) > 0
    columns = [one.cause.reading(seen, *(shape[size.name] for size in one.parameters[1:])) for shape in shapes]
    assert all(np.isfinite(column).all() and np.abs(column).max() > 0 for column in columns)
    assert len({column.tobytes() for column in columns}) == len(columns)


@pytest.mark.parametrize(("course", "J", "exact"), [(0, np.log1p, 1e-10), (1, lambda t: 1 - np.exp(-t), 1e-5)])
def test_twice_creep_between_its_nodes_is_the_superposition_step_by_step(course, J, exact):
    t = np.linspace(0.0, 40.0, 200)
    force = 50.0 * (1 - np.cos(0.7 * t))
    seen = Pulled(np.tile(force, 2), np.tile(t, 2), np.repeat([1.0, 0.0], 200), most=100.0, history=(force, t))
    (creep,) = (one for one in effects.creep.EFFECT.causes if one.method == "tension")
    low, high = creep.limits(seen)["creep.time"]
    for time in (low, 0.11, 3.7, 29.0, high):
        steps = zip(np.diff(force, prepend=0.0), t, strict=True)
        direct = sum(step * J(np.maximum(t - at, 0.0) / time) for step, at in steps)
        found = creep.reading(seen, time, course)
        assert np.abs(found - np.tile(direct, 2)).max() < exact * np.abs(direct).max(), time
    # A copy with other readings does not take over what was computed for these.
    assert replace(seen, history=(2 * force, t)).kept == {}


# ---- what it says ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("effect", effects.EFFECTS, ids=lambda effect: effect.name)
def test_law_its_units_are_si(effect: Effect) -> None:
    sizes = [size for cause in effect.causes for size in cause.sizes if not isinstance(size, str)]
    for one in (*effect.parameters, *sizes):
        assert one.unit == "1" or units.parse(f"1 {one.unit}").factor == 1, one.name


def test_law_the_page_of_the_model_has_every_effect() -> None:
    text = MODEL.read_text(encoding="utf-8")
    assert documentation.renewed(text) == text


# ---- what is missing ------------------------------------------------------------------------------------------------
SIZE = Parameter("toy.size", "s", "N", 0.0, -1.0, 1.0, (-0.5, 0.5), 0.1, "how much")
CAUSE = Cause("response", "toy", ("toy.size",), "none", "nothing", "another", ("time",), amount=0.1)
TOY = Effect("toy", "Toy", "F = s", (SIZE,), "a push", "ours", force=lambda size: size, causes=(CAUSE,))


def test_law_a_whole_effect_has_no_faults() -> None:
    assert list(faults(TOY)) == []


@pytest.mark.parametrize("name", ["title", "equation", "sign", "source", "causes", "force", "parameters"])
def test_refusal_of_an_effect_without(name: str) -> None:
    empty = {"causes": (), "force": None, "parameters": ()}.get(name, "")
    (fault, *_) = faults(replace(TOY, **{name: empty}), "toy.py")
    assert fault.where.startswith("toy.py: toy")
    assert (name if name != "force" else "terms") in fault.where or name == "parameters"


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"unit": ""}, "unit"), ({"symbol": ""}, "symbol"), ({"meaning": ""}, "meaning"), ({"null": None}, "null"),
        ({"null": 2.0}, "null"), ({"plausible": (0.0, 0.0)}, "plausible"), ({"plausible": (0.0, 2.0)}, "plausible"),
        ({"scale": 0.0}, "scale"), ({"name": "other.size"}, "name"),
    ],
)  # fmt: skip
def test_refusal_of_a_parameter_without(change: dict[str, object], field: str) -> None:
    wrong = replace(TOY, parameters=(replace(SIZE, **change),))
    assert any(fault.where.endswith(f".{field}") and fault.expected for fault in faults(wrong, "toy.py"))


@pytest.mark.parametrize(
    "change",
    [
        {"consequence": ""}, {"advice": ""}, {"separate": ""}, {"pictures": ()}, {"pictures": ("sound",)},
        {"sizes": ()}, {"sizes": ("toy.none",)}, {"amount": None}, {"method": "torsion"}, {"needs": ("luck",)},
        {"method": "elongation", "reading": None},
    ],
)  # fmt: skip
def test_refusal_of_a_cause_without(change: dict[str, object]) -> None:
    (fault,) = faults(replace(TOY, causes=(replace(CAUSE, **change),)), "toy.py")
    expected = "reading" if "reading" in change else next(iter(change))
    assert fault.where == f"toy.py: toy: causes['toy'].{expected}"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"force": lambda size, mood: size * mood}, "toy.force: got argument 'mood'; expected one of t, x, v,"),
        ({"tension": lambda e, size: size * e}, "toy.slope: got one of 'tension' and 'slope'"),
        ({"force": None, "damping": lambda e, size: e * size}, "expected linear=False for what is added to the line"),
        ({"force": lambda e, size: e * size}, "expected linear=False for a force by e"),
        ({"readings": {"a": lambda y, size: y * size}}, "toy.readings: got 'a'; expected 'x', 'v' or 'T'"),
        ({"sizes": 2}, "toy.sizes: got 2; expected a number from 1 to 1"),
    ],
)  # fmt: skip
def test_refusal_of_terms_that_do_not_fit(change: dict[str, object], said: str) -> None:
    assert any(said in str(fault) for fault in faults(replace(TOY, **change)))


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        (None, "toy.py: got no effect; expected EFFECT = Effect(…)"),
        (replace(TOY, name="play"), "got 'play'; expected 'toy', as the file is named"),
        (replace(TOY, title="", source=""), "toy.py: toy.source: got nothing; expected where the equation stands"),
    ],
)
def test_refusal_of_a_file_that_is_not_whole(effect: Effect | None, said: str) -> None:
    module = ModuleType("metrology.effects.toy")
    module.__file__ = "toy.py"
    if effect is not None:
        module.EFFECT = effect
    with pytest.raises(MetrologyError) as refused:
        effects.read(module)
    assert said in str(refused.value)
