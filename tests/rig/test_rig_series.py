"""The power series of a free motion against the kernel, an independent integrator, and what it must conserve."""

from __future__ import annotations

import numpy as np
import pytest
from independent_rig import Reference

from metrology.rig import Rig, Run, series, simulate_many
from metrology.rig.packing import effective, pack

M, K, C, A = 1.194, 1810.9, 0.37, 1.5e-3
OMEGA = np.sqrt(K / M)
SIZES = {
    "friction.force": 1e-2 * K * A, "friction.static_ratio": 1.5, "drag.viscous": 0.1,
    "drag.quadratic": 0.5 * C / (OMEGA * A), "cubic.stiffness": 0.3 * K / A**2, "damping.amplitude": 0.5 * C / A,
}  # fmt: skip
KINDS = [
    ("drag.quadratic",), ("cubic.stiffness",), ("damping.amplitude",), ("friction.force", "friction.static_ratio"),
    ("friction.force", "drag.viscous"), tuple(SIZES),
]  # fmt: skip


def both(rig: Rig, run: Run, names: tuple[str, ...], rows: list[list[float]]) -> tuple[dict[str, np.ndarray], ...]:
    """The motions by the power series and by the general kernel in NumPy."""
    found = []
    for engine in ("compiled", "numpy"):
        motions = simulate_many(rig, run, names, np.array(rows), engine=engine)
        assert motions.valid.all(), motions.messages
        found.append({name: getattr(motions, name) for name in "xvT"})
    return tuple(found)


@pytest.mark.parametrize("kind", KINDS, ids="+".join)
@pytest.mark.parametrize("zeta", [0.004, 0.3, 1.2])
@pytest.mark.parametrize("start", [(A, 0.0), (0.4 * A, -0.7 * A * OMEGA), (0.0, A * OMEGA)])
def test_twice_series_and_kernel_give_the_same_motion(
    kind: tuple[str, ...], zeta: float, start: tuple[float, float]
) -> None:
    rig = Rig(M, K, 2 * zeta * M * OMEGA, taut=0.3, attachment="both ways")
    t = np.concatenate([[-0.1, 0.0], np.sort(np.random.default_rng(1).uniform(0, 1.5, 300))])
    run = Run.sampled(t, 0.3 + start[0], start[1])
    one, other = both(rig, run, kind, [[SIZES[name] for name in kind]])
    for name in "xvT":
        assert np.abs(one[name] - other[name]).max() <= 2e-8 * np.abs(other[name]).max(), name


def test_twice_held_module_with_clocks_apart_and_scaled_readings() -> None:
    rig = Rig(
        M,
        K,
        C,
        attachment="both ways",
        effects={"clock.x": 2e-3, "clock.T": -1e-3, "motion.scale": 1.01, "cell.gain": 0.9},
    )
    t = np.arange(400) / 200
    run = Run(x0=A, held_until=0.4, t_x=t, t_v=t + 1e-3, t_T=t)
    one, other = both(rig, run, ("cubic.stiffness", "start.x"), [[1e8, 1e-4], [-1e8, -1e-4]])
    for name in "xvT":
        assert np.abs(one[name] - other[name]).max() <= 2e-8 * np.abs(other[name]).max(), name


@pytest.mark.parametrize(
    "effects",
    [{"friction.force": 0.02}, {"cubic.stiffness": 3e4}, {"drag.quadratic": 3.0}, {"damping.amplitude": 300.0}],
)
def test_reference_series_against_an_integrator_that_shares_nothing(effects: dict[str, float]) -> None:
    named = {name.replace(".", "__"): value for name, value in effects.items()}
    t = np.arange(2401) / 200
    truth = Reference(25.0, 753.0, 3.0, 1.5, line="both ways", **named).solve(t, 1.55, 0.0, [])
    rig = Rig(25.0, 753.0, 3.0, 1.5, attachment="both ways")
    motions = simulate_many(rig, Run.sampled(t, 1.55), list(effects), [list(effects.values())], engine="compiled")
    for name in "xvT":
        expected = getattr(truth, name)
        assert np.abs(getattr(motions, name)[0] - expected).max() <= 1e-8 * np.abs(expected).max()


@pytest.mark.parametrize("hardness", [0.9, -0.9])
def test_law_energy_of_a_cubic_spring_is_kept_to_the_last_digits(hardness: float) -> None:
    rig = Rig(M, K, 0.0, attachment="both ways")
    cubic = hardness * K / A**2
    motions = simulate_many(
        rig, Run.sampled(np.arange(8000) / 1000, A), ["cubic.stiffness"], [[cubic]], engine="compiled"
    )
    x, v = motions.x[0], motions.v[0]
    energy = 0.5 * M * v**2 + 0.5 * K * x**2 + 0.25 * cubic * x**4
    assert np.ptp(energy) <= 1e-10 * energy.max()


def test_closed_form_friction_takes_the_same_from_every_half_swing() -> None:
    """Den Hartog: without other damping each half swing is shorter by 2·F_c/k, until the spring no longer moves it."""
    force = 0.03 * K * A
    rig = Rig(M, K, 0.0, attachment="both ways")
    t = np.pi / OMEGA * np.arange(30)
    motions = simulate_many(rig, Run.sampled(t, A), ["friction.force"], [[force]], engine="compiled")
    turns, swings = np.abs(A - 2 * force / K * np.arange(30)), np.abs(motions.x[0])
    stops = int(np.argmax(turns <= force / K))
    assert swings[: stops + 1] == pytest.approx(turns[: stops + 1], abs=1e-12 * A)
    assert np.ptp(swings[stops:]) == 0.0


def test_law_a_spring_that_softens_until_it_lets_go_is_invalid_and_says_so() -> None:
    rig = Rig(M, K, C, attachment="both ways")
    motions = simulate_many(
        rig, Run.sampled(np.arange(500) / 100, A), ["cubic.stiffness"], [[-2 * K / A**2]], engine="compiled"
    )
    assert not motions.valid[0]
    assert "cubic.stiffness" in motions.messages[0]
    assert np.isfinite(motions.x[0][0])
    assert np.isnan(motions.x[0][-1])


def test_twice_series_as_plain_python_and_compiled() -> None:
    rig = Rig(M, K, C, attachment="both ways", effects=SIZES)
    run = Run.sampled(np.arange(50) / 200, A)
    compiled = simulate_many(rig, run, ["k"], [[K]], engine="compiled")
    vectors = np.array(rig.vector(), ndmin=2)
    packed = pack(rig, run, vectors)
    outs, states = tuple(np.empty((1, 50)) for _ in range(3)), np.empty((1, 3))
    series.march_many(effective(vectors, False), packed.start, packed.grids, outs, states)
    np.testing.assert_allclose(outs[0], compiled.x, rtol=1e-12, atol=1e-15)
