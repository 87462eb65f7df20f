"""What one indicator, and one set of weights, is off by is the same in every test that reads it at the same place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from metrology import chain
from metrology.campaign.load import load

ERROR = 1e-6 * np.array([10.0, 5.0, 0.0, -5.0, -10.0])
"""Of the indicator at its loads / m: at most one standard uncertainty of its certificate."""
CERTIFICATE = {"number": "C-1", "date": "2026-03-01", "due": "2027-03-01", "expanded_uncertainty": "20 um", "k": 2}


def campaign(folder: Path, stiffness: list[float], *, cause: str = "", heavy: str = "") -> dict:
    """Tests of one indicator, each of one line, in the order of the list."""
    rng = np.random.default_rng(4)
    loads = np.arange(1, 6) * 0.5
    tests = {}
    for number, k in enumerate(stiffness):
        rows = ["load,repeat,reading / mm"]
        for repeat in (1, 2, 3):
            x = loads * 9.81 / k + ERROR + 2e-7 * rng.standard_normal(5)
            rows += [f"L{at},{repeat},{1e3 * value:.5f}" for at, value in enumerate(x)]
        (folder / f"p{number}.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
        tests[f"p{number}"] = {
            "method": "elongation", "sample": "wire", "instruments": {"extension": "dial", "load": "weights"},
            "gravity": "9.81 m/s^2", "readings": f"p{number}.csv",
            "loads": {f"L{at}": {"mass": f"{one} kg"} for at, one in enumerate(loads)},
        }  # fmt: skip
    weights = {"number": "C-2", "date": "2026-03-01", "due": "2027-03-01", "expanded_uncertainty": heavy, "k": 2}
    found = {
        "format": "metrology-campaign/1", "id": "shared", "title": "One indicator",
        "instruments": {
            "dial": {"kind": "dial", "resolution": "0.01 um", "certificate": dict(CERTIFICATE)},
            "weights": {"kind": "weights"} | ({"certificate": weights} if heavy else {}),
        },
        "samples": {"wire": {}}, "tests": tests, "diagnosis": {"off": True},
        "derived": [{"quantity": "mean", "expression": "(" + " + ".join(f"k{at}" for at in range(len(tests))) +
                     f") / {len(tests)}", "where": {f"k{at}": f"{name}.k" for at, name in enumerate(tests)},
                     "unit": "N/m"}],
    }  # fmt: skip
    if cause:
        found["causes"] = {cause: {"description": "gauge blocks"}}
        found["instruments"]["dial"]["certificate"]["cause"] = cause
    return found


def results(folder: Path, made: dict) -> dict:
    import yaml

    path = folder / "campaign.yaml"
    path.write_text(yaml.safe_dump(made, sort_keys=False), encoding="utf-8")
    return {one.name: one for one in chain.evaluate(load(path), coverage=False).results}


@pytest.mark.parametrize("heavy", ["", "5 g"])
def test_law_the_mean_of_eight_tests_of_one_indicator_is_as_uncertain_as_one(heavy, tmp_path):
    """Its errors counted eight times: 4.3 u off, and passed."""
    found = results(tmp_path, campaign(tmp_path, [24000.0] * 8, heavy=heavy))
    assert found["mean"].u == pytest.approx(found["p0.k"].u, rel=0.02)
    assert abs(found["mean"].value - 24000.0) < 2 * found["mean"].u


def test_law_another_place_of_the_scale_is_another_error(tmp_path):
    found = results(tmp_path, campaign(tmp_path, [24000.0, 9000.0]))
    alone = np.hypot(found["p0.k"].u, found["p1.k"].u) / 2
    assert found["mean"].u == pytest.approx(alone, rel=0.05)


def test_law_a_cause_does_not_make_the_error_one_along_the_scale(tmp_path):
    """A certificate whose cause had a name was an error of the zero: u(k) fell from 93 to 11 N/m."""
    plain = results(tmp_path, campaign(tmp_path, [24000.0]))
    named = results(tmp_path, campaign(tmp_path, [24000.0], cause="blocks"))
    assert named["p0.k"].u == pytest.approx(plain["p0.k"].u, rel=1e-9)
