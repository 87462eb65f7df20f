"""Response tests in a campaign file: what a good one becomes, and every way to get it wrong that was thought of."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from metrology.campaign.load import load
from metrology.chain.methods import add_test
from metrology.chain.plan import Plan
from metrology.errors import MetrologyError
from metrology.methods.response.preparation import measured_runs, prepared

CAMPAIGN = """\
format: metrology-campaign/1
id: line
title: Response of a line
samples:
  line: {section: {shape: round, diameter: 0.300(3) mm}, length: 1.500(1) m, linear_density: 0.08 g/m}
instruments:
  mocap: {kind: motion capture}
tests:
  pull:
    method: response
    sample: line
    instruments: {position: mocap}
    rig: {mass: 25.00 kg, taut: 1.500 m, line_weight: catenary}
    known:
      mass: {common: 25 g, source: balance}
      thrust_gain: {common: 1 %, per_run: 0.3 %}
    identification: {free: [k, c], start: {k: 150 N/m}}
    runs:
      one:
        readings: [motion.csv, cell.csv]
        thrust: [{from: 0.5 s, to: 2 s, force: 0.38 N}]
        held_until: 0.5 s
        start: {position: 1.480 m}
      two:
        purpose: verification
        readings: [other.csv]
        thrust: [{from: 0.5 s, force: 0.38 N}]
        start: {position: 1.480 m}
"""
PLACE = "campaign.yaml:8:3 tests.pull"


def push(x0: float = 1.48, noise: int = 7) -> str:
    """Readings of a module that is pushed, then drifts: kinematics alone, with a little noise of a fixed pattern."""
    rows = ["time / s,x / m,v / m/s"]
    for index in range(100):
        t = index * 0.05
        since = max(t - 0.5, 0.0)
        rows.append(f"{t:.2f},{x0 + 0.0076 * since**2 + 1e-4 * ((index * noise) % 5 - 2):.5f},{0.0152 * since:.4f}")
    return "\n".join(rows) + "\n"


CELL = (
    "\n".join(["time / s,T / N", *(f"{index * 0.04:.2f},{0.003 * ((index * 3) % 7):.3f}" for index in range(125))])
    + "\n"
)
FILES = {"motion.csv": push(), "cell.csv": CELL, "other.csv": push(noise=8)}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "campaign.yaml").write_text(CAMPAIGN, encoding="utf-8")
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def change(folder: Path, old: str, new: str, file: str = "campaign.yaml") -> None:
    path = folder / file
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def messages(folder: Path) -> list[str]:
    with pytest.raises(MetrologyError) as caught:
        load("campaign.yaml")
    return [str(fault) for fault in caught.value.faults]


def test_reference_runs_come_with_their_own_stamps_and_thrust(folder: Path) -> None:
    campaign = load("campaign.yaml")
    one, two = measured_runs(campaign, "pull", campaign.tests["pull"])
    assert one.channels == ("x", "v", "T")
    assert two.channels == ("x", "v")
    assert one.stamps("T")[1] == pytest.approx(0.04)
    assert one.stamps("x")[1] == pytest.approx(0.05)
    assert one.run.force.t.tolist() == [0.5, 2.0]
    assert one.run.force.values.tolist() == [0.38, 0.0]
    assert two.run.force.values.tolist() == [0.38]
    assert (one.purpose, two.purpose) == ("identification", "verification")
    assert [file.path for file in campaign.files] == ["campaign.yaml", "motion.csv", "cell.csv", "other.csv"]


def test_reference_what_is_known_becomes_priors_of_the_rig(folder: Path) -> None:
    campaign = load("campaign.yaml")
    ready = prepared(Plan(), campaign, "pull", campaign.tests["pull"])
    mass, thrust = (one for one in ready.priors if one.name not in ("length", "weight"))
    assert (mass.name, mass.common, mass.per_run) == ("mass.factor", pytest.approx(0.001), 0.0)
    assert (thrust.name, thrust.common, thrust.per_run) == ("thrust.gain", pytest.approx(0.01), pytest.approx(0.003))
    assert ready.rig.weight == pytest.approx(8e-5 * 9.8)
    assert ready.rig.cap == 0.005
    assert ready.rig.c == pytest.approx(0.2 * np.sqrt(150 * 25))


def test_reference_excluded_lines_and_gaps_carry_no_weight(folder: Path) -> None:
    change(folder, "    known:\n", "    exclusions: [{file: cell.csv, line: 5, reason: knocked}]\n    known:\n")
    rows = FILES["motion.csv"].split("\n")
    rows[3] = rows[3].split(",")[0] + ",,"
    (folder / "motion.csv").write_text("\n".join(rows))
    campaign = load("campaign.yaml")
    one, _ = measured_runs(campaign, "pull", campaign.tests["pull"])
    assert np.flatnonzero(~one.used("T")).tolist() == [3]
    assert np.flatnonzero(~one.used("x")).tolist() == [2]


@pytest.mark.long
def test_law_a_campaign_without_response_tests_needs_no_rig() -> None:
    code = (
        "import sys; from metrology import chain; from metrology.campaign.load import load; import metrology.findings\n"
        "import pathlib; path = pathlib.Path('tests/reference/gum-h2-resistance-reactance/campaign.yaml')\n"
        "findings = chain.evaluate(load(path)); metrology.findings.to_json(findings)\n"
        "print([name for name in sys.modules if name.startswith(('numba', 'metrology.rig', 'metrology.estimation'))])"
    )
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


CASES = {
    "unknown parameter": ("free: [k, c]", "free: [k, c, frction.force]", ["parameter of the equation of motion"]),
    "no start": (", start: {k: 150 N/m}", "", ["no start value of k"]),
    "neither free nor given": ("free: [k, c]", "free: [k]", ["no 'damping'"]),
    "free and given": (
        "    identification",
        "    damping: {value: 8.0(2) N*s/m, source: elsewhere}\n    identification",
        ["'damping', and c free in 'identification'"],
    ),
    "no stiffness": (
        "free: [k, c]",
        "free: [c]",
        ["no 'stiffness'"],
    ),
    "unknown elongation test": (
        "    identification: {free: [k, c], start: {k: 150 N/m}}",
        "    stiffness: pull-elongation\n    identification: {free: [c]}",
        ["got 'pull-elongation'; expected an elongation test of 'line', or a quantity with its source"],
    ),
    "thrust longer than the record": (
        "to: 2 s",
        "to: 60 s",
        ["got '60 s', after the record ends at 4.96 s; expected a thrust profile no longer than the record"],
    ),
    "thrust that overlaps": (
        "[{from: 0.5 s, to: 2 s, force: 0.38 N}]",
        "[{from: 0.5 s, to: 2 s, force: 0.38 N}, {from: 1 s, force: 0.62 N}]",
        ["got '1 s', before the stretch before it ends at '2 s'"],
    ),
    "held and moving": (
        "start: {position: 1.480 m}\n      two",
        "start: {position: 1.480 m, velocity: 0.1 m/s}\n      two",
        ["got '0.1 m/s' for a module that is held until '0.5 s'; expected 0 m/s, or no 'held_until'"],
    ),
    "held beyond the record": (
        "held_until: 0.5 s",
        "held_until: 50 s",
        ["got '50 s'; expected a time within the record"],
    ),
    "one file for two runs": (
        "readings: [other.csv]",
        "readings: [motion.csv]",
        ["got 'motion.csv', which run 'one' has; expected readings of its own for every run"],
    ),
    "a torque": (
        "force: 0.38 N}]\n        held",
        "force: 0.38 N*m}]\n        held",
        ["got '0.38 N*m', an energy or a moment of force; expected a force"],
    ),
    "no run for the fit": (
        "    runs:\n      one:\n",
        "    runs:\n      one:\n        purpose: verification\n",
        ["no run for identification"],
    ),
    "no weight of the line": (
        ", linear_density: 0.08 g/m",
        "",
        ["'catenary' without 'linear_density' of sample 'line'"],
    ),
    "no uncertainty": (
        "mass: {common: 25 g, source: balance}",
        "mass: {source: balance}",
        ["neither 'common' nor 'per_run'"],
    ),
    "wrong dimension of an effect": (
        "    known:\n",
        "    model: {friction.force: 1 mm}\n    known:\n",
        ["tests.pull.model.friction.force: got '1 mm', a length; expected a force"],
    ),
    "an effect of nobody": (
        "    known:\n",
        "    model: {frction.force: 1 mN}\n    known:\n",
        ["'frction.force', an unknown parameter; expected a parameter of the equation of motion. Fix: did you mean"],
    ),
    "an effect that every model has": (
        "    known:\n",
        "    model: {taut: 1.5 m}\n    known:\n",
        ["'taut', which every model has; expected a parameter of an effect"],
    ),
    "an effect beyond its range": (
        "    known:\n",
        "    model: {friction.force: -1 mN}\n    known:\n",
        ["got '-1 mN'; expected a value from 0 up, in N"],
    ),
    "an effect sought and carried": (
        "free: [k, c], start: {k: 150 N/m}}",
        "free: [k, c, friction.force], start: {k: 150 N/m}}\n    model: {friction.force: 1 mN}",
        ["'friction.force', and friction.force free in 'identification'; expected one of the two"],
    ),
    "wrong dimension of an uncertainty": ("common: 25 g", "common: 25 mm", ["'25 mm', a length; expected a mass"]),
}


@pytest.mark.parametrize("case", CASES)
def test_refusal_of_the_campaign_file(case: str, folder: Path) -> None:
    old, new, parts = CASES[case]
    change(folder, old, new)
    found = messages(folder)
    assert len(found) == 1, found
    for part in parts:
        assert part in found[0]
    assert found[0].startswith("campaign.yaml:")


READINGS = {
    "repeated time stamp": (
        "0.10,",
        "0.05,",
        [
            "motion.csv:4 time / s: got the time stamp 0.05 a second time; expected time stamps that increase. "
            "Fix: 'rows: [first, last]' in the campaign file says which lines are used"
        ],
    ),
    "time runs back": (
        "0.10,",
        "0.01,",
        [
            "motion.csv:4 time / s: got 0.01 after 0.05; expected time stamps that increase. "
            "Fix: 'rows: [first, last]' in the campaign file says which lines are used"
        ],
    ),
    "NaN": ("0.10,1", "0.10,NaN", ["motion.csv:4 x / m: got 'NaN"]),
    "an angle": ("x / m", "x / rad", ["motion.csv:1: got 'x / rad', an angle; expected a length, such as 'x / m'"]),
    "no channel": (
        "x / m,v / m/s",
        "y / m,w / m/s",
        ["motion.csv:1: got 'y / m', an unknown column", "motion.csv:1: got 'w / m/s', an unknown column"],
    ),
}


@pytest.mark.parametrize("case", READINGS)
def test_refusal_of_the_readings(case: str, folder: Path) -> None:
    old, new, parts = READINGS[case]
    change(folder, old, new, "motion.csv")
    found = messages(folder)
    assert len(found) == len(parts)
    for message, part in zip(found, parts, strict=True):
        assert message.startswith(part)


def test_refusal_a_channel_that_is_all_gaps(folder: Path) -> None:
    rows = FILES["motion.csv"].split("\n")
    rows[1:-1] = [f"{row.split(',')[0]},,{row.split(',')[2]}" for row in rows[1:-1]]
    (folder / "motion.csv").write_text("\n".join(rows))
    assert messages(folder) == ["motion.csv:2 x / m: got gaps alone; expected at least one reading"]


def test_refusal_a_channel_in_two_files(folder: Path) -> None:
    (folder / "cell.csv").write_text(push(noise=9))
    assert messages(folder) == [
        "cell.csv:1: got 'x', which motion.csv has as well; expected every channel of a run in one file",
        "cell.csv:1: got 'v', which motion.csv has as well; expected every channel of a run in one file",
    ]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("force: 0.38 N}]\n        held", "force: -0.38 N}]\n        held", "a position that moves against the thrust"),
        (
            "start: {position: 1.480 m}\n      two",
            "start: {position: 1.280 m}\n      two",
            "where the first readings say",
        ),
    ],
)
def test_refusal_runs_that_cannot_be_what_they_claim(folder: Path, old: str, new: str, told: str) -> None:
    change(folder, old, new)
    campaign = load("campaign.yaml")
    with pytest.raises(MetrologyError) as caught:
        add_test(Plan(), campaign, "pull", lambda _text: None)
    (fault,) = caught.value.faults
    assert fault.where.startswith("campaign.yaml:19:7 tests.pull.runs.one")
    assert told in fault.got


def test_refusal_a_run_that_is_a_copy_of_another(folder):
    """A held-out run with the readings of a fitted one would verify whatever was fitted."""
    (folder / "other.csv").write_text(FILES["motion.csv"], encoding="utf-8")
    with pytest.raises(MetrologyError, match=r"other\.csv: got the content of 'motion\.csv' a second time"):
        load(folder / "campaign.yaml")
