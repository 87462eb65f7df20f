"""Unit step of the module on its line: against an integrator and draws, and where the report shows it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import response_sample
from scipy.integrate import solve_ivp

from metrology.findings import Findings
from metrology.report import figures
from metrology.response import GivenValue
from metrology.response.step import response, unit_step


@pytest.mark.parametrize("c", [0.0, 8.0, 2 * np.sqrt(168.0 * 25.0), 400.0])
def test_twice_a_unit_step_against_an_integrator(c: float) -> None:
    k, m, t = 168.0, 25.0, np.linspace(0.0, 12.0, 50)
    moved = solve_ivp(
        lambda _, y: [y[1], (1 - k * y[0] - c * y[1]) / m], (0, 12), [0, 0], "DOP853", t, rtol=1e-11, atol=1e-14
    )
    x, v, tension = unit_step(k, c, m, t)
    assert x == pytest.approx(moved.y[0], abs=1e-9)
    assert v == pytest.approx(moved.y[1], abs=1e-9)
    assert tension == pytest.approx(k * x + c * v, abs=1e-12)
    assert tension.min() > -1e-12


def test_twice_the_band_of_a_unit_step_against_draws() -> None:
    k, c, m = 168.0, 8.0, 25.0
    covariance = np.array([[0.3**2, 0.8 * 0.3 * 0.05], [0.8 * 0.3 * 0.05, 0.05**2]])
    found = response(k, c, m, covariance)
    draws = np.random.default_rng(1).multivariate_normal([k, c], covariance, 2000)
    rows = np.array([unit_step(*pair, m, found.time) for pair in draws])
    for name, deviation in zip("xvT", rows.std(axis=0), strict=True):
        assert found.u[name] == pytest.approx(deviation, abs=0.06 * deviation.max())


def test_law_a_response_test_has_its_unit_step_where_k_and_c_are_known(findings: Findings) -> None:
    findings = response_sample.add(findings)
    *others, test = findings.tests
    assert test.response is not None
    given = (GivenValue("k", "N/m", 168.0, 0.3, "elongation"), GivenValue("c", "N·s/m", 8.0, 0.05, "decay"))
    known = replace(findings, tests=(*others, replace(test, response=replace(test.response, given=given, mass=25.0))))
    assert "step/nylon-response" not in figures.jobs(findings)
    plot = figures.jobs(known)["step/nylon-response"]()
    assert "1 N" in plot.caption
    assert re.search(r"position 0\.0059\d+ m, velocity .* tension (0\.9|1\.0)", plot.alt)
