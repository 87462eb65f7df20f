"""Attained coverage from a campaign file to the report, and of an elongation test by its readings."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.cli import main
from metrology.elongation.again import Again
from metrology.elongation.line import Layout, average

REFERENCE = Path(__file__).parent / "reference"
POLAR = REFERENCE / "jcgm102-9-3-polar-r0-9-x0-001" / "campaign.yaml"


def _again(scatter: float, division: float) -> tuple[Again, np.ndarray]:
    layout = Layout.of([i for _ in range(4) for i in range(3)], [r for r in range(4) for _ in range(3)])
    generator = np.random.default_rng(7)
    exact = np.array([0.1e-3, 0.2e-3, 0.3e-3])[layout.loads] + 5e-6 * layout.repeats
    readings = exact + scatter * generator.standard_normal(12)
    means = average(readings, layout, np.array([1.0, 2.0, 3.0]))
    return Again(layout, means, division / np.sqrt(12)), means.cofactor


def test_means_of_readings_drawn_again_scatter_by_their_covariance() -> None:
    again, cofactor = _again(10e-6, 1e-9)
    errors, ratio, rest = again(np.random.default_rng(1), 20000)
    np.testing.assert_allclose(np.cov(errors), again.means.variance * cofactor, atol=0.03 * again.means.variance)
    assert ratio.mean() == pytest.approx(1.0, abs=0.03)
    assert ratio.var() == pytest.approx(2 / again.means.dof, rel=0.1)
    assert (rest == 1).all()


def test_readings_that_do_not_scatter_are_off_by_their_rounding() -> None:
    """Without scatter all readings at a load are rounded alike: the error of their mean is rectangular, d/√12."""
    again, _ = _again(0.1e-6, 10e-6)
    errors, _, _ = again(np.random.default_rng(1), 20000)
    assert np.abs(errors).max() < 5.2e-6
    np.testing.assert_allclose(errors.std(axis=1), 10e-6 / np.sqrt(12), rtol=0.02)


def test_planted_readings_that_are_not_repeated_are_drawn_about_their_line() -> None:
    """The scatter of each repetition is that about its line, too; it was none, and every such interval too narrow."""
    forces, generator = np.arange(8.0), np.random.default_rng(5)
    layout = Layout.of(range(8), [0] * 8)
    means = average(1e-3 * forces + 1e-4 * generator.standard_normal(8), layout, forces)
    errors, ratio, _ = Again(layout, means, 1e-9)(np.random.default_rng(1), 20000)
    assert ratio.mean() == pytest.approx(1.0, abs=0.03)
    assert ratio.var() == pytest.approx(2 / means.dof, rel=0.1)
    np.testing.assert_allclose(np.cov(errors), means.variance * means.cofactor, atol=0.03 * means.variance)


def test_results_hold_it_or_not_as_asked(tmp_path: Path) -> None:
    folder = REFERENCE / "gum-h3-thermometer"
    assert main(["run", str(folder), "--output", str(tmp_path / "with")]) == 0
    assert main(["run", str(folder), "--output", str(tmp_path / "without"), "--no-coverage"]) == 0
    made = [json.loads((tmp_path / way / folder.name / "results.json").read_text()) for way in ("with", "without")]
    held = {one["name"]: one["attained"] for one in made[0]["results"]}
    assert {*held} == {"thermometer.result.intercept", "thermometer.result.slope", "thermometer.b30"}
    assert all(one["repetitions"] == 2000 and 0.93 < one["share"] < 0.97 for one in held.values())
    assert all(one["attained"] is None for one in made[1]["results"])


def test_an_interval_that_is_too_narrow_is_told() -> None:
    campaign = load(POLAR)
    (told,) = [one for one in chain.evaluate(campaign).warnings if "too narrow" in one and one.startswith("mag")]
    assert "400 simulated repetitions" in told
    assert not [one for one in chain.evaluate(campaign, coverage=False).warnings if "too narrow" in one]


@pytest.mark.long
def test_annex_states_it(tmp_path: Path) -> None:
    folder = REFERENCE / "gum-h3-thermometer"
    assert main(["report", str(folder), "--output", str(tmp_path), "--part", "annex"]) == 0
    assert "attained coverage, the share" in (tmp_path / folder.name / "report.html").read_text()
