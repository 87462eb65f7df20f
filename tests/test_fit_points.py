"""Points of a fit that are no measure of their uncertainty, and results that take a fit beyond its data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_independence import HEAD, REQUIRED

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError

TEN = np.linspace(0.0, 10.0, 11)
MANY = np.tile(TEN, 20)


def noise(seed: int, count: int, size: float = 0.01) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, size, count)


def of_fit(folder: Path, x, y, *, quantity: str = "c.slope", more: str = "", upper: str = "99 V/mm", after: str = ""):
    rows = "x / mm,y / V\n" + "".join(f"{a:.5f},{b:.5f}\n" for a, b in zip(x, y, strict=True))
    (folder / "f.csv").write_text(rows)
    text = f'fits: {{c: {{readings: f.csv, x: "x / mm", y: "y / V"{more}}}}}\n{after}'
    (folder / "campaign.yaml").write_text(HEAD + text + REQUIRED.format(name=quantity, upper=upper))
    return chain.evaluate(load(folder / "campaign.yaml"), coverage=False)


def judged(found, why: str) -> None:
    """A verdict where there is nothing to say, and none where there is."""
    assert [one.verdict for one in found.conformity] == ([] if why else ["pass"])
    assert not why or why in " ".join(found.withheld[0].reasons)


def days() -> tuple[np.ndarray, np.ndarray]:
    """Five days of forty points at any x, each day with an offset of its own."""
    x = np.random.default_rng(1).uniform(0.0, 10.0, 200)
    return x, 2 * x + noise(2, 200) + np.repeat(noise(3, 5, 0.05), 40)


@pytest.mark.long
@pytest.mark.parametrize(
    ("x", "y", "more", "why"),
    [
        pytest.param(TEN, 2 * TEN + noise(4, 11), "", "", id="line"),
        pytest.param(TEN + noise(5, 11, 1e-4), np.arange(11.0), "",
                     "y is in steps of 1.00 V", id="whole volts"),
        pytest.param([*TEN[:6] / 5, 100.0], [*(TEN[:6] / 2.5 + noise(6, 6)), 300.0], "", "rests on one point alone",
                     id="one point far out"),
        pytest.param([*TEN[:6] / 5, 100.0], [*(TEN[:6] / 2.5 + noise(6, 6)), 200.0], ", u_y: {value: 0.01 V}", "",
                     id="one point far out, whose uncertainty is stated"),
        pytest.param(*days(), "", "or are not independent", id="days"),
        pytest.param(MANY, 2 * MANY + 0.02 * (MANY - 5) ** 2 + noise(7, 220), ", u_y: {value: 1 V}",
                     "do not follow the model", id="a bow within what is stated"),
        pytest.param(MANY, 2 * MANY + noise(7, 220), ", u_y: {value: 1 V}", "", id="too large a stated uncertainty"),
        pytest.param(np.repeat([0.0, 10.0], 30), np.minimum(np.repeat([0.0, 20.0], 30) + noise(8, 60), 20.0), "",
                     "points at one x are the same", id="the upper of two levels clipped"),
    ],
)  # fmt: skip
def test_planted_points_that_are_no_measure_of_their_uncertainty(x, y, more: str, why: str, tmp_path: Path) -> None:
    judged(of_fit(tmp_path, x, y, more=more), why)


FAR = 90.0 + TEN
AHEAD = """\
samples: {{one: {{length: {at}}}}}
derived: [{{quantity: q, expression: a + b*x, where: {{a: c.intercept, b: c.slope, x: one.length}}, unit: V}}]
"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("origin", "at", "why"),
    [
        ("", "intercept", "takes the line c at x = 0 m"),
        (", origin: 95 mm", "intercept", ""),
        ("", "105 mm", ""),
        ("", "200 mm", "takes the line c at x = 200.0 mm"),
        (", origin: 95 mm", "slope", ""),
    ],
)
def test_limit_a_line_beyond_its_data_whatever_the_equation(origin: str, at: str, why: str, tmp_path: Path) -> None:
    """From 90 mm to 100 mm: as far again at most; the slope by itself is taken nowhere."""
    quantity, after = ("q", AHEAD.format(at=at)) if at.endswith("mm") else (f"c.{at}", "")
    upper = "99 V/mm" if at == "slope" else "999 V"
    judged(of_fit(tmp_path, FAR, 2 * FAR + noise(9, 11), more=origin, quantity=quantity, upper=upper, after=after), why)


@pytest.mark.long
def test_law_what_new_readings_find_has_the_unit_of_x(tmp_path: Path) -> None:
    more = ", predict: [{name: p, readings: [10.01, 10.02, 9.99, 10.005], unit: V}]"
    y = 2 * TEN + noise(10, 11)
    found = of_fit(tmp_path, TEN, y, more=more, quantity="c.p", upper="6 mm")
    judged(found, "")
    (result,) = [one for one in found.results if one.name == "c.p"]
    assert result.value == pytest.approx(5.003e-3, abs=5e-5)
    with pytest.raises(MetrologyError, match="expected a length"):
        of_fit(tmp_path, TEN, y, more=more, quantity="c.p", upper="6 V")


@pytest.mark.long
@pytest.mark.parametrize(
    ("readings", "why"),
    [
        ([10.01, 10.02] * 20, "rounding does not average out"),
        ([10.0] * 6, "all 6 readings are alike"),
        ((10 + 0.01 * np.arange(20) + noise(11, 20)).round(4).tolist(), "neighbouring readings are alike"),
    ],
)
def test_planted_new_readings_that_are_not_independent(readings: list[float], why: str, tmp_path: Path) -> None:
    more = f", predict: [{{name: p, readings: {readings}, unit: V}}]"
    found = of_fit(tmp_path, TEN, 2 * TEN + noise(10, 11), more=more, quantity="c.p", upper="9 mm")
    assert not found.conformity
    assert why in " ".join(found.withheld[0].reasons)
