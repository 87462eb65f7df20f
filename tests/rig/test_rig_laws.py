"""Closed forms, conservation laws and limits of the rig."""

from __future__ import annotations

import math

import numpy as np
import pytest

from metrology.rig import Force, Rig, Run, simulate, simulate_many

T10 = np.arange(2001) / 200.0
ENGINES = ["compiled", "numpy", "interpreted"]


def test_closed_form_damped_oscillator() -> None:
    m, k, c = 2.0, 50.0, 1.5
    motion = simulate(Rig(m, k, c, attachment="both ways"), Run.sampled(T10, 0.1))
    decay, rate = c / (2 * m), math.sqrt(k / m - (c / (2 * m)) ** 2)
    envelope = 0.1 * np.exp(-decay * T10)
    x = envelope * (np.cos(rate * T10) + decay / rate * np.sin(rate * T10))
    v = -envelope * (rate + decay**2 / rate) * np.sin(rate * T10)
    np.testing.assert_allclose(motion.x, x, atol=1e-14)
    np.testing.assert_allclose(motion.T, k * x + c * v, atol=1e-12)


def test_closed_form_coulomb_decay_loses_the_same_at_each_turn_then_sticks() -> None:
    m, k, friction = 1.0, 100.0, 0.9
    rig = Rig(m, k, attachment="both ways", effects={"friction.force": friction})
    half = math.pi / math.sqrt(k / m)
    turns = np.arange(6) * half
    motion = simulate(rig, Run.sampled(turns, 0.1))
    # ±(0.1 − 2·n·F_c/k): 0.1, −0.082, 0.064, … each turn 0.018 closer
    expected = (0.1 - 2 * friction / k * np.arange(6)) * np.where(np.arange(6) % 2, -1, 1)
    np.testing.assert_allclose(motion.x, expected, atol=1e-14)
    kinds = [event.kind for event in simulate(rig, Run.sampled([0.0, 10.0], 0.1)).events]
    # the next turn would stand at 0.01 and k·0.01 = 1 N still pulls it loose; the one after, at 0.008, does not
    assert kinds == ["turn"] * 5 + ["stick"]


def test_closed_form_coast_with_viscous_and_quadratic_drag() -> None:
    m, b, v0 = 25.0, 0.5, 0.3
    viscous = simulate(Rig(m, 0.0, attachment="none", effects={"drag.viscous": b}), Run.sampled(T10, 0.0, v0))
    np.testing.assert_allclose(viscous.x, v0 * m / b * -np.expm1(-b / m * T10), rtol=1e-13)
    quadratic = simulate(Rig(m, 0.0, attachment="none", effects={"drag.quadratic": b}), Run.sampled(T10, 0.0, v0))
    np.testing.assert_allclose(quadratic.v, v0 / (1 + b * v0 * T10 / m), rtol=1e-9)


def test_closed_form_elastic_catenary_at_rest() -> None:
    k, q, s, thrust = 24734.25, 0.033, 3.0, 0.62
    rig = Rig(25.0, k, 48.81, 0.0, length=s, weight=q, line_weight="elastic catenary")
    x = thrust / k - s + 2 * thrust / q * math.asinh(q * s / (2 * thrust))
    motion = simulate(rig, Run.sampled([0.0, 1.0, 5.0], x, force=Force.step(thrust)))
    np.testing.assert_allclose(motion.x, x, rtol=1e-9)
    np.testing.assert_allclose(motion.T, thrust, rtol=1e-9)


def test_closed_form_tilt_and_thrust_are_one_acceleration() -> None:
    rig = Rig(4.0, 0.0, attachment="none", effects={"tilt.angle": 0.01})
    motion = simulate(rig, Run.sampled(T10, 1.0, force=Force.step(2.0, 3.0)))
    late = np.maximum(T10 - 3.0, 0.0)
    np.testing.assert_allclose(motion.x, 1 + 9.8 * math.sin(0.01) * T10**2 / 2 + 0.5 * late**2 / 2, rtol=1e-13)


def test_closed_form_measured_force_column() -> None:
    t = np.linspace(0.0, 10.0, 2001)
    ramp = Force(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "linear")
    column = Force(t, 0.5 * t, "linear")
    rig = Rig(2.0, 0.0, attachment="none")
    for force in (ramp, column):
        motion = simulate(rig, Run.sampled(T10, 0.0, force=force))
        np.testing.assert_allclose(motion.x, 0.25 * T10**3 / 6, atol=1e-11)


@pytest.mark.parametrize("attachment", ["tether", "both ways"])
@pytest.mark.parametrize("cubic", [0.0, 2e4])
def test_law_energy_is_kept_without_damping_and_friction(attachment: str, cubic: float) -> None:
    m, k, thrust = 25.0, 1810.91, 0.62
    rig = Rig(m, k, 0.0, 1.5, attachment=attachment, effects={"cubic.stiffness": cubic})
    motion = simulate(rig, Run.sampled(T10 * 6, 1.4, force=Force.step(thrust)))
    e = motion.x - 1.5 if attachment == "both ways" else np.maximum(motion.x - 1.5, 0.0)
    energy = m * motion.v**2 / 2 + k * e**2 / 2 + cubic * e**4 / 4 - thrust * motion.x
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7 if cubic else 1e-12)


@pytest.mark.parametrize("damping", [0.0, 8.0, 300.0])
def test_law_a_slack_line_never_pushes(damping: float) -> None:
    rig = Rig(25.0, 167.64, damping, 1.5)
    motion = simulate(rig, Run.sampled(T10 * 6, 1.4, 0.1, force=Force.impulse(0.62, start=0.0, stop=4.0)))
    assert motion.T.min() >= 0.0
    assert motion.T[motion.x < 1.5].max() == 0.0
    slack = (motion.x > 1.5) & (motion.T == 0.0)
    assert slack.any() == (damping > 0)  # with damping, contact ends before the line is back at its free length


def test_law_contact_begins_again_beyond_taut_where_the_module_is_pushed_back_out() -> None:
    # pushed off at once: the pull of an overdamped line is gone at e = 1 mm; a later thrust stretches it from there
    rig = Rig(1.0, 10.0, 100.0, 0.0)
    run = Run.sampled(T10, 0.01, -0.02, force=Force.step(5.0, 0.2))
    motion = simulate(rig, run)
    kinds = [event.kind for event in motion.events if event.kind in ("taut", "slack")]
    at = {event.kind: event.t for event in motion.events}
    assert kinds[:1] == ["taut"]
    assert motion.x[np.searchsorted(T10, at["taut"])] > 0
    assert motion.T.min() >= 0


def test_law_a_held_module_stays_until_it_is_let_go() -> None:
    rig, t = Rig(1.0, 100.0, 0.3, attachment="both ways", effects={"friction.force": 0.01}), T10
    held = simulate(rig, Run.sampled(t, 0.1, held_until=1.0, force=Force.step(1.0, 0.2)))
    free = simulate(rig, Run.sampled(t, 0.1, force=Force.step(1.0)))
    assert (held.x[t < 1.0] == 0.1).all()
    np.testing.assert_allclose(held.x[200:], free.x[:-200], atol=1e-13)


def test_law_an_angle_and_a_torque_are_only_other_units() -> None:
    # the same pendulum as an angle with inertia and torque, and as an arc with mass and force
    arm, mass = 0.7, 1.3
    as_angle = Rig(mass * arm**2, 9.8 * mass * arm, 0.05, attachment="both ways", effects={"friction.force": 0.02})
    as_arc = Rig(mass, 9.8 * mass / arm, 0.05 / arm**2, attachment="both ways", effects={"friction.force": 0.02 / arm})
    angle = simulate(as_angle, Run.sampled(T10, 0.2, force=Force.step(0.3, 2.0)))
    arc = simulate(as_arc, Run.sampled(T10, 0.2 * arm, force=Force.step(0.3 / arm, 2.0)))
    np.testing.assert_allclose(angle.x * arm, arc.x, atol=1e-13)
    np.testing.assert_allclose(angle.T, arc.T * arm, atol=1e-11)


def test_law_any_subset_of_channels_on_their_own_stamps_reads_the_same_motion() -> None:
    rig, force = Rig(25.0, 753.33, 35.0, 1.5), Force.step(0.62, 1.0)
    whole = simulate(rig, Run.sampled(T10, 1.45, force=force))
    keep = np.sort(np.random.default_rng(3).choice(T10.size, 700, replace=False))
    part = simulate(rig, Run(1.45, force=force, t_x=T10[keep], t_T=T10[100::7]))
    assert part.v is None
    np.testing.assert_allclose(part.x, whole.x[keep], rtol=0, atol=1e-14)
    np.testing.assert_allclose(part.T, whole.T[100::7], rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    "effects",
    [{}, {"friction.force": 0.02}, {"zener.stiffness": 40.0}, {"toe.extent": 0.01}, {"drag.quadratic": 1.0},
     {"yaw.arm": 0.1, "thrust.lag": 0.05}, {"slip.set": 0.002, "setup.compliance": 1e-4}],
    ids=lambda effects: "+".join(effects) or "base",
)  # fmt: skip
def test_twice_the_engines_give_the_same_motion(effects: dict[str, float]) -> None:
    rig = Rig(25.0, 167.64, 8.0, 1.5, effects=effects)
    run = Run.sampled(T10, 1.45, force=Force.impulse(0.62, start=0.5, stop=6.0))
    first, *others = (simulate(rig, run, engine=engine) for engine in ENGINES)
    assert [event.kind for event in first.events]
    for other in others:
        assert [event.kind for event in other.events] == [event.kind for event in first.events]
        for name in "xvT":
            largest = np.abs(getattr(first, name)).max()
            np.testing.assert_allclose(getattr(other, name), getattr(first, name), rtol=0, atol=1e-9 * largest)


def test_twice_many_motions_and_one_at_a_time() -> None:
    rig, run = Rig(25.0, 167.64, 8.0, 1.5), Run.sampled(T10, 1.45, force=Force.step(0.62))
    values = np.array([[160.0, 0.0], [170.0, 0.01], [180.0, 0.02]])
    many = simulate_many(rig, run, ["k", "friction.force"], values, threads=2)
    assert many.valid.all()
    for row, (k, friction) in enumerate(values):
        alone = simulate(rig.with_values({"k": k, "friction.force": friction}), run, engine="compiled")
        np.testing.assert_allclose(many.T[row], alone.T, atol=1e-12)


def test_limit_a_bounce_without_end_is_told_not_followed() -> None:
    rig = Rig(25.0, 1e9, 0.0, 0.0)
    motion = simulate(rig, Run.sampled([0.0, 1e4], -1e-6, force=Force.step(5.0)), engine="compiled")
    assert motion.status == "invalid"
    assert "more than 20000 changes of contact" in motion.message
    assert np.isnan(motion.x[1])


def test_limit_a_softening_line_that_gives_way_is_told() -> None:
    rig = Rig(1.0, 10.0, attachment="both ways", effects={"cubic.stiffness": -1e4})
    motion = simulate(rig, Run.sampled(T10, 0.5))
    assert motion.status == "invalid"
    assert "lost its stiffness" in motion.message


def test_limit_a_motion_that_runs_away_under_a_drag_is_told_in_few_steps() -> None:
    # Out beyond what a negative even stiffness holds, drag makes each step shorter than the last without end.
    effects = {"drag.quadratic": 0.46, "even.stiffness": -3587.0}
    away = Run.sampled(np.arange(128) / 30.0, -0.0022, v0=-0.21)
    motion = simulate(Rig(0.1, 43.0, 0.22, attachment="both ways", effects=effects), away)
    assert motion.status == "invalid"
    assert motion.steps < 40_000
    # A rate that is only fast is followed to its end.
    fast = simulate(Rig(0.1, 43.0, 200.0, attachment="both ways", effects={"drag.quadratic": 0.46}), away)
    assert fast.status == "ok"


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("lag", [0.0, 0.3])
def test_closed_form_added_force_is_touched_by_no_thruster(engine: str, lag: float) -> None:
    # (2 kg)·x″ = F_lagged + t/5 from rest; gain and lag act on the thrust alone, which starts at 4 s
    added = Force(np.array([0.0, 4.7, 10.0]), np.array([0.0, 0.94, 2.0]), "linear")
    rig = Rig(2.0, 0.0, attachment="none", effects={"thrust.gain": 1.5, "thrust.lag": lag})
    run = Run.sampled(T10, 0.0, force=Force.step(0.4, 4.0), added=added)
    late = np.maximum(T10 - 4.0, 0.0)
    risen = late - lag * -np.expm1(-late / lag) if lag else late
    motion = simulate(rig, run, engine=engine)
    np.testing.assert_allclose(motion.v, (0.6 * risen + T10**2 / 10) / 2.0, atol=1e-12)
    assert [event.kind for event in motion.events] == ["force"]


@pytest.mark.parametrize("engine", ["compiled", "numpy"])
def test_law_a_measured_force_may_stand_in_either_place(engine: str) -> None:
    column = Force(np.linspace(0.0, 10.0, 101), 0.5 + 0.3 * np.sin(np.linspace(0.0, 10.0, 101)), "linear")
    rig = Rig(25.0, 167.64, 8.0, 1.5, effects={"friction.force": 0.02})
    as_thrust, beside = (
        simulate(rig, Run.sampled(T10, 1.45, **{name: column}), engine=engine) for name in ("force", "added")
    )
    np.testing.assert_allclose(beside.T, as_thrust.T, atol=1e-11)


@pytest.mark.parametrize("engine", ["compiled", "numpy"])
def test_closed_form_a_slowly_growing_force_breaks_the_module_loose_once(engine: str) -> None:
    # F = 0.1·t reaches F_c = 0.05 N at 0.5 s; from then on m·x″ = 0.1·(t − 0.5)
    ramp = Force(np.array([0.0, 10.0]), np.array([0.0, 1.0]), "linear")
    rig = Rig(25.0, 0.0, attachment="none", effects={"friction.force": 0.05})
    motion = simulate(rig, Run.sampled(T10, 0.0, force=ramp), engine=engine)
    np.testing.assert_allclose(motion.x, 0.1 * np.maximum(T10 - 0.5, 0.0) ** 3 / 6 / 25.0, atol=1e-14)
    lagged = rig.with_values({"thrust.lag": 0.1})
    motion = simulate(lagged, Run.sampled(T10, 0.0, force=Force.step(0.38, 1.0)), engine=engine)
    # 0.38·(1 − exp(−s/τ)) reaches F_c after s₀, and drives what is left
    since = np.maximum(T10 - 1.0 + 0.1 * math.log(1 - 0.05 / 0.38), 0.0)
    v = (0.33 * since + 0.33 * 0.1 * np.expm1(-since / 0.1)) / 25.0
    np.testing.assert_allclose(motion.v, v, atol=1e-14)
    assert [event.kind for event in motion.events] == ["force", "slip"]


def test_law_a_sagging_line_is_told_as_taut_where_its_ends_are_its_length_apart() -> None:
    rig = Rig(25.0, 24734.25, 48.81, 1.5, length=3.0, effects={"sag.weight": 0.03})
    t = np.arange(60001) / 5000
    motion = simulate(rig, Run.sampled(t, 1.45, force=Force.step(0.62, 1.0)))
    beyond = motion.x > 1.5
    crossings = t[1:][beyond[1:] != beyond[:-1]]
    told = [event for event in motion.events if event.kind in ("taut", "slack")]
    taut = [event.t for event in told if event.kind == "taut"]
    assert np.abs(np.array(taut) - t[1:][beyond[1:] & ~beyond[:-1]]).max() <= 2e-4
    # Slack where it ceases to pull, or else where it is no longer beyond its length.
    assert len(told) == len(crossings)
    assert [event.kind for event in told] == ["taut", "slack"] * (len(told) // 2)


def test_limit_a_loop_without_stiffness_beside_one_that_has_some() -> None:
    """Its turns are not watched there: it has to stand still, not to run away and take the motion with it."""
    t = np.arange(0.0, 12.0, 0.05)
    rig = Rig(25.0, 167.64, 8.0, taut=1.5, attachment="both ways", effects={"damping.amplitude": 20.0})
    for x0, v0 in ((1.2, 0.2), (1.25, 0.1), (1.3, 0.25), (1.55, 0.15), (1.22, 0.05)):
        run = Run.sampled(t, x0, v0)
        many = simulate_many(rig, run, ["hysteresis.stiffness"], [[0.0], [2e-4]])
        assert many.valid.all(), many.messages
        np.testing.assert_allclose(many.x[0], simulate(rig, run).x, rtol=0, atol=1e-7)
