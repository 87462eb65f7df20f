"""Lines with one relaxation time and with two, pulled by a sweep: the second has a name where it is there."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from metrology.diagnostics import Settings, response
from metrology.estimation import MeasuredRun
from metrology.rig import Force, Rig, Run

M, K, C = 20.0, 50.0, 1.0
FAST, SLOW = (12.0, 0.25), (8.0, 4.0)
"""Stiffness / (N/m) and relaxation time / s of each branch."""
T = np.arange(1200) / 20
EDGES = np.arange(0.0, 60.0, 0.25)
NOISE = 2e-4


def swept(number: int, branches: list[tuple[float, float]], rng: np.random.Generator) -> MeasuredRun:
    """m·x″ = F − k·x − c·x′ − Σ k_i·(x − z_i), z_i′ = (x − z_i)/τ_i, by SciPy, under a force that is held in steps."""
    low, high = 0.2 + 0.05 * number, 3.0 + 0.2 * number
    forces = 2.0 * np.sin(low * EDGES + (high - low) * EDGES**2 / (2 * EDGES[-1]))
    k, tau = np.array(branches).T
    # Linear, under a force that is constant between two readings: one map from each to the next, found by integration.
    n = 2 + len(k)

    def rate(_t: float, y: np.ndarray, force: float) -> np.ndarray:
        x, v, z = y[0], y[1], y[2:]
        return np.array([v, (force - K * x - C * v - k @ (x - z)) / M, *((x - z) / tau)])

    def after(y: np.ndarray, force: float) -> np.ndarray:
        return solve_ivp(rate, (0.0, 0.05), y, "DOP853", rtol=1e-12, atol=1e-15, args=(force,)).y[:, -1]

    step, push = np.column_stack([after(one, 0.0) for one in np.eye(n)]), after(np.zeros(n), 1.0)
    y, x = np.zeros(n), []
    for force in np.repeat(forces, 5):
        x.append(y[0])
        y = step @ y + push * force
    drift = np.zeros(len(T))  # noise as an amplifier makes it: a part of each error goes on in the next
    for at, one in enumerate(rng.standard_normal(len(T))):
        drift[at] = (0.3 * drift[at - 1] if at else 0.0) + one
    run = Run(0.0, force=Force(EDGES, forces), t_x=T)
    return MeasuredRun(f"sweep-{number}", run, x=np.array(x) + NOISE * drift)


def diagnosed(branches: list[tuple[float, float]], seed: int, *, without: tuple[str, ...] = (), **effects: float):
    rng = np.random.default_rng(seed)
    runs = tuple(swept(number, branches, rng) for number in range(3))
    rig = Rig(M, 1.1 * K, 0.8 * C, 0.0, attachment="both ways", effects=effects)
    return response(rig, runs, rng=np.random.default_rng(1), settings=Settings(workers=2, without=without))


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_planted_second_relaxation_time_is_named_beside_the_first(seed: int) -> None:
    found = diagnosed([FAST, SLOW], seed)
    assert (found.verdict, set(found.named)) == ("explained", {"zener", "second branch"})
    values = {one.name: one for cause in found.causes for one in cause.parameters}
    pairs = [(values[f"{name}.time"], values[f"{name}.stiffness"]) for name in ("zener", "second_branch")]
    times = sorted(pairs, key=lambda one: one[0].value)
    for (time, stiffness), (k, tau) in zip(times, (FAST, SLOW), strict=True):
        assert abs(time.value - tau) < 3 * time.u
        assert abs(stiffness.value - k) < 3 * stiffness.u
    # One distribution: u beside a cause is u in the budget, the colour of the noise included.
    joint = dict(zip(found.supported.names, found.supported.u, strict=True))
    assert {name: one.u for name, one in values.items() if name in joint} == pytest.approx(
        {name: joint[name] for name in values if name in joint}, rel=0.05
    )


@pytest.mark.long
@pytest.mark.parametrize("branch", [FAST, SLOW], ids=["fast", "slow"])
def test_planted_one_relaxation_time_is_named_alone(branch: tuple[float, float]) -> None:
    found = diagnosed([branch], 3)
    assert (found.verdict, found.named) == ("explained", ("zener",))
    second = next(one for one in found.causes if one.effect == "second branch")
    assert second.verdict == "not supported"


@pytest.mark.long
def test_planted_second_relaxation_time_is_named_beside_a_stated_one() -> None:
    """As of a campaign whose model was extended by the first."""
    found = diagnosed([FAST, SLOW], 4, **{"zener.stiffness": SLOW[0], "zener.time": SLOW[1]})
    assert (found.verdict, found.named) == ("explained", ("second branch",))


@pytest.mark.long
def test_limit_without_the_first_relaxation_time_there_is_no_second() -> None:
    found = diagnosed([FAST], 5, without=("zener",))
    assert not {"zener", "second branch"} & {one.effect for one in found.causes}
