"""Against SciPy's DOP853 at rtol 1e-12 with events, which shares no code with the rig."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from independent_rig import Reference
from scipy.integrate import solve_ivp

from metrology.rig import Force, Rig, Run, simulate

MATERIALS = {"nylon": (167.64, 8.0), "spectra": (753.33, 35.0), "peek": (1810.91, 0.37), "al-1100": (24734.25, 48.81)}
STEP, IMPULSE = [(1.0, 0.62)], [(1.0, 0.62), (2.5, 0.0)]


def worst(rig: Rig, reference: Reference, edges: list[tuple[float, float]], *, x0: float, v0: float = 0.0) -> float:
    """Largest error of x, v and T, each relative to the channel's largest value."""
    t = np.arange(2401) / 200.0
    force = Force(*map(np.array, zip(*edges, strict=True))) if edges else None
    engine = "auto"
    motion = simulate(rig, Run.sampled(t, x0, v0, force=force), engine=engine)
    assert motion.status == "ok", motion.message
    truth = reference.solve(t, x0, v0, edges)
    errors = []
    for name in "xvT":
        expected = getattr(truth, name)
        largest = np.abs(expected).max() or 1.0
        errors.append(np.abs(getattr(motion, name) - expected).max() / largest)
    return max(errors)


def pair(material: str, effects: dict[str, float], **options: object) -> tuple[Rig, Reference]:
    k, c = MATERIALS[material]
    named = {name.replace(".", "__"): value for name, value in effects.items()}
    return Rig(25.0, k, c, 1.5, length=3.0, effects=effects), Reference(25.0, k, c, 1.5, **named)


@pytest.mark.long
@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("thrust", [0.38, 0.62])
@pytest.mark.parametrize("shape", ["step", "impulse"])
def test_reference_base_model_to_1e_8(material: str, thrust: float, shape: str) -> None:
    edges = [(1.0, thrust), (2.5, 0.0)][: 1 if shape == "step" else 2]
    assert worst(*pair(material, {}), edges, x0=1.45) <= 1e-8


@pytest.mark.parametrize("material", ["nylon", "peek"])
def test_reference_catenary_of_eq_3_to_1e_6(material: str) -> None:
    k, c = MATERIALS[material]
    rig = Rig(25.0, k, c, 1.5, length=3.0, weight=0.004, line_weight="catenary")
    assert worst(rig, Reference(25.0, k, c, 1.5, weight=0.004, eq3=True), STEP, x0=1.45) <= 1e-6


@pytest.mark.long
def test_reference_elastic_catenary_of_the_aluminium_tape_to_1e_6() -> None:
    rig = Rig(25.0, 24734.25, 48.81, 1.5, length=3.0, weight=0.033, line_weight="elastic catenary")
    assert worst(rig, Reference(25.0, 24734.25, 48.81, 1.5, sag__weight=0.033), STEP, x0=1.49) <= 1e-6


@pytest.mark.long
def test_reference_several_effects_at_once_to_1e_6() -> None:
    effects = {"friction.force": 0.02, "frame.compliance": 8e-5, "frame.frequency": 100.0, "drag.quadratic": 1.0}
    assert worst(*pair("spectra", effects), STEP, x0=1.45) <= 1e-6
    effects = {"sag.weight": 0.01, "setup.compliance": 1e-4, "cubic.stiffness": 1e5, "friction.force": 0.01}
    assert worst(*pair("spectra", effects), STEP, x0=1.45) <= 1e-6


LATE = ({"tilt.angle": 1e-4}, {"zener.stiffness": 50.0, "zener.time": 0.2})


@pytest.mark.long
@pytest.mark.parametrize("effects", LATE, ids=lambda effects: next(iter(effects)))
def test_reference_late_grazing_contacts_of_the_aluminium_tape_to_1e_6(effects: dict[str, float]) -> None:
    # In the 53rd second T falls through zero and comes back within one step of the search, and so does e, later.
    rig, reference = pair("al-1100", effects)
    t = np.arange(12001) / 200.0
    truth = reference.solve(t, 1.45, 0.0, [(1.0, 0.38)], rtol=1e-11)
    for engine in ("compiled", "numpy"):
        motion = simulate(rig, Run.sampled(t, 1.45, force=Force.step(0.38, 1.0)), engine=engine)
        for name in "xvT":
            expected = getattr(truth, name)
            error = np.abs(getattr(motion, name) - expected).max()
            assert error <= 1e-6 * np.abs(expected).max(), (engine, name)


@pytest.mark.study
def test_reference_stiff_frame_of_the_aluminium_tape_to_1e_6() -> None:
    assert worst(*pair("al-1100", {"frame.compliance": 8e-6}), IMPULSE, x0=1.45) <= 1e-6


@pytest.mark.long
@pytest.mark.parametrize("lag", [0.0, 0.004, 0.05])
@pytest.mark.parametrize("cubic", [0.0, 3e4])
@pytest.mark.parametrize("drag", [0.0, 3.0])
def test_reference_measured_thrust_beside_a_curved_line_to_1e_8(lag: float, cubic: float, drag: float) -> None:
    # A measured thrust changes from one edge to the next, also over the many steps of one regime.
    edges, forces, t = np.array([0.0, 3.0, 6.0, 12.0]), np.array([0.0, 1.0, 0.2, 0.5]), np.arange(1201) / 100

    def rates(s: float, y: np.ndarray) -> list[float]:
        thrust = np.interp(s, edges, forces)
        push = y[2] if lag else thrust
        acceleration = (push - drag * y[1] * abs(y[1]) - 753.0 * y[0] - cubic * y[0] ** 3 - 3.0 * y[1]) / 25.0
        return [y[1], acceleration, (thrust - y[2]) / lag if lag else 0.0]

    y = np.array([0.02, 0.0, 0.0])
    parts = [y[:2, None]]
    for begin, end in pairwise(edges):
        stamps = t[(t > begin) & (t <= end)]
        part = solve_ivp(rates, (begin, end), y, "DOP853", stamps, rtol=1e-12, atol=1e-15, max_step=0.02)
        parts.append(part.y[:2])
        y = part.y[:, -1]
    effects = {"cubic.stiffness": cubic, "thrust.lag": lag, "drag.quadratic": drag}
    rig = Rig(25.0, 753.0, 3.0, 0.0, attachment="both ways", effects=effects)
    motion = simulate(rig, Run.sampled(t, 0.02, force=Force(edges, forces, "linear")))
    for own, expected in zip((motion.x, motion.v), np.concatenate(parts, axis=1), strict=True):
        assert np.abs(own - expected).max() <= 1e-8 * np.abs(expected).max()
