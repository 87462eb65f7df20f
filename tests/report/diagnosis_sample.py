"""Diagnoses with every verdict, written down by hand."""

from __future__ import annotations

from dataclasses import replace
from math import nan

from metrology.diagnosis import (
    Cause,
    Curve,
    Detectable,
    Diagnosis,
    Gain,
    Missing,
    Part,
    Picture,
    Separation,
    Shift,
    Test,
    Value,
)

HOSTILE = '</script><b onload=x>"{{ 7*7 }}'
GAIN = {"x": Gain(3.21, 1.004, 3.197, 3.05, 3.36), "T": Gain(1.5, 1.01, 1.485, 1.4, 1.6)}


def cause(effect: str, verdict: str, probability: float, log_bayes: float | None, *, title: str = "") -> Cause:
    size = (Value(f"{effect}.size", 3.79e-4, 2.5e-5, "N", 3.3e-4, None),) if log_bayes is not None else ()
    return Cause(
        effect, title or f"Effect of {effect}", "F = −F_c·sign(v)", verdict, probability, size, {}, log_bayes, 15.3,
        False, "c comes out too large", "clean the table", "Fits less well than what is named.",
    )  # fmt: skip


def picture(key: str, name: str = "model as it stands") -> Picture:
    x = tuple(0.01 * i for i in range(1, 13))
    before = Curve(name, "before", x, tuple(4e-4 * (-1) ** i for i in range(12)), (1e-5,) * 12)
    after = Curve("extended model", "after", x, (1e-6,) * 12, (1e-5,) * 12)
    logs = "both" if key.startswith("spectrum") else "no"
    return Picture(
        key, f"Picture {key}", "velocity", "m/s", "force", "N", (before, after), "A step at zero is friction.",
        joined=key.startswith(("spectrum", "history")), logarithmic=logs,
    )  # fmt: skip


def explained() -> Diagnosis:
    keys = ("force-velocity", "loop", "spectrum-x", "spectrum-T", "history-x", "history-T")
    return Diagnosis(
        sample="al-1100", method="response", test="r-explained", verdict="explained",
        sentence="Missing in the model: friction.",
        tests=(
            Test("score", 15.3, 3.8, 5.5e-53, 0.005, False, "friction asks for a place."),
            Test("residual after extension", 1.9, 5.1, 0.72, 0.005, True, "No structure beyond noise."),
        ),
        causes=(
            cause("friction", "supported", 0.9996, 113.0),
            cause("drag", "not supported", 1e-9, 105.0),
            cause("tilt", "not supported", 0.0, None),
            cause("setup", "not testable", 0.0, None, title="Compliance of the set-up"),
        ),
        gain=GAIN,
        residuals=(Part("a", "x", "slack", 100, 3.0, 1.0), Part("b", "x", "slack", 300, 1.0, 1.0),
                   Part("a", "T", "spike", 50, 1.6, 1.0)),
        groups=(), discriminating_tests=(), extended_model={"friction.force": 3.79e-4},
        detectable=(Detectable("friction", "Effect of friction", "friction.force", 1.2e-4, "N", "shows"),),
        shifts=(Shift("c", "N·s/m", 8.05069, 0.00098, 8.0021, 0.0033, -49.5),),
        pictures=tuple(picture(key) for key in keys),
        chi_squared=(4.2, 1.01), notes=(f"note {HOSTILE}",), failures=("hysteresis: its fit did not converge",),
    )  # fmt: skip


def nothing() -> Diagnosis:
    tests = tuple(replace(one, passed=True, p_value=0.5) for one in explained().tests[:1])
    causes = (cause("friction", "not supported", 0.0, None), explained().causes[3])
    return replace(
        explained(), test="r-nothing", verdict="nothing missing", sentence="Nothing is missing.", tests=tests,
        causes=causes, gain={}, shifts=(), extended_model={}, chi_squared=(1.01, 1.01), notes=(), failures=(),
    )  # fmt: skip


def ambiguous() -> Diagnosis:
    causes = (cause("friction", "indistinguishable", 0.61, 40.0), cause("drag", "indistinguishable", 0.37, 39.5))
    effects = ("friction", "drag")
    return replace(
        explained(), test="d-ambiguous", method="decay", verdict="ambiguous", causes=causes, groups=(effects,),
        sentence="These data cannot tell apart: friction, drag.",
        discriminating_tests=(
            Separation(effects, "Friction: a coast run with the line slack", "it would have to show 0.38 mN"),
            Separation(effects, "Drag: a coast run at twice the speed", ""),
        ),
        pictures=(picture("rate"),),
    )  # fmt: skip


def unexplained() -> Diagnosis:
    at = (-0.1, 0.0, 0.1)
    missing = Missing("missing force", "N", "position", "m", at, (1e-3, -2e-3, 1e-3), (1e-4,) * 3, {"position": 0.8},
                      "A force of -0.002 N (u = 0.0001 N) is missing at a position of 0 m.")  # fmt: skip
    return replace(
        explained(), test=f"r-unexplained {HOSTILE}", verdict="unexplained", missing=missing, extended_model={},
        sentence=f"Something is missing that none of the known effects explains. {HOSTILE}",
        causes=(cause("drag", "not supported", 0.098, 60.0, title=HOSTILE),), groups=(),
        pictures=(picture("history-x", HOSTILE),),
    )  # fmt: skip


def overlay() -> Diagnosis:
    """Values without an uncertainty, as of oscillations that were taken out before the fit."""
    size = (Value("mains.frequency", 50.03, nan, "Hz", None, None),)
    return replace(nothing(), test="d-mains", verdict="explained", sentence="Mains in the records.", groups=(),
                   causes=(replace(cause("mains", "supported", 0.98, None), parameters=size),))  # fmt: skip
