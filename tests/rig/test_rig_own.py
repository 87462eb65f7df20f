"""Effects of the laboratory's own: against SciPy with the term inside, and what is refused."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from metrology.errors import MetrologyError
from metrology.rig import Effect, Force, Own, Parameter, Rig, Run, sensitivities, simulate, simulate_many
from metrology.rig.run import Array

T20 = np.arange(4001) / 200.0
INF = math.inf


def drag(t: Array, x: Array, v: Array, e: Array, T: Array, *, cubic: float) -> Array:
    return -cubic * v**3


def pull(t: Array, x: Array, v: Array, e: Array, T: Array, *, strength: float, place: float) -> Array:
    return strength / (1.0 + ((x - place) / 0.02) ** 2)


def entry(name: str, *parameters: Parameter) -> Effect:
    return Effect(name, name.capitalize(), "F = …", parameters, "seen", "ours")


AIR = Own(entry("air", Parameter("air.cubic", "b₃", "N·s³/m³", 0.0, 0.0, INF, (0.0, 1e3), 1.0, "cubic drag")), drag)
MAGNET = Own(
    entry(
        "magnet",
        Parameter("magnet.strength", "F_m", "N", 0.0, -10.0, 10.0, (0.0, 1.0), 1e-3, "largest pull"),
        Parameter("magnet.place", "x_m", "m", 1.45, -INF, INF, (0.0, 3.0), 1e-3, "where it pulls most"),
    ),
    pull,
)
VALUES = {"air.cubic": 40.0, "magnet.strength": 0.05, "magnet.place": 1.47}


def own_rig(*names: str, k: float = 167.64, c: float = 8.0, **options: float) -> Rig:
    owns = tuple(own for own in (AIR, MAGNET) if own.effect.name in names)
    values = {name: value for name, value in VALUES.items() if name.partition(".")[0] in names}
    return Rig(25.0, k, c, 1.5, effects={**values, **options}, own=owns)


def by_scipy(rig: Rig, t: Array, x0: float, force: float, start: float) -> Array:
    """x, v, T with the terms inside; every change of contact and the thrust ends a piece."""
    given = dict(rig.effects)

    def beside(x: float, v: float) -> float:
        state = (np.zeros(1), np.array([x]), np.array([v]), np.array([x - rig.taut]), np.zeros(1))
        return float(sum(own.force(*state, **own.values(given))[0] for own in rig.own))

    def tension(y: Array, taut: bool) -> float:
        return rig.k * (y[0] - rig.taut) + rig.c * y[1] if taut else 0.0

    def rates(t: float, y: Array, taut: bool, thrust: float) -> list[float]:
        return [y[1], (thrust + beside(y[0], y[1]) - tension(y, taut)) / rig.m]

    def reached(t: float, y: Array, taut: bool, thrust: float) -> float:
        return tension(y, True) if taut else y[0] - rig.taut

    reached.terminal = True
    now, y, taut, out = 0.0, np.array([x0, 0.0]), False, np.full((3, t.size), np.nan)
    while now < t[-1]:
        stop, thrust = (start, 0.0) if now < start else (float(t[-1]), force)
        reached.direction = -1 if taut else 1
        piece = solve_ivp(
            rates, (now, stop), y, method="DOP853", rtol=1e-11, atol=1e-14, events=reached, args=(taut, thrust),
            dense_output=True, max_step=0.3 / math.sqrt(rig.k / rig.m),
        )  # fmt: skip
        inside = (t >= now) & (t <= piece.t[-1])
        states = piece.sol(t[inside])
        out[:2, inside] = states
        out[2, inside] = [tension(state, taut) for state in states.T]
        now, y = piece.t[-1], piece.y[:, -1]
        if piece.status == 1:
            taut = not taut
            y = y + 1e-13 * np.array(rates(now, y, taut, thrust))
            now += 1e-13
    return out


@pytest.mark.long
@pytest.mark.parametrize(
    ("names", "k", "c"), [(["air"], 167.64, 8.0), (["magnet"], 1810.91, 0.37), (["air", "magnet"], 753.33, 35.0)]
)
def test_reference_own_effects_against_solve_ivp_to_1e_6(names: list[str], k: float, c: float) -> None:
    rig = own_rig(*names, k=k, c=c)
    motion = simulate(rig, Run.sampled(T20, 1.45, force=Force.step(0.38, 1.0)))
    assert motion.status == "ok", motion.message
    expected = by_scipy(rig, T20, 1.45, 0.38, 1.0)
    plain = simulate(rig.without_own(), Run.sampled(T20, 1.45, force=Force.step(0.38, 1.0)))
    for ours, theirs, without in zip(
        (motion.x, motion.v, motion.T), expected, (plain.x, plain.v, plain.T), strict=True
    ):
        largest = np.abs(theirs).max()
        assert np.abs(ours - theirs).max() <= 1e-6 * largest
        assert np.abs(without - theirs).max() > 1e-4 * largest


def test_twice_a_viscous_drag_of_our_own_and_the_rigs() -> None:
    size = Parameter("oil.viscous", "b", "N·s/m", 0.0, 0.0, INF, (0.0, 5.0), 0.01, "viscous drag")
    oil = Own(entry("oil", size), lambda t, x, v, e, T, viscous: -viscous * v)
    others = {"friction.force": 0.01, "zener.stiffness": 20.0, "thrust.lag": 0.1, "clock.T": 0.004, "cell.gain": 1.02}
    run = Run.sampled(T20, 1.45, held_until=0.3, force=Force.impulse(0.38, start=1.0, stop=12.0))
    rig = Rig(25.0, 167.64, 8.0, 1.5)
    ours = simulate(Rig(25.0, 167.64, 8.0, 1.5, effects={**others, "oil.viscous": 0.2}, own=(oil,)), run)
    theirs = simulate(rig.with_values({**others, "drag.viscous": 0.2}), run)
    assert ours.status == theirs.status == "ok"
    for name in "xvT":
        expected = getattr(theirs, name)
        np.testing.assert_allclose(getattr(ours, name), expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_law_at_its_null_an_own_effect_is_not_called() -> None:
    def never(*state: Array, **parameters: float) -> Array:
        raise AssertionError("called")

    rig = Rig(25.0, 167.64, 8.0, 1.5, effects={"magnet.place": 1.6}, own=(Own(MAGNET.effect, never),))
    run = Run.sampled(T20, 1.45, force=Force.step(0.38))
    np.testing.assert_array_equal(simulate(rig, run).T, simulate(rig.without_own(), run).T)


def test_law_own_parameters_are_parameters_of_the_rig() -> None:
    rig = own_rig("magnet")
    assert list(rig.parameters)[-2:] == ["magnet.strength", "magnet.place"]
    assert rig.with_values({"magnet.strength": 0.01}).value("magnet.strength") == 0.01
    assert pickle.loads(pickle.dumps(rig)).value("magnet.place") == 1.47
    run = Run.sampled(T20[:801], 1.45, force=Force.step(0.38))
    many = simulate_many(rig, run, ["magnet.strength", "k"], [[0.05, 160.0], [0.0, 170.0]])
    assert many.valid.all()
    np.testing.assert_array_equal(many.x[1], simulate(rig.without_own().with_values({"k": 170.0}), run).x)
    found = sensitivities(rig, run, ["magnet.strength"])
    ends = [simulate(rig.with_values({"magnet.strength": 0.05 + h}), run).x for h in (-1e-4, 1e-4)]
    np.testing.assert_allclose(found.x[:, 0], (ends[1] - ends[0]) / 2e-4, atol=1e-3 * np.abs(found.x).max())


def own_force(force: object) -> Rig:
    return Rig(25.0, 167.64, 8.0, 1.5, effects={"magnet.strength": 1.0}, own=(Own(MAGNET.effect, force),))  # type: ignore[arg-type]


def test_limit_a_force_without_a_solution_ends_with_a_sentence() -> None:
    # a spring of −1e9 N/m tears the module away within a step of the table
    rig = own_force(lambda t, x, v, e, T, strength, place: 1e9 * (x - 1.4))
    motion = simulate(rig, Run.sampled(T20, 1.45))
    assert motion.status == "invalid"
    assert "the force of 'magnet'" in motion.message
    assert np.isnan(motion.x[-1])


def test_limit_a_force_that_is_no_number_ends_with_a_sentence() -> None:
    rig = own_force(lambda t, x, v, e, T, strength, place: np.sqrt(1.48 - x))
    motion = simulate(rig, Run.sampled(T20, 1.45, force=Force.step(0.38)))
    assert motion.status == "invalid"
    assert "no finite number at x = 1.48" in motion.message
    assert np.isfinite(motion.x[:200]).all()
    assert np.isnan(motion.x[-1])


@pytest.mark.parametrize(
    ("force", "said"),
    [
        (lambda t, x, v, e, T, strength, place: x[1:], "own.magnet.force: got shape"),
        (lambda t, x, v, e, T, strength: x, "own.magnet.force: got TypeError"),
        (lambda t, x, v, e, T, strength, place: x.__setitem__(0, 1.0), "own.magnet.force: got ValueError"),
    ],
)
def test_refusal_of_a_function_that_fails(force: object, said: str) -> None:
    with pytest.raises(MetrologyError) as refused:
        simulate(own_force(force), Run.sampled(T20, 1.45))
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("name", "parameter", "null", "said"),
    [
        ("friction", "friction.own", 0.0, "own.name: got 'friction'; expected a name that no effect of the rig has"),
        ("air", "cubic", 0.0, "own.air.parameters: got 'cubic'; expected 'air.' and a name"),
        ("air", "air.T", 0.0, "own.air.parameters: got 'air.T'"),
        ("air", "air.cubic", -1.0, "own.air.cubic.null: got -1.0; expected a number from 0 to inf"),
    ],
)
def test_refusal_of_an_entry(name: str, parameter: str, null: float, said: str) -> None:
    with pytest.raises(MetrologyError) as refused:
        Own(entry(name, Parameter(parameter, "b", "N", null, 0.0, INF, (0.0, 1.0), 1.0, "size")), drag)
    assert said in str(refused.value)


def test_refusal_of_two_effects_of_one_name() -> None:
    with pytest.raises(MetrologyError, match=r"own\.air: got two of that name"):
        Rig(25.0, 100.0, own=(AIR, AIR))
