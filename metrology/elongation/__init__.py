"""Elongation under dead loads: stiffness k of a sample from load and extension."""

from metrology.elongation.analysis import ElongationAnalysis, analyse, by_drift
from metrology.elongation.finding import ElongationFinding, LoadLevel, RepeatLine
from metrology.elongation.test import DIRECTIONS, LEAST_LOADS, Correction, ElongationTest, Load, Reading, too_few

__all__ = [
    "DIRECTIONS",
    "LEAST_LOADS",
    "Correction",
    "ElongationAnalysis",
    "ElongationFinding",
    "ElongationTest",
    "Load",
    "LoadLevel",
    "Reading",
    "RepeatLine",
    "analyse",
    "by_drift",
    "too_few",
]
