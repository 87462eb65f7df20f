"""Free decays that are recorded as a velocity or an acceleration: the same mass, spring, damper and causes."""

from __future__ import annotations

from functools import cache
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from metrology.campaign.load import load
from metrology.chain import evaluate
from metrology.coordinate import SENSED
from metrology.decay import DecayTest, analyse
from metrology.diagnostics import decay as diagnosed
from metrology.diagnostics.release import BENT, FORCES
from metrology.diagnostics.release_cut import cut
from metrology.errors import MetrologyError
from metrology.gum.inputs import Input
from metrology.rig import Rig
from metrology.timeseries import Channel

M, K, C = 1.2, 24600.0, 3.0
UNITS = ("m", "m/s", "m/s²")


@cache
def release(order, seed, *, friction=0.0, cubic=0.0, drag=0.0, noise=1e-3, rate=1000.0, duration=3.0):
    """A plate let go, by SciPy; friction turns within 1e-4 of the largest velocity. Noise over the largest reading."""
    size, rng = 1e-3 * (1.1 - 0.1 * seed), np.random.default_rng([seed, order])
    t, omega = np.arange(0.0, duration, 1.0 / rate), np.sqrt(K / M)

    def acceleration(x, v):
        force = K * x + cubic * x**3 + C * v + friction * np.tanh(v / (1e-4 * omega * size)) + drag * v * np.abs(v)
        return -force / M

    found = solve_ivp(
        lambda _, y: [y[1], acceleration(*y)], (0.0, duration), [size, 0.0], "DOP853", t, rtol=1e-9, atol=1e-13,
        max_step=0.3 / omega,
    )  # fmt: skip
    x, v = found.y
    y = (x, v, acceleration(x, v))[order]
    return Channel(f"r{seed}", t, y + noise * np.abs(y).max() * rng.standard_normal(t.size), UNITS[order])


def case(order, **planted):
    records = tuple(release(order, seed, **planted) for seed in (1, 2, 3))
    return DecayTest("d", records, Input("m", M, (), "kg"), "d.k")


@pytest.mark.long
@pytest.mark.parametrize(
    ("order", "effect", "planted", "size"),
    [
        (1, "friction", {"friction": 0.02}, 0.02),
        (2, "friction", {"friction": 0.02}, 0.02),
        (1, "cubic", {"cubic": 5e8}, 5e8),
        (2, "quadratic drag", {"drag": 30.0}, 30.0),
        pytest.param(2, "cubic", {"cubic": 5e8}, 5e8, marks=pytest.mark.study),
        pytest.param(1, "quadratic drag", {"drag": 30.0}, 30.0, marks=pytest.mark.study),
    ],
)
def test_planted_effect_is_named_with_its_size_whatever_the_sensor_shows(order, effect, planted, size):
    found = diagnosed(case(order, **planted), rng=np.random.default_rng(0))
    assert found.verdict == "explained"
    assert [one.effect for one in found.causes if one.verdict == "supported"] == [effect]
    value = next(one for one in found.causes if one.effect == effect).parameters[0]
    assert abs(value.value - size) < 4 * value.u
    assert value.u < 0.02 * size
    for name, true in (("k", K), ("c", C)):
        at = found.supported.names.index(name)
        assert abs(found.supported.values[at] - true) < 4 * found.supported.u[at], name


@pytest.mark.long
@pytest.mark.parametrize("order", [1, 2])
def test_planted_nothing_finds_nothing_whatever_the_sensor_shows(order):
    assert diagnosed(case(order), rng=np.random.default_rng(0)).verdict == "nothing missing"


@pytest.mark.long
@pytest.mark.parametrize("order", [1, 2])
def test_twice_friction_by_the_envelope_is_in_newtons_whatever_the_sensor_shows(order):
    shape = analyse(case(order, friction=0.02)).finding.shape
    assert shape.dry_force == pytest.approx(0.02, rel=0.02)
    drag = analyse(case(order, drag=30.0)).finding.shape
    assert drag.quadratic == pytest.approx(30.0, rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize("bent", [0.0, 0.1])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_limit_a_small_force_along_the_motion_changes_the_readings_as_the_rig_does(order, bent):
    """Viscous drag on the mass is c·v: variation of constants against the exact derivative by c."""
    (parted,) = DecayTest("d", (release(order, 1, noise=1e-5),), Input("m", M, (), "kg"), "d.k").separated
    record = cut("r1", parted, 50.0)
    rig = Rig(M, K, C, attachment="both ways")
    most = np.abs(record.y).max()
    values = (K, C, record.x0, record.v0, *[0.0] * len(FORCES), bent / most, -bent / most**2)
    path = record.path(rig, values)
    pushed = record.pushed(path, -path.v[:, None])[:, 0]
    exact = record.slopes(rig, values, [1])[0]
    assert np.abs(pushed - exact).max() < 2e-4 * np.abs(exact).max()
    # A reading y + β·y² + γ·y³ of means over short blocks.
    straight, cubed = (record.follow(rig, [(*values[:BENT], *bends)])[0] for bends in ((0.0, 0.0), values[BENT:]))
    assert cubed == pytest.approx(
        straight + values[BENT] * straight**2 + values[BENT + 1] * straight**3, abs=2e-3 * most
    )


CAMPAIGN = """\
format: metrology-campaign/1
id: turning
title: A body that turns, by its gyroscope
samples: {wire: {}}
instruments: {eye: {kind: gyroscope}}
tests:
  swing: {method: decay, sample: wire, instruments: INSTRUMENTS, inertia: 0.02 kg*m^2, readings: [r.csv]}
"""


def written(folder, order, instruments="{velocity: eye}", heading="velocity / deg/s"):
    t, rng = np.arange(1500) / 50, np.random.default_rng(order)
    omega, rate = np.sqrt(0.35 / 0.02 - 0.1**2), 0.1
    pole = complex(-rate, omega)
    y = (0.1 * pole**order * np.exp(pole * t)).real
    y = 180 / pi * (y + 1e-4 * omega**order * rng.standard_normal(t.size))
    rows = [f"{stamp:.3f},{value:.12g}" for stamp, value in zip(t, y, strict=True)]
    (folder / "r.csv").write_text("\n".join([f"time / s,{heading}", *rows]) + "\n")
    (folder / "campaign.yaml").write_text(CAMPAIGN.replace("INSTRUMENTS", instruments))
    return load(folder / "campaign.yaml")


@pytest.mark.long
@pytest.mark.parametrize(("order", "quantity"), [(1, "velocity"), (2, "acceleration")])
def test_planted_campaign_of_a_body_that_turns(order, quantity, tmp_path):
    heading = f"{quantity} / {('deg', 'deg/s', 'deg/s^2')[order]}"
    found = evaluate(written(tmp_path, order, f"{{{quantity}: eye}}", heading))
    for one in found.results:
        true = {"k": 0.35, "c": 0.004, "omega_n": np.sqrt(17.5), "zeta": 0.1 / np.sqrt(17.5)}[one.quantity]
        assert abs(one.value - true) < 4 * one.u
        assert one.u < 0.01 * true
    assert found.diagnosis[0].verdict == "nothing missing"


@pytest.mark.parametrize(
    ("instruments", "got"),
    [("{}", "none"), ("{velocity: eye, acceleration: eye}", "'velocity' and 'acceleration'")],
)
def test_refusal_of_no_sensor_or_two(instruments, got, tmp_path):
    with pytest.raises(MetrologyError, match=f"got {got}; expected one of 'displacement', 'velocity'"):
        written(tmp_path, 1, instruments)


def test_refusal_of_records_of_two_quantities():
    records = (release(0, 1), release(2, 2))
    with pytest.raises(MetrologyError, match="m and m/s²; expected one unit in all records"):
        DecayTest("d", records, Input("m", M, (), "kg"), "d.k")
    assert set(UNITS) < set(SENSED)
