"""Steps of the position in a run: found where they are planted, whatever the noise, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from metrology.estimation import MeasuredRun, Prior
from metrology.estimation.step import first, without
from metrology.rig import Force, Rig, Run, simulate

SIGMA_X, SIGMA_V, RATE, END = 2e-4, 1.5e-3, 100.0, 12.0
AT, SIZE = 6.5, 8e-4


def noise(kind, size, rng):
    if kind == "colour":
        return lfilter([np.sqrt(0.75)], [1.0, -0.5], rng.standard_normal(size + 100))[100:]
    if kind == "heavy":
        return rng.standard_t(3.5, size) * np.sqrt(1.5 / 3.5)
    return rng.standard_normal(size)


def run(kind="white", seed=0, step=0.0, name="a", change=lambda _t, x, v: (x, v)):
    """Swing of a module on its line, 2 ms between the clocks of position and velocity, a scale off by 1 %."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(END * RATE) + 1) / RATE + rng.uniform(-2e-3, 2e-3, int(END * RATE) + 1)
    fall, omega = 0.2, 5.3
    z = 0.06 * np.exp((-fall + 1j * omega) * (t - t[0]))
    earlier = z * np.exp((fall - 1j * omega) * 2e-3)
    x = 1.5 + 1.01 * earlier.real + step * (t >= AT) + SIGMA_X * noise(kind, len(t), rng)
    v = ((-fall + 1j * omega) * z).real + SIGMA_V * noise(kind, len(t), rng)
    if kind == "coarse":
        x = np.round(x / 2.5e-4) * 2.5e-4
    x, v = change(t, x, v)
    return MeasuredRun(name, Run(1.56, 0.0, t_x=t, t_v=t), x=x, v=v)


def cleaned(runs):
    """By the damped swing of the line that holds both ways, which is what these runs are."""
    rig = Rig(25.0, 25.0 * (5.3**2 + 0.2**2), 2 * 25.0 * 0.2, 1.5, attachment="both ways")
    return without(rig, runs, ("k", "c"), [Prior("start.x", per_run=2e-3), Prior("start.v", per_run=0.02)])


@pytest.mark.long
@pytest.mark.parametrize(("kind", "size"), [("white", SIZE), ("colour", 1.6 * SIZE), ("heavy", SIZE), ("coarse", SIZE)])
def test_planted_step_is_found_in_every_noise(kind, size):
    for seed in range(10):
        found = first(run(kind, seed, size))
        assert found is not None
        assert abs(found.time - AT) < 0.15
        assert abs(found.size - size) < 4 * found.u < size


@pytest.mark.long
@pytest.mark.parametrize("kind", ["white", "colour", "heavy", "coarse"])
def test_planted_nothing_is_silent_in_every_noise(kind):
    runs = [run(kind, seed, name=str(seed)) for seed in range(20, 60)]
    assert cleaned(runs) == (tuple(runs), {})


def lost(t, x, v):
    """A quarter of a second in which no velocity was read."""
    gap = (t > 4.0) & (t < 4.25)
    return x, np.where(gap, np.nan, v)


def spiked(_t, x, v):
    """Single readings far off: one of the velocity is a step of its integral."""
    x, v = x.copy(), v.copy()
    x[300] += 30 * SIGMA_X
    v[[500, 800]] += 60 * SIGMA_V
    return x, v


def curved(_t, x, v):
    """A position whose scale bends, by 1 % of the swing at its end."""
    return x + 0.15 * (x - 1.5) ** 2, v


def kicked(t, x, v):
    """A thrust that begins between two readings."""
    late = np.maximum(t - 5.004, 0.0)
    return x + 0.5 * late**2, v + 1.0 * late


@pytest.mark.long
@pytest.mark.parametrize("change", [lost, spiked, curved, kicked])
def test_planted_other_faults_are_no_step(change):
    runs = [run("white", seed, name=str(seed), change=change) for seed in range(10)]
    assert cleaned(runs)[1] == {}


@pytest.mark.parametrize(("k", "digit"), [(160.0, 1e-6), (750.0, 1e-6), (5000.0, 1e-5), (2.5e4, 1e-6)])
def test_planted_contacts_between_readings_without_noise_are_no_step(k, digit):
    """The rule of trapezia errs at a contact, and rounding is all the noise there is."""
    for rate in (50, 100, 500):
        t = np.arange(12 * rate + 1) / rate
        force = Force(np.array([0.0, 3.0]), np.array([1.2, -0.9]))
        motion = simulate(Rig(25.0, k, 0.2 * np.sqrt(k), 1.5), Run.sampled(t, 1.45, 0.05, force=force))
        x, v = (np.round(one / size) * size for one, size in ((motion.x, digit), (motion.v, 5 * digit)))
        assert first(MeasuredRun("a", Run(1.45, 0.05, t_x=t, t_v=t), x=x, v=v)) is None


def test_law_positions_after_a_step_are_left_out_in_every_run_that_has_one():
    """One clear step lets a smaller one of the same sensor count in another run; velocities and other runs stay."""
    runs = [run(seed=1, step=SIZE, name="a"), run(seed=2, step=0.45e-3, name="b"), run(seed=3, name="c")]
    kept_runs, steps = cleaned(runs)
    assert set(steps) == {"a", "b"}
    for before, after in zip(runs, kept_runs, strict=True):
        kept = before.stamps("x") < steps[before.name].time if before.name in steps else np.True_
        assert (after.used("x") == (before.used("x") & kept)).all()
        assert (after.used("v") == before.used("v")).all()
    assert cleaned([runs[1], runs[2]])[1].keys() <= {"b"}


def test_planted_step_under_the_noise_of_the_velocity_is_seen_beside_the_model():
    """Of a sensor that is known to step, and where it does not, nothing is seen."""
    runs = [run(seed=1, step=SIZE, name="a"), run(seed=2, step=SIZE / 4, name="b"), run(seed=3, name="c")]
    assert first(runs[1]) is None
    steps = cleaned(runs)[1]
    assert set(steps) == {"a", "b"}
    assert abs(steps["b"].time - AT) < 0.5
    assert abs(steps["b"].size - SIZE / 4) < SIZE / 10
    assert cleaned(runs[1:])[1] == {}


def test_limit_runs_without_a_velocity_or_with_few_readings_have_no_step():
    whole = run(step=SIZE)
    alone = MeasuredRun("a", Run(1.56, 0.0, t_x=whole.stamps("x")), x=whole.x)
    assert first(alone) is None
    few = replace(whole, use={"v": np.arange(len(whole.v)) < 40})
    assert first(few) is None
