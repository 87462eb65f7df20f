"""A small response test with one held-out run, built by hand: no number here was measured."""

from __future__ import annotations

from dataclasses import replace
from math import cos, exp
from typing import Any

from metrology.findings import Findings, TestItem
from metrology.response import ChannelFit, FittedRun, InputAfter, PaperResult, ResponseFinding, Sought

TIME = tuple(0.05 * i for i in range(200))
MOTION = tuple(0.02 * exp(-0.2 * t) * cos(2.6 * t) for t in TIME)


def add(findings: Findings) -> Findings:
    """The findings with a response test and its verification."""
    test = TestItem(
        *("nylon-response", "response", "Response of a module on the line: Nylon line", "Laboratory method", "nylon"),
        *("2026-10-12", "J. Doe", (), ("load-cell",), (), ()),
        response=_finding(),
    )
    return replace(findings, tests=(*findings.tests, test), verification=(_verification(),))


def _finding() -> ResponseFinding:
    return ResponseFinding(
        status="ok",
        sentence="converged in 7 steps",
        model="module of 25 kg on a line that only pulls",
        sought=(
            Sought("k", "N/m", 170.01, 0.69, 168.6, 171.4, "profile", True, "", (("readings", 1.0),)),
            Sought("c", "N·s/m", 8.1, 0.03, None, 8.2, "one-sided", False, "The runs only bound c.", ()),
        ),
        inputs=(
            InputAfter("mass.factor", "", "1", 1.0, 0.001, 1.0098, 0.0009, "balance"),
            InputAfter("cell.zero", "low-step-1", "N", 0.0, 0.003, 0.0001, 0.0008, "readings before the runs"),
        ),
        given=(),
        correlated=("k", "c", "mass.factor"),
        correlation=((1.0, 0.98, -0.4), (0.98, 1.0, 0.1), (-0.4, 0.1, 1.0)),
        chi_squared=1.9,
        paper=PaperResult("ok", "converged", 167.61, 8.0, 0.77, None, (("x", 3.0e-4), ("T", 0.013)), 0.0036),
        runs=(FittedRun("low-step-1", (fitted_channel("x", "m"), fitted_channel("T", "N"))),),
        notes=(
            "the fitted and the stated mass.factor disagree by 8.8 u",
            "r: standard uncertainty of one reading: x 0.0002 m",
        ),
        failures=(),
    )


def fitted_channel(name: str, unit: str) -> ChannelFit:
    """A channel of a fitted run: 10 s, residuals of one noise up and down."""
    residual = tuple(1e-4 * (-1) ** i for i in range(len(TIME)))
    measured: tuple[float | None, ...] = (None, *(m + r for m, r in zip(MOTION[1:], residual[1:], strict=True)))
    return ChannelFit(name, unit, 1e-4, 1.1e-4, len(TIME) - 1, TIME, measured, MOTION, (None, *residual[1:]))


def _verification() -> dict[str, Any]:
    score = {
        "channel": "x", "name": "all", "start": 0.0, "stop": 10.0, "count": 200, "rms": 3.9e-4, "nrms": 0.0059,
        "r_squared": 0.9994, "peak_error": -1.4e-4, "magnitude": -5e-5, "phase": 8e-5, "combined": 1e-4, "share": 0.945,
        "u_val": 3.2e-4, "closed_rms": 1.07, "closed_excess": 19.4, "testable": True,
    }  # fmt: skip
    bare = {key: None if key not in {"channel", "name", "testable"} else value for key, value in score.items()}
    ringing = {
        "channel": "x", "start": 5.0, "stop": 10.0, "omega_measured": 2.589, "omega_measured_u": 0.006,
        "omega_simulated": 2.590, "rate_measured": 0.157, "rate_measured_u": 0.007, "rate_simulated": 0.160,
    }  # fmt: skip
    run = {
        "run": "low-step-2 </script><b>", "verdict": "not validated", "sentence": "not validated: T in the spike",
        "rule": "as stated", "share": 0.96, "in_band": None, "phases": [["slack", 0.0, 3.5], ["spike", 3.5, 10.0]],
        "scores": [score, bare | {"name": "spike"}], "ringing": [ringing], "own": [["thrust.gain", 0.0014, 0.32]],
        "u_num": [["x", 1e-15]], "series": [_series("x", "m"), _series("T", "N")], "notes": [],
    }  # fmt: skip
    return {
        "sample": "nylon", "test": "nylon-response", "model": "k = 170", "verdict": "not validated",
        "sentence": "not validated: 1 of 1 held-out runs", "rule": "No metric decides alone.", "runs": [run],
        "notes": ["No model predicts at the level of the noise."],
    }  # fmt: skip


def _series(channel: str, unit: str) -> dict[str, Any]:
    return {
        "channel": channel, "unit": unit, "time": list(TIME), "measured": [None, *MOTION[1:]],
        "simulated": list(MOTION), "low": [m - 1e-3 for m in MOTION], "high": [m + 1e-3 for m in MOTION],
        "error": [None, *(1e-4 for _ in TIME[1:])], "twice_u_val": [6e-4] * len(TIME), "closed": list(MOTION),
        "closed_residual": [0.0] * len(TIME),
    }  # fmt: skip
