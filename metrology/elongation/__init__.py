"""Elongation under dead loads: stiffness k of a sample from load and extension."""

from metrology.elongation.analysis import ElongationAnalysis, analyse
from metrology.elongation.finding import Check, ElongationFinding, LoadLevel, RepeatLine
from metrology.elongation.test import Correction, ElongationTest, Load, Reading

__all__ = [
    "Check",
    "Correction",
    "ElongationAnalysis",
    "ElongationFinding",
    "ElongationTest",
    "Load",
    "LoadLevel",
    "Reading",
    "RepeatLine",
    "analyse",
]
