"""The closed form of the base model against the kernel that carries every effect."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from metrology.rig import Force, Rig, Run, simulate
from metrology.rig.run import Array

ENGINES = ("numpy", "compiled")


def random_rig(random: np.random.Generator, ratio: float, attachment: str) -> Rig:
    """Rig with this damping ratio and everything that the closed form carries."""
    m, omega = random.uniform(0.5, 40.0), 10.0 ** random.uniform(0.0, 1.3)
    effects = {
        "mass.factor": random.uniform(0.9, 1.1), "free_length.shift": random.normal(0.0, 0.01),
        "thrust.gain": random.uniform(0.9, 1.1), "thrust.delay": random.uniform(0.0, 0.1),
        "start.x": random.normal(0.0, 0.01), "cell.gain": 1.02, "cell.zero": 0.1, "motion.scale": 1.01,
        "clock.T": random.choice([0.0, 4e-3]),
    }  # fmt: skip
    c = ratio * 2.0 * m * effects["mass.factor"] * omega
    return Rig(m, m * effects["mass.factor"] * omega**2, c, 1.5, attachment=attachment, effects=effects)  # type: ignore[arg-type]


def random_run(random: np.random.Generator, stamps: Array) -> Run:
    """Start on either side of taut, thrust on and off, held at first now and then."""
    held = random.choice([None, 0.7])
    v0 = 0.0 if held else random.normal(0.0, 0.1)
    edges = np.sort(random.uniform(0.0, 6.0, 4))
    force = Force(edges, random.normal(0.3, 0.5, 4))
    return Run.sampled(stamps, random.normal(1.5, 0.05), v0, held_until=held, force=force)


def even(random: np.random.Generator) -> Array:
    return np.arange(1201) / 150.0


def uneven(random: np.random.Generator) -> Array:
    return np.sort(random.uniform(0.0, 8.0, 300))


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("stamps", [even, uneven])
@pytest.mark.parametrize(
    ("ratio", "attachment"),
    list(product([0.0, 0.01, 0.1, 0.7, 1.0, 1.0 + 1e-9, 3.0], ["tether", "both ways", "none"])),
)
def test_twice_closed_form_and_kernel_agree_to_1e_9(engine: str, stamps: object, ratio: float, attachment: str) -> None:
    random = np.random.default_rng([int(1e3 * ratio), len(attachment)])
    for _ in range(2):
        rig, run = random_rig(random, ratio, attachment), random_run(random, stamps(random))  # type: ignore[operator]
        ours, theirs = simulate(rig, run, engine=engine), simulate(rig, run, engine="interpreted")
        assert ours.status == theirs.status == "ok"
        for name in "xvT":
            expected = getattr(theirs, name)
            assert np.abs(getattr(ours, name) - expected).max() <= 1e-9 * max(1.0, np.abs(expected).max()), name
        found, known = ([(one.kind, round(one.t, 6)) for one in motion.events] for motion in (ours, theirs))
        assert found == known


@pytest.mark.parametrize("engine", ENGINES)
def test_closed_form_critically_damped_spring(engine: str) -> None:
    """x = (1 + 2t)·e^(−2t) for x″ + 4x′ + 4x = 0 from rest at 1."""
    t = np.arange(1001) / 100.0
    motion = simulate(Rig(1.0, 4.0, 4.0, attachment="both ways"), Run.sampled(t, 1.0), engine=engine)
    assert motion.x is not None
    assert np.abs(motion.x - (1.0 + 2.0 * t) * np.exp(-2.0 * t)).max() <= 1e-13


@pytest.mark.parametrize("engine", ENGINES)
def test_limit_a_line_without_damping_keeps_its_energy_over_many_snatches(engine: str) -> None:
    t = np.arange(12001) / 200.0
    motion = simulate(Rig(2.0, 800.0), Run.sampled(t, 0.01, force=Force.step(-0.0)), engine=engine)
    assert motion.x is not None
    assert motion.v is not None
    energy = motion.v**2 + 400.0 * np.maximum(motion.x, 0.0) ** 2
    assert np.abs(energy / energy[0] - 1.0).max() <= 1e-12
