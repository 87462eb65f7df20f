"""The x of a new y: on lines and curves, from stated values and from new readings; where it has no bounded interval."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import fitted
import numpy as np
import pytest
from scipy.optimize import brentq, curve_fit
from scipy.stats import t as student

from metrology.errors import MetrologyError
from metrology.findings import Findings, Result

X = np.arange(1.0, 9.0)
SCATTER = np.array([0.3, -0.2, 0.1, -0.4, 0.35, -0.1, 0.2, -0.25])
SQUARE = "    model: {expression: 'b0 + b1*x + b2*x**2', start: {b0: 0.1, b1: 1, b2: 0.1}}\n"


def evaluated(folder: Path, y: np.ndarray, predict: str, further: str = "") -> Findings:
    return fitted.evaluated(
        folder,
        f"""\
    x: {X.tolist()}
    y: {np.round(y, 6).tolist()}
{further}    predict: [{{name: x0, {predict}}}]
""",
    )


def result(findings: Findings) -> Result:
    return next(one for one in findings.results if one.name == "cal.x0")


@pytest.mark.long
def test_twice_the_x_of_a_y_on_a_parabola_by_scipy(tmp_path: Path) -> None:
    y = np.round(1 + 0.5 * X + 0.2 * X**2 + 0.3 * SCATTER, 6)
    found = result(evaluated(tmp_path, y, "y: 8.0(1)", SQUARE))

    def f(x: float, *b: float) -> float:
        return b[0] + b[1] * x + b[2] * x**2

    best, covariance = curve_fit(f, X, y, [1.0, 0.5, 0.2])
    x0 = brentq(lambda x: f(x, *best) - 8.0, 1, 8)
    gradient, slope = np.array([1, x0, x0**2]), best[1] + 2 * best[2] * x0
    assert found.framework.value == pytest.approx(x0, rel=1e-8)
    assert found.framework.u == pytest.approx(sqrt(0.01 + gradient @ covariance @ gradient) / slope, rel=1e-6)
    rng = np.random.default_rng(4)
    scale = np.sqrt(rng.chisquare(5, 4000) / 5)
    drawn = best + rng.multivariate_normal(np.zeros(3), covariance, 4000) / scale[:, None]
    new = 8 + 0.1 * rng.standard_normal(4000)
    roots = (-drawn[:, 1] + np.sqrt(drawn[:, 1] ** 2 - 4 * drawn[:, 2] * (drawn[:, 0] - new))) / (2 * drawn[:, 2])
    assert np.quantile(roots, 0.025) == pytest.approx(found.monte_carlo.low, abs=0.1 * found.u)
    assert np.quantile(roots, 0.975) == pytest.approx(found.monte_carlo.high, abs=0.1 * found.u)


@pytest.mark.parametrize("y", ["-5.0(1)", "40.0(1)"])
def test_refusal_a_y_that_the_curve_does_not_take_within_its_data(tmp_path: Path, y: str) -> None:
    data = 1 + 0.5 * X + 0.2 * X**2 + 0.3 * SCATTER
    with pytest.raises(MetrologyError, match=r"cal\.x0\.at: .*the curve does not take"):
        evaluated(tmp_path, data, f"y: {y}", SQUARE)


def test_refusal_a_y_that_the_curve_takes_twice(tmp_path: Path) -> None:
    with pytest.raises(MetrologyError, match="more than once"):
        evaluated(tmp_path, (X - 4.5) ** 2 + 0.1 * SCATTER, "y: 4.0(1)", SQUARE)


def test_closed_form_new_readings_bring_their_own_scatter(tmp_path: Path) -> None:
    readings = [10.2, 10.9, 10.3, 10.6]
    y = 1 + 2 * X + SCATTER
    found = result(evaluated(tmp_path, y, f"readings: {readings}"))
    (slope, intercept), covariance = np.polyfit(X, y, 1, cov=True)
    x0 = (10.5 - intercept) / slope
    at = np.array([x0, 1.0])
    of_line, of_mean = float(at @ covariance @ at), np.var(readings, ddof=1) / 4
    assert found.framework.value == pytest.approx(x0, rel=1e-9)
    assert found.framework.u == pytest.approx(sqrt(of_line + of_mean) / slope, rel=1e-9)
    assert found.dof == pytest.approx((of_line + of_mean) ** 2 / (of_line**2 / 6 + of_mean**2 / 3), rel=1e-6)


@pytest.mark.parametrize(("unit", "readings"), [("mK", [10.2e3, 10.9e3, 10.3e3]), ("degC", [10.2, 10.9, 10.3])])
def test_closed_form_new_readings_are_in_their_unit(unit: str, readings: list[float]) -> None:
    import metrology

    zero = 0.0 if unit == "mK" else 273.15
    point = {"name": "x0", "readings": readings, "unit": unit}
    line = {"x": {"values": X.tolist(), "unit": "mm"}, "predict": [point]}
    line["y"] = {"values": np.round(1 + 2 * X + SCATTER + zero, 6).tolist(), "unit": "K"}
    stated = {"format": "metrology-campaign/1", "id": "new", "title": "New readings", "fits": {"cal": line}}
    found = metrology.run(stated, coverage=False)["cal.x0"]
    slope, intercept = np.polyfit(X, np.round(1 + 2 * X + SCATTER, 6), 1)
    assert found.result.framework.value == pytest.approx(1e-3 * (31.4 / 3 - intercept) / slope, rel=1e-9)


def test_limit_a_slope_that_is_not_significant_has_a_notice(tmp_path: Path) -> None:
    findings = evaluated(tmp_path, 1 + 0.02 * X + SCATTER, "y: 1.2(1)")
    assert any("cal.x0: the slope of the line is not significant" in one for one in findings.warnings)
    findings = evaluated(tmp_path, 1 + 2 * X + SCATTER, "y: 10(1)")
    assert not any("cal.x0" in one for one in findings.warnings)


WIDE = """\
requirements:
  - {id: R1, quantity: cal.x0, limits: {lower: -500}, decision: {rule: simple acceptance}}
  - {id: R2, quantity: twice, limits: {lower: -1000}, decision: {rule: simple acceptance}}
derived: [{quantity: twice, expression: 2 * x0, where: {x0: cal.x0}}]
"""


@pytest.mark.long
@pytest.mark.parametrize(("slope", "y"), [(0.02, "1.09(10)"), (0.02, "3.0(1)"), (2.0, "10.0(1)")])
def test_withheld_where_the_slope_is_not_significant_nothing_passes(tmp_path: Path, slope: float, y: str) -> None:
    predict = f"{y}}}]\n{WIDE}#"
    findings = evaluated(tmp_path, 1 + slope * X + SCATTER, f"y: {predict}")
    reasons = {one.requirement: " ".join(one.reasons) for one in findings.withheld}
    if slope == 2.0:
        assert not reasons
        return
    assert reasons.keys() == {"R1", "R2"}
    assert not findings.conformity
    assert all("cal.x0: the slope of the line is not significant" in reason for reason in reasons.values())
    assert all(("extrapolation" in reason) == (y == "3.0(1)") for reason in reasons.values())


def test_limit_an_x_by_a_slope_that_is_not_significant_is_judged_where_that_is_accepted(tmp_path: Path) -> None:
    predict = f"y: 1.2(1)}}]\n    accepted: {{reason: a trial, by: A. Smith}}\n{WIDE}#"
    findings = evaluated(tmp_path, 1 + 0.02 * X + SCATTER, predict)
    assert not findings.withheld
    assert len(findings.conformity) == 2


def test_closed_form_an_interval_that_is_not_symmetric_is_given_by_fieller(tmp_path: Path) -> None:
    # Fieller's ends are where the gap between line and y is t times its own standard uncertainty.
    y = np.round(1 + 0.25 * X + SCATTER, 6)
    findings = evaluated(tmp_path, y, "y: 4.0")
    (sentence,) = (one for one in findings.warnings if "Fieller" in one)
    (slope, intercept), covariance = np.polyfit(X, y, 1, cov=True)
    quantile = student.ppf(0.975, 6)

    def gap(x: float) -> float:
        at = np.array([x, 1.0])
        return abs(intercept + slope * x - 4.0) - quantile * sqrt(at @ covariance @ at)

    x0 = (4.0 - intercept) / slope
    low, high = brentq(gap, -20, x0), brentq(gap, x0, 1000)
    assert high - x0 > 1.5 * (x0 - low)
    printed = [float(word) for word in sentence.rstrip(".").split("Fieller: ")[1].split(" to ")]
    assert printed == pytest.approx([low, high], rel=5e-3)


@pytest.mark.parametrize(
    ("predict", "message"),
    [
        ("x: 2, y: 3.0(1)", "x and y"),
        ("readings: [1.0]", "1 reading"),
        ("readings: [1.0, 1.1], unit: mm", "as y"),
    ],
)
def test_refusal_of_places_that_are_none(tmp_path: Path, predict: str, message: str) -> None:
    with pytest.raises(MetrologyError, match=message):
        evaluated(tmp_path, 1 + 2 * X + SCATTER, predict)
