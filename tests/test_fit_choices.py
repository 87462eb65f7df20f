"""Fits of a campaign: what a failed χ² does to their uncertainties, and the covariance of ISO/TS 28037."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from fitted import evaluated
from scipy.optimize import least_squares

from metrology.errors import MetrologyError
from metrology.findings import Findings

X = np.arange(1.0, 9.0)
TOO_SMALL = np.array([0.3, -0.2, 0.1, -0.4, 0.35, -0.1, 0.2, -0.25])


def fitted(folder: Path, y: np.ndarray, further: str = "", u_y: float = 0.1) -> Findings:
    return evaluated(
        folder,
        f"""\
    x: {{values: {X.tolist()}, unit: mm}}
    y: {{values: {y.tolist()}, unit: um}}
    u_y: {{value: {u_y} um}}
{further}    predict: [{{name: at5, x: 5 mm}}]
""",
    )


def by_hand(y: np.ndarray, u_y: float) -> tuple[np.ndarray, float]:
    """Covariance of intercept and slope (SI) from stated uncertainties, and χ²/ν."""
    design = np.column_stack([np.ones(8), 1e-3 * X]) / (1e-6 * u_y)
    _, rest, *_ = np.linalg.lstsq(design, y / u_y, rcond=None)
    return np.linalg.inv(design.T @ design), float(rest[0]) / 6


@pytest.mark.parametrize(("further", "wider"), [("", True), ("    scatter: stated\n", False)])
def test_closed_form_u_of_a_refuted_fit_grows_by_the_root_of_chi_squared_unless_it_is_to_stay(further, wider, tmp_path):
    y = 2 * X + TOO_SMALL
    covariance, ratio = by_hand(y, 0.1)
    findings = fitted(tmp_path, y, further)
    (fit,) = findings.fits
    factor = sqrt(ratio) if wider else 1.0
    assert ratio > 5
    assert fit.u == pytest.approx(factor * np.sqrt(np.diag(covariance)), rel=1e-9)
    assert fit.dof == (6 if wider else None)
    at = np.array([1.0, 5e-3])
    predicted = next(one for one in findings.results if one.name == "cal.at5")
    assert predicted.framework.u == pytest.approx(factor * sqrt(at @ covariance @ at), rel=1e-9)
    assert ("multiplied by" in fit.sentence) == wider
    assert ("as the file asks" in fit.sentence) == (not wider)


def test_closed_form_a_fit_that_is_not_refuted_keeps_what_is_stated(tmp_path):
    y = 2 * X + 0.3 * TOO_SMALL
    covariance, ratio = by_hand(y, 0.1)
    assert ratio < 1.5
    (fit,) = fitted(tmp_path, y).fits
    assert fit.u == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-9)


@pytest.mark.long
def test_twice_the_covariance_of_iso_28037_is_that_of_all_unknowns_together(tmp_path):
    """Eight true abscissae beside intercept and slope, by nonlinear least squares in SciPy: its information matrix."""
    rng = np.random.default_rng(8)
    x, y = 1e-3 * X, 1e-6 * (2 * X + 0.6 * rng.standard_normal(8))
    u_x, u_y = 2e-4, 3e-7
    asked = "    u_x: {value: 0.2 mm}\n    covariance: iso28037\n"
    (fit,) = fitted(tmp_path, 1e6 * y, asked, u_y=0.3).fits
    (usual,) = fitted(tmp_path, 1e6 * y, "    u_x: {value: 0.2 mm}\n", u_y=0.3).fits

    def rest(unknown: np.ndarray) -> np.ndarray:
        a, b, *true = unknown
        return np.concatenate([(x - true) / u_x, (y - 1e-6 * a - 1e-3 * b * np.array(true)) / u_y])

    found = least_squares(rest, [0.0, 2.0, *x], xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale=[1, 1, *x])
    covariance = np.linalg.inv(found.jac.T @ found.jac)[:2, :2]
    assert fit.u == pytest.approx(np.sqrt(np.diag(covariance)) * [1e-6, 1e-3], rel=1e-4)
    assert usual.values == pytest.approx(fit.values, rel=1e-12)
    assert usual.u[1] != pytest.approx(fit.u[1], rel=1e-4)


def test_refusal_iso_28037_without_errors_in_x(tmp_path):
    with pytest.raises(MetrologyError, match="'covariance: iso28037' without 'u_x'"):
        fitted(tmp_path, 2 * X, "    covariance: iso28037\n")
