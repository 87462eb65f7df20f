"""Derivatives of the readings by every parameter, at and off the nulls of all effects, through several contacts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from independent_rig import Reference
from scipy.integrate import quad
from scipy.optimize import brentq

from metrology.errors import MetrologyError
from metrology.rig import EFFECTS, PARAMETERS, Effect, Force, Rig, Run, pushed, sensitivities, simulate
from metrology.rig.collocation import rule

T10 = np.arange(1001) / 100.0
T = np.arange(0.0, 6.0, 0.02)
RUN = Run.sampled(T, 1.45, force=Force(np.array([0.3, 2.7]), np.array([1.2, 0.9])))
OFF = {
    "mass.factor": 1.02, "free_length.shift": 0.003, "friction.force": 0.02, "friction.static_ratio": 1.3,
    "drag.viscous": 0.3, "drag.quadratic": 3.0, "tilt.angle": 1e-3, "setup.compliance": 1e-4,
    "frame.compliance": 8e-5, "frame.frequency": 100.0, "frame.damping": 0.03, "cubic.stiffness": 3e5,
    "toe.extent": 0.003, "toe.ratio": 0.4, "zener.stiffness": 40.0, "zener.time": 0.5, "damping.amplitude": 300.0,
    "hysteresis.stiffness": 60.0, "hysteresis.yield": 0.002, "sag.weight": 0.016, "thrust.gain": 1.05,
    "thrust.lag": 0.05, "thrust.delay": 0.033, "thrust.fading": 0.02,
    "slip.set": 2e-3, "yaw.arm": 0.05, "yaw.inertia": 1.1,
    "yaw.frequency": 0.6, "yaw.damping": 0.03, "cell.gain": 1.02, "cell.zero": 0.01, "cell.drift": 1e-3,
    "motion.scale": 1.01, "clock.x": -0.0021, "clock.v": -0.001, "clock.T": -0.0043, "hum.x": 1e-3, "hum.v": 1e-3,
    "hum.T": 0.01, "hum.frequency": 38.0, "hum.phase": 0.3, "start.x": 0.002, "start.v": 0.003,
    "even.stiffness": 3e3, "line_damping.quadratic": 300.0, "sine.rate": 5.0, "gain_drift.rate": 1e-3,
    "friction.bias": 0.2, "appendage.mass": 2.0, "appendage.frequency": 4.0, "appendage.damping": 0.03,
    "asymmetric_damping.outward": 3.0, "hose.stiffness": 0.4, "hose.rest": 1.2, "stop.stiffness": 4.0, "stop.gap": 1.49,
    "cell_lag.time": 0.012, "slack.share": 0.3, "slack.place": 0.03, "slack.damping": 0.6,
    "second_branch.stiffness": 25.0, "second_branch.time": 4.0,
}  # fmt: skip
"""Every parameter of an effect off its null."""
WIDE = {
    "m": 2.5e-3, "taut": 1e-3, "start.x": 1e-2, "thrust.delay": 1e-3, "hum.frequency": 1e-2, "mass.factor": 0.1,
    "drag.quadratic": 5.0, "cubic.stiffness": 300.0, "damping.amplitude": 3.0, "hysteresis.stiffness": 1.0,
    "frame.compliance": 0.1, "thrust.gain": 1e-2, "line_damping.quadratic": 0.1, "stop.gap": 1e-2,
}  # fmt: skip
"""Steps over the scale of the parameter, where neither its value nor a hundredth of the scale fits."""
SIXTH = {True: ([-3, -2, -1, 1, 2, 3], [-1 / 60, 3 / 20, -3 / 4, 3 / 4, -3 / 20, 1 / 60]),
          False: (range(7), [-147 / 60, 6, -15 / 2, 20 / 3, -15 / 4, 6 / 5, -1 / 6])}  # fmt: skip
"""Stencils of sixth order, in the middle and at the edge of a range."""


def differences(rig: Rig, name: str, run: Run, h: float) -> dict[str, np.ndarray]:
    value, entry = rig.value(name), rig.parameters[name]
    shifts, weights = SIXTH[value - 3 * h >= entry.low]
    moved = [simulate(rig.with_values({name: value + shift * h}), run, engine="compiled") for shift in shifts]
    return {
        channel: sum(w * getattr(one, channel) for w, one in zip(weights, moved, strict=True)) / h for channel in "xvT"
    }


def worst(rig: Rig, names: list[str], run: Run = RUN) -> dict[str, float]:
    """Largest error over what is allowed, name by name, beside no event.

    Allowed are 1e-6 of the largest value, and, for what is nothing, 1e-9 of the motion over the difference's step.
    """
    found = sensitivities(rig, run, names)
    assert found.valid, found.message
    motion = simulate(rig, run, engine="compiled")
    beside = np.array([abs(T - event.t) for event in motion.events]).min(axis=0) < 0.02
    errors = {}
    for column, name in enumerate(names):
        value, scale = abs(rig.value(name)), rig.parameters[name].scale
        h = WIDE.get(name, 1e-2 if value == 0.0 else 1e-3) * (scale if value == 0.0 or name in WIDE else value)
        expected = differences(rig, name, run, h)
        errors[name] = max(
            np.abs(getattr(found, channel)[:, column] - expected[channel])[~beside].max()
            / (1e-6 * np.abs(expected[channel]).max() + 1e-9 * np.abs(getattr(motion, channel)).max() / h)
            for channel in "xvT"
        )
    return errors


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_twice_every_parameter_off_its_null_against_differences_to_1e_6(effect: Effect) -> None:
    own = [one.name for one in effect.parameters]
    rig = Rig(25.0, 753.33, 35.0, 1.5, length=3.0, effects={name: OFF[name] for name in own})
    assert len([event for event in simulate(rig, RUN).events if event.kind == "taut"]) > 1
    errors = worst(rig, [*own, "m", "k", "c", "taut", "start.x", "thrust.gain", "thrust.delay"])
    assert max(errors.values()) <= 1.0, errors


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_twice_every_size_at_its_null_against_differences_to_1e_6(effect: Effect) -> None:
    rig = Rig(25.0, 753.33, 35.0, 1.5, length=3.0)
    # the lag acts as t·exp(−t/τ) there, and the sag as a root (tests of their own): no difference comes close; the sine
    # acts by its square, so that its derivative is nothing
    apart = ("thrust.lag", "sag.weight", "sine.rate")
    names = [one.name for one in effect.parameters[: effect.sizes] if one.name not in apart]
    errors = worst(rig, names)
    # ε′·|ε′| turns without an event of its own, which costs the differences some digits
    assert not errors or max(errors.values()) <= (4.0 if effect.name == "line_damping" else 1.0), errors


@pytest.mark.long
@pytest.mark.parametrize(
    "effects",
    [{"drag.quadratic": 3.0}, {"friction.force": 0.02}, {"cubic.stiffness": 3e5, "damping.amplitude": 300.0},
     {"sag.weight": 0.016}],
    ids=lambda effects: next(iter(effects)),
)  # fmt: skip
def test_reference_against_differences_of_the_independent_rig_to_1e_6(effects: dict[str, float]) -> None:
    t, name = np.arange(0.0, 4.0, 0.05), next(iter(effects))
    rig = Rig(25.0, 753.33, 35.0, 1.5, length=3.0, effects=effects)
    found = sensitivities(rig, Run.sampled(t, 1.45, force=Force.step(1.2)), [name, "k"])
    beside = np.array([abs(t - event.t) for event in simulate(rig, Run.sampled(t, 1.45, force=Force.step(1.2))).events])
    fine = (beside > 0.01).all(axis=0)
    for column, varied in enumerate((name, "k")):
        # A step at which the rounding of the reference, 1e-12, is well below what is asked; a sagging line curves more.
        moved, h = [], (1e-3 if name == "sag.weight" else 5e-3) * rig.value(varied)
        for shift in (-2, -1, 1, 2):
            value = rig.value(varied) + shift * h
            given = {key.replace(".", "__"): one for key, one in {**effects, varied: value}.items() if key != "k"}
            k = value if varied == "k" else 753.33
            moved.append(Reference(25.0, k, 35.0, 1.5, **given).solve(t, 1.45, 0.0, [(0.0, 1.2)]))
        for channel in "xvT":
            a, b, c, d = (getattr(one, channel) for one in moved)
            expected = (a - 8 * b + 8 * c - d) / (12 * h)
            error = np.abs(getattr(found, channel)[:, column] - expected)[fine].max()
            assert error <= 1e-6 * np.abs(expected).max(), (varied, channel)


@pytest.mark.parametrize("effects", [{}, {"cubic.stiffness": 3e5}, {"sag.weight": 0.016}, {"thrust.lag": 0.05}])
def test_law_a_shift_of_the_clock_gives_the_rate_of_change(effects: dict[str, float]) -> None:
    rig = Rig(25.0, 753.33, 35.0, 1.5, length=3.0, effects=effects)
    found = sensitivities(rig, RUN, ["clock.x", "clock.v", "clock.T"])
    motion = simulate(rig, RUN, engine="compiled")
    np.testing.assert_allclose(found.x[:, 0], -motion.v, rtol=0, atol=1e-9)
    if not effects:  # nothing but thrust and tension acts on the module
        thrust = np.where(T < 0.3, 0.0, np.where(T < 2.7, 1.2, 0.9))
        np.testing.assert_allclose(found.v[:, 1], -(thrust - motion.T) / 25.0, rtol=0, atol=1e-9)
    assert not found.x[:, 1:].any()
    assert not found.T[:, :2].any()


def test_closed_form_free_decay() -> None:
    """x = A·e^(−δt)·(cos ωt + δ/ω·sin ωt): derivatives by start and stiffness, and those of the readings."""
    m, k = 2.0, 50.0
    found = sensitivities(Rig(m, k, attachment="both ways"), Run.sampled(T10, 0.1), ["k", "start.x", "cell.gain", "m"])
    rate = math.sqrt(k / m)
    by_k = -0.1 * np.sin(rate * T10) * T10 / (2 * rate * m)
    np.testing.assert_allclose(found.x[:, 0], by_k, atol=1e-10)
    np.testing.assert_allclose(found.x[:, 1], np.cos(rate * T10), atol=1e-9)
    np.testing.assert_allclose(found.T[:, 2], k * 0.1 * np.cos(rate * T10), atol=1e-9)
    np.testing.assert_allclose(found.x[:, 3], -k / m * by_k, atol=1e-9)
    c, t = 3.0, T10
    delta = c / (2 * m)
    omega = math.sqrt(k / m - delta**2)
    damped = sensitivities(Rig(m, k, c, attachment="both ways"), Run.sampled(t, 0.1), ["start.v", "start.x"])
    np.testing.assert_allclose(damped.x[:, 0], np.exp(-delta * t) * np.sin(omega * t) / omega, atol=1e-9)
    shape = np.exp(-delta * t) * (np.cos(omega * t) + delta / omega * np.sin(omega * t))
    np.testing.assert_allclose(damped.x[:, 1], shape, atol=1e-9)


def test_closed_form_friction_at_its_null_is_one_sided() -> None:
    found = sensitivities(Rig(25.0, 0.0, attachment="none"), Run.sampled(T10, 0.0, 0.5), ["friction.force"])
    np.testing.assert_allclose(found.x[:, 0], -(T10**2) / 2 / 25.0, atol=1e-9)


def test_closed_form_breaking_loose_under_a_growing_force() -> None:
    """F = 0.1·t passes σ·F_c at t_s; from then on m·v = 0.05·(t² − t_s²) − F_c·(t − t_s)."""
    force, ratio, m = 0.05, 1.4, 25.0
    rig = Rig(m, 0.0, attachment="none", effects={"friction.force": force, "friction.static_ratio": ratio})
    run = Run.sampled(T10, 0.0, force=Force([0.0, 10.0], [0.0, 1.0], "linear"))
    found = sensitivities(rig, run, ["friction.static_ratio", "friction.force"])
    loose, moving = ratio * force / 0.1, ratio * force / 0.1 < T10
    jump = -(0.1 * loose - force) / m
    np.testing.assert_allclose(found.v[:, 0], moving * jump * force / 0.1, atol=1e-9)
    np.testing.assert_allclose(found.v[:, 1], moving * (jump * ratio / 0.1 - (T10 - loose) / m), atol=1e-9)


def test_closed_form_a_short_lag_is_a_delay() -> None:
    run = Run.sampled(T10, 0.0, force=Force.step(0.4, 2.0))
    found = sensitivities(Rig(2.0, 0.0, attachment="none"), run, ["thrust.lag"])
    np.testing.assert_allclose(found.v[:, 0], np.where(T10 >= 2.0, -0.4 / 2.0, 0.0), atol=1e-12)


def test_reference_weight_of_a_slack_line_at_its_null() -> None:
    """Without weight the line pulls by nothing, and for each unit of it by τ: s + e = 2τ·asinh(s/(2τ))."""
    length, m, thrust, t = 3.0, 25.0, 0.5, np.linspace(0.0, 4.0, 41)
    run = Run.sampled(t, 1.45, force=Force.step(thrust))
    found = sensitivities(Rig(m, 753.0, 0.0, 1.5, length=length), run, ["sag.weight"])

    def pull(e: float) -> float:
        return brentq(lambda tau: 2 * tau * math.asinh(length / (2 * tau)) - length - e, 1e-3, 1e9, rtol=1e-14)

    contact = math.sqrt(2 * 0.05 * m / thrust)
    for at in np.flatnonzero((t > 0) & (t < contact)):
        lost = quad(lambda s: pull(-0.05 + thrust * s**2 / (2 * m)) / m, 0.0, t[at], epsabs=1e-13, epsrel=1e-12)[0]
        assert found.v[at, 0] == pytest.approx(-lost, rel=1e-6)
        assert found.T[at, 0] == pytest.approx(pull(-0.05 + thrust * t[at] ** 2 / (2 * m)), rel=1e-6)
    heavy = simulate(Rig(m, 753.0, 0.0, 1.5, length=length, effects={"sag.weight": 1e-6}), run, engine="compiled")
    light = simulate(Rig(m, 753.0, 0.0, 1.5, length=length), run, engine="interpreted")
    after = (heavy.x - light.x) / 1e-6
    np.testing.assert_allclose(found.x[:, 0], after, rtol=0, atol=2e-3 * np.abs(after).max())


def test_twice_compliance_at_its_null_behind_a_sagging_line_against_differences() -> None:
    """Slack, the line hardly pulls on it; taut, it pulls by far more: one step has to suit both."""
    rig = Rig(25.0, 15357.0, 18.4, 2.99, length=2.99, weight=0.0332, line_weight="elastic catenary")
    run = Run.sampled(np.arange(0.0, 12.0, 0.02), 2.89, force=Force.step(0.38, 1.0))
    found = sensitivities(rig, run, ["setup.compliance"])
    h = 1e-9
    base, one, two = (simulate(rig.with_values({"setup.compliance": at}), run) for at in (0.0, h, 2 * h))
    for channel in "xvT":
        expected = (4 * getattr(one, channel) - 3 * getattr(base, channel) - getattr(two, channel)) / (2 * h)
        off = np.abs(getattr(found, channel)[:, 0] - expected).max()
        assert off < 1e-3 * np.abs(expected).max()


def test_twice_compiled_and_plain_python_agree() -> None:
    names = ["k", "c", "drag.quadratic", "friction.force", "clock.T"]
    rig = Rig(25.0, 753.33, 35.0, 1.5, effects={"drag.quadratic": 1.0})
    uneven = np.sort(np.random.default_rng(1).uniform(0.0, 4.0, 60))
    run = Run(1.45, force=Force.step(1.2), t_x=uneven, t_v=T[:150], t_T=uneven[::2].copy())
    one, other = (sensitivities(rig, run, names, engine=engine) for engine in ("compiled", "interpreted"))
    for channel in "xvT":
        a, b = getattr(one, channel), getattr(other, channel)
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-8 * np.abs(b).max(axis=0).max())


def test_twice_stamps_of_their_own_and_common_ones() -> None:
    names, rig = list(OFF)[:8], Rig(25.0, 753.33, 35.0, 1.5, effects={"friction.force": 0.02})
    whole = sensitivities(rig, RUN, names)
    part = sensitivities(rig, Run(1.45, force=RUN.force, t_x=T[3::7].copy(), t_T=T[::2].copy()), names)
    assert part.v is None
    np.testing.assert_allclose(part.x, whole.x[3::7], rtol=0, atol=1e-9 * np.abs(whole.x).max())
    np.testing.assert_allclose(part.T, whole.T[::2], rtol=0, atol=1e-9 * np.abs(whole.T).max())


@pytest.mark.long
@pytest.mark.parametrize("shift", [0.0, 2e-3])
@pytest.mark.parametrize(
    "effects",
    [
        {},
        {"friction.force": 0.02},
        {"zener.stiffness": 40.0, "zener.time": 0.5},
        {"frame.compliance": 8e-5, "frame.frequency": 500.0, "frame.damping": 0.03, "slip.set": 2e-3},
        {"appendage.mass": 2.0, "appendage.frequency": 4.0},
    ],
)
def test_twice_many_uneven_stamps_and_a_few_at_a_time(effects: dict[str, float], shift: float) -> None:
    """Many are read between even nodes, those of means over blocks as well, a few by a power series each."""
    rig = Rig(25.0, 753.33, 35.0, 1.5, effects=effects | {"clock.v": shift})
    blocks = np.linspace(3.0, 6.0, 50, endpoint=False)[:, None] + [0.0, 0.023, 0.046]
    uneven = np.concatenate([np.sort(np.random.default_rng(2).uniform(0.0, 3.0, 150)), blocks.ravel()])
    force, names = Force(np.array([0.3, 2.7]), np.array([1.2, -0.9])), ["k", "c", "m", "taut", *effects]
    whole = sensitivities(rig, Run(1.45, 0.02, force=force, t_x=uneven, t_v=uneven, t_T=uneven), names)
    motions = [simulate(rig, Run.sampled(uneven, 1.45, 0.02, force=force), engine=one) for one in ("compiled", "numpy")]
    assert len(motions[0].events) > 1
    for at in range(0, 300, 60):
        few = np.unique(np.concatenate([uneven[at : at + 12], uneven[-1:]]))
        part = sensitivities(rig, Run(1.45, 0.02, force=force, t_x=few, t_v=few, t_T=few), names)
        for channel in "xvT":
            a, b = getattr(whole, channel), getattr(part, channel)
            allowed = 1e-10 * np.abs(a).max(axis=0)
            assert (np.abs(a[at : at + 12] - b[:12]) <= allowed).all()
        alone = simulate(rig, Run.sampled(few, 1.45, 0.02, force=force), engine="interpreted")
        for motion in motions:
            np.testing.assert_allclose(motion.x[at : at + 12], alone.x[:12], rtol=0, atol=1e-11)
            np.testing.assert_allclose(motion.T[at : at + 12], alone.T[:12], rtol=0, atol=1e-9)


def test_refusal_of_a_name_and_a_motion_without_an_end() -> None:
    with pytest.raises(MetrologyError, match=r"rig\.kk: got 'kk'"):
        sensitivities(Rig(1.0, 4.0), RUN, ["kk"])
    rig = Rig(1.0, 10.0, attachment="both ways", effects={"cubic.stiffness": -1e4})
    found = sensitivities(rig, Run.sampled(T10, 0.5), ["k"])
    assert (found.valid, "lost its stiffness" in found.message) == (False, True)
    assert np.isnan(found.x[-1]).all()


def test_law_every_parameter_of_an_effect_is_tested() -> None:
    assert set(OFF) == {name for name in PARAMETERS if "." in name}


def test_reference_nodes_of_the_collocation_have_the_same_bits_everywhere() -> None:
    """Abramowitz & Stegun (1964), table 25.6, n = 8, to 15 places; a processor's own last digit is rounded away."""
    half = [0.209299217902479, 0.591700181433142, 0.871740148509607, 1.0]
    nodes = 0.5 * (1.0 + np.array([*(-x for x in reversed(half)), *half]))
    found, integrals, _ = rule()
    assert found.tolist() == np.round(nodes, 14).tolist()
    np.testing.assert_allclose(integrals @ found**6, found**7 / 7, rtol=0, atol=1e-15)


@pytest.mark.parametrize("values", [{}, {"friction.force": 0.02}, {"zener.stiffness": 40.0, "zener.time": 0.5},
                                    {"thrust.lag": 0.05}, {"sag.weight": 0.016}, {"cell.gain": 1.02}])  # fmt: skip
@pytest.mark.parametrize("added", [None, Force(np.array([0.0, 2.0, 6.0]), np.array([0.0, 0.1, 0.05]), "linear")])
def test_twice_small_forces_change_the_channels_as_motions_with_them_do(
    values: dict[str, float], added: Force | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig, run = Rig(25.0, 167.64, 8.0, 1.5, length=3.0, effects=values), replace(RUN, added=added)
    edges = np.linspace(0.3, 5.5, 60)
    forces = 1e-6 * np.column_stack([np.sin(edges), edges < 2.0, np.ones(60)])
    found = pushed(rig, run, edges, forces)
    assert found.valid
    monkeypatch.setattr("metrology.rig.sensitivity._programs", lambda _engine: None)
    apart = pushed(rig, run, edges, forces)
    for name in "xvT":
        true = getattr(apart, name)
        assert np.abs(getattr(found, name) - true).max() < 1e-6 * np.abs(true).max(), name
