"""Measured against simulated: metrics, comparison error and its uncertainty, bands, and a verdict with its rule."""

from metrology.verify.compare import compare
from metrology.verify.finding import PhaseScore, RingingScore, RunVerification, Series, VerificationFinding
from metrology.verify.judge import RULE, excess, judge
from metrology.verify.metrics import METRICS
from metrology.verify.phases import Phase, phases
from metrology.verify.prediction import Prediction, closed_loop, open_loop
from metrology.verify.series import thinned, trace

__all__ = [
    "METRICS",
    "RULE",
    "Phase",
    "PhaseScore",
    "Prediction",
    "RingingScore",
    "RunVerification",
    "Series",
    "VerificationFinding",
    "closed_loop",
    "compare",
    "excess",
    "judge",
    "open_loop",
    "phases",
    "thinned",
    "trace",
]
