"""Stacked weights: sums of named masses against the law of propagation done by hand, and what is refused."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import numpy as np
import pytest
import yaml

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError

HEAD = "format: metrology-campaign/1\nid: stacked\ntitle: Stacked weights\n"
G, VALUES, U = 9.81, (0.5, 1.0, 2.0), (0.004, 0.003, 0.005)
MASSES = """\
masses:
  hook: {value: 0.5 kg, uncertainty: [{standard: 4 g, source: balance}]}
  m1: 1.000(3) kg
  m2: {value: 2.0 kg, uncertainty: [{standard: 0.25 %, source: certificate}]}
"""
TEST = """\
instruments:
  indicator: {kind: dial indicator, resolution: 1 nm}
samples:
  line: {length: 1.000 m}
tests:
  pull:
    method: elongation
    sample: line
    instruments: {extension: indicator}
    gravity: 9.81 m/s^2
    air_density: 1e-9 kg/m^3
    weight_density: 8000 kg/m^3
    loads: {A: {mass: hook}, B: {mass: hook + m1}, C: {mass: LAST}}
    readings: pull.csv
"""
STACKS = np.array([[1, 0, 0], [1, 1, 0], [1, 1, 1]], dtype=float)
"""Which masses hang at each load."""


def campaign(folder: Path, text: str):
    forces = G * STACKS @ np.array(VALUES)
    rows = [
        f"{name},{repeat},loading,{1e3 * force / 1e4:.12f}"
        for name, force in zip("ABC", forces, strict=True)
        for repeat in (1, 2, 3)
    ]
    (folder / "pull.csv").write_text("load,repeat,direction,reading / mm\n" + "\n".join(rows) + "\n", encoding="utf-8")
    (folder / "campaign.yaml").write_text(HEAD + text, encoding="utf-8")
    return load(folder / "campaign.yaml")


def stacked(text: str = TEST, last: str = "hook + m1 + m2") -> str:
    return MASSES + text.replace("LAST", last)


def test_closed_form_u_and_correlation_of_stacked_loads(tmp_path: Path):
    found = chain.evaluate(campaign(tmp_path, stacked()))
    covariance = STACKS @ np.diag(np.square(U)) @ STACKS.T
    u = np.sqrt(np.diag(covariance))
    loads = [f"pull.load {name}" for name in "ABC"]
    known = {frozenset((one.a, one.b)): one.coefficient for one in found.input_correlations}
    for i, a in enumerate(loads):
        for j, b in enumerate(loads[:i]):
            assert known[frozenset((a, b))] == pytest.approx(covariance[i, j] / (u[i] * u[j]), rel=1e-9)
    (k,) = found.results
    rows = {name: [row for row in k.budget if row.input == name] for name in loads}
    for name, expected in zip(loads, u, strict=True):
        assert sqrt(sum(row.u**2 for row in rows[name])) == pytest.approx(expected, rel=1e-9)


def test_closed_form_the_hook_that_always_hangs_moves_no_slope(tmp_path: Path):
    """Straight line through exact readings at x = F/k: ∂k/∂m is by hand, and that of the hook is zero."""
    found = chain.evaluate(campaign(tmp_path, stacked()))
    (k,) = found.results
    F = G * STACKS @ np.array(VALUES)
    x = F / 1e4
    d = F - F.mean()

    def stiffness(masses: np.ndarray) -> float:
        """Readings stand; the forces are those of other masses, and the line is by least squares of x on F."""
        force = G * STACKS @ masses
        off = force - force.mean()
        return float((off @ off) / (off @ (x - x.mean())))

    steps = np.eye(3) * 1e-6
    slopes = [(stiffness(VALUES + step) - stiffness(VALUES - step)) / 2e-6 for step in steps]
    assert slopes[0] == pytest.approx(0.0, abs=1e-3)
    assert stiffness(np.array(VALUES)) == pytest.approx(1e4)
    assert (d @ d) > 0
    by_hand = sqrt(sum((slope * u) ** 2 for slope, u in zip(slopes, U, strict=True)))
    assert k.framework.u == pytest.approx(by_hand, rel=1e-3)


def test_law_a_certificate_of_the_whole_set_adds_up_in_a_sum(tmp_path: Path):
    shared = (
        "causes:\n  set: {source: certificate of the set}\nmasses:\n"
        "  hook: {value: 0.5 kg, uncertainty: [{cause: set, standard: 1 g}]}\n"
        "  m1: {value: 1 kg, uncertainty: [{cause: set, standard: 2 g}]}\n"
        "  m2: {value: 2 kg, uncertainty: [{cause: set, standard: 4 g}]}\n"
    )
    found = campaign(tmp_path, shared + TEST.replace("LAST", "hook + m1 + m2"))
    loads = found.tests["pull"].loads
    assert [load.mass.si for load in loads.values()] == pytest.approx([0.5, 1.5, 3.5])
    assert [load.mass.u for load in loads.values()] == pytest.approx([1e-3, 3e-3, 7e-3])
    assert [[one.cause for one in load.mass.components] for load in loads.values()] == 3 * [["set"]]


@pytest.mark.long
def test_closed_form_a_released_mass_shares_its_weights_with_the_dead_loads(tmp_path: Path):
    """With k = m·ω_n², u(k)/k of the mass is u(m)/m; the mass is that of load B, and shares the hook with load A."""
    t = np.arange(-100, 8000) / 1e3
    rng = np.random.default_rng(8)
    for at in (1, 2, 3):
        noise = np.convolve(rng.standard_normal(t.size + 2), [0.25, 0.5, 0.25], "valid")
        x = np.where(t < 0, 1000.0, 1000.0 * np.exp(-0.4 * t) * np.cos(80.0 * t)) + noise
        rows = (f"{a:.4f},{b:.1f}" for a, b in zip(t, x, strict=True))
        (tmp_path / f"swing-{at}.csv").write_text("time / s,displacement / um\n" + "\n".join(rows), encoding="utf-8")
    text = (
        TEST.replace("tests:", "  plate: {kind: vibrometer, resolution: 0.1 um}\ntests:", 1).replace(
            "samples:\n  line: {length: 1.000 m}\n", ""
        )
        + """\
  swing:
    method: decay
    sample: line
    instruments: {displacement: plate}
    mass: hook + m1
    readings: [swing-1.csv, swing-2.csv, swing-3.csv]
samples:
  line: {length: 1.000 m}
diagnosis: {off: true}
"""
    )
    found = chain.evaluate(campaign(tmp_path, stacked(text)))
    known = {frozenset((one.a, one.b)): one.coefficient for one in found.input_correlations}
    hook, together = U[0], sqrt(U[0] ** 2 + U[1] ** 2)
    assert known[frozenset(("swing.mass", "pull.load B"))] == pytest.approx(1.0)
    assert known[frozenset(("swing.mass", "pull.load A"))] == pytest.approx(hook / together)
    (k,) = [one for one in found.results if one.name == "swing.k"]
    rows = [row for row in k.budget if row.input == "swing.mass"]
    of_mass = sqrt(sum(row.contribution**2 for row in rows))
    assert of_mass / k.framework.value == pytest.approx(together / 1.5, rel=1e-6)


def test_twice_a_file_with_the_sums_written_out_says_the_same(tmp_path: Path):
    """As `extended.yaml` is written from what was read."""
    first = campaign(tmp_path, stacked())
    text = yaml.safe_dump(first._document.data, sort_keys=False)
    (tmp_path / "again.yaml").write_text(text, encoding="utf-8")
    again = load(tmp_path / "again.yaml")
    assert again.tests["pull"].loads == first.tests["pull"].loads
    assert chain.evaluate(again).results[0].framework == chain.evaluate(first).results[0].framework


@pytest.mark.parametrize(
    ("last", "message"),
    [
        ("hook + m1 + m3", "tests.pull.loads.C.mass: got 'm3'; expected a name under 'masses'"),
        ("hook + m1 + m1", "tests.pull.loads.C.mass: got 'm1' 2 times; expected every mass once"),
    ],
)
def test_refusal_of_a_sum(tmp_path: Path, last: str, message: str):
    with pytest.raises(MetrologyError) as caught:
        campaign(tmp_path, stacked(last=last))
    assert message in str(caught.value)
    assert len(caught.value.faults) == 1


def test_refusal_of_one_cause_that_is_stated_in_two_ways(tmp_path: Path):
    text = (
        "causes:\n  set: {source: certificate of the set}\nmasses:\n"
        "  hook: {value: 0.5 kg, uncertainty: [{cause: set, standard: 1 g}]}\n"
        "  m1: {value: 1 kg, uncertainty: [{cause: set, expanded: 2 g, k: 2}]}\n"
        "  m2: 2.0(1) kg\n"
    )
    with pytest.raises(MetrologyError, match="'set' stated in different ways"):
        campaign(tmp_path, text + TEST.replace("LAST", "hook + m1 + m2"))
