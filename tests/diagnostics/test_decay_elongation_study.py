"""The whole matrix of planted effects in free decays and elongation tests: `make study`."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

STUDY = Path(__file__).parents[2] / "studies" / "diagnosis_plain.py"


@pytest.mark.study
@pytest.mark.parametrize("method", ["elongation", "decay"])
def test_planted_effects_are_named_at_the_rates_of_the_bars(method):
    study = runpy.run_path(str(STUDY))
    rows = [study["case"](task) for task in study["tasks"](method, 4, 40)]
    nothing = [row["verdict"] == "nothing missing" for row in rows if row["kind"] == "nothing"]
    large = [study["first"](row) for row in rows if row["kind"] == "one" and row["d"] >= 6]
    small = [not row["possible"] or study["first"](row) for row in rows if row["d"] == 5.0]
    assert sum(nothing) >= 0.95 * len(nothing)
    assert sum(large) >= 0.95 * len(large)
    assert sum(small) >= 0.95 * len(small)
