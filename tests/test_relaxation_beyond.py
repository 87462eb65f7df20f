"""What a record of a held elongation does not read: what relaxes during the ramp, and a specimen unlike the others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_relaxation import CROSSHEAD, SHORT, written
from truth_relaxation import Held, record

from metrology import chain
from metrology.campaign.load import load

MACHINE = 'machine: {kind: encoder, class: "1"'


def evaluated(folder: Path, lines: list[Held], limit: str):
    """Findings with one requirement, and whether each check passed; the machine shows the divisions of the lines."""
    records = {f"s{at}": record(line, np.random.default_rng(at)) for at, line in enumerate(lines)}
    more = f"requirements:\n  - {{id: R, quantity: {limit}, decision: {{rule: simple acceptance}}}}\n"
    path = written(folder, CROSSHEAD, records, more)
    text = path.read_text(encoding="utf-8")
    assert MACHINE in text
    division = f"{1e3 * (lines[0].input_division or 1e-7):g} mm"
    path.write_text(text.replace(MACHINE, f"{MACHINE}, resolution: {division}"), encoding="utf-8")
    found = chain.evaluate(load(path), coverage=False)
    return found, {one.name: one.passed for one in found.tests[0].finding.checks}


@pytest.mark.parametrize("stiff", [(2.0e4, 2.02e4, 6.0e4), (2.0e4, 2.02e4, 1.97e4)])
def test_planted_a_specimen_unlike_the_others_bars_the_verdict(stiff, tmp_path):
    """The mean of 16, 16 and 48 kN/m passed a limit of 25 that two of three specimens miss."""
    lines = [replace(SHORT, stiff=one) for one in stiff]
    found, checks = evaluated(tmp_path, lines, "hold.k_inf, limits: {lower: 25 kN/m}")
    alike = max(stiff) < 3e4
    assert checks["outlying specimen"] is alike
    assert (not found.conformity) is not alike
    if alike:
        assert "fail" in found.conformity[0].verdict


@pytest.mark.parametrize("fastest", [0.1, 2.0])
def test_planted_a_branch_faster_than_the_ramp_bars_the_stiffness_at_once(fastest, tmp_path):
    line = replace(SHORT, parts=(0.3, 0.1), times=(fastest, 20.0))
    found, checks = evaluated(tmp_path, [line], "hold.k_0, limits: {lower: 10 kN/m}")
    assert checks["instantaneous stiffness"] is (fastest > SHORT.ramp)
    assert bool(found.conformity) is (fastest > SHORT.ramp)


@pytest.mark.parametrize(
    "line",
    [
        pytest.param(replace(SHORT, holds=(300.0,), times=(10.0, 60.0), rate=0.5, ramp=0.2), id="instant of the step"),
        pytest.param(replace(SHORT, levels=(1.04e-3,), input_division=1e-4, read_noise=0.005), id="rounding"),
    ],
)
def test_law_what_no_reading_says_of_the_step_is_common_to_the_specimens(line, tmp_path):
    """Ten specimens on one clock were 5 u off, and passed: each has its step at the same instant."""
    found = []
    for count in (1, 4):
        folder = tmp_path / str(count)
        folder.mkdir()
        results = evaluated(folder, [line] * count, "hold.k_0, limits: {lower: 10 kN/m}")[0].results
        found.append({one.quantity: one for one in results}["k_0"])
    alone, mean = found
    assert mean.u > 0.9 * alone.u
    assert abs(mean.value - line.stiff) < 3 * mean.u
