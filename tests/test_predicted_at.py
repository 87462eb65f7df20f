"""A prediction at an x with an uncertainty: it acts by the slope, and no note says otherwise."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import numpy as np
import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.findings import Findings

SLOPE = 2.0


def evaluated(folder: Path, x: str) -> Findings:
    noise = 0.002 * np.random.default_rng(3).standard_normal(12)
    at = np.arange(12.0)
    path = folder / "campaign.yaml"
    path.write_text(
        f"""
format: metrology-campaign/1
id: at
title: A prediction
fits:
  cal:
    x: {{values: {at.tolist()}, unit: mm}}
    y: {{values: {np.round(1 + SLOPE * at + noise, 6).tolist()}, unit: N}}
    model: line
    predict: [{{name: p, x: {x}}}]
""",
        encoding="utf-8",
    )
    return chain.evaluate(load(path), coverage=False)


@pytest.mark.parametrize(("x", "u"), [("5.0 mm", 0.0), ("5.0(1) mm", 0.1), ("5.0(5) mm", 0.5)])
def test_closed_form_the_uncertainty_of_x_acts_by_the_slope(x, u, tmp_path):
    found = evaluated(tmp_path, x)
    exact = evaluated(tmp_path, "5.0 mm")
    (own,), (least,) = ([one for one in each.results if one.name == "cal.p"] for each in (found, exact))
    assert own.framework.u == pytest.approx(hypot(least.framework.u, SLOPE * u), rel=1e-3)
    assert not any("value alone" in one for one in found.warnings)
