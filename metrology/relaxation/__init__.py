"""Relaxation and creep: stiffness over time and frequency from records of a held elongation or load."""

from metrology.relaxation.analysis import RelaxationAnalysis, analyse
from metrology.relaxation.finding import RelaxationFinding
from metrology.relaxation.mean import mean, resolved
from metrology.relaxation.model import Facts
from metrology.relaxation.test import Mounting, RelaxationTest, Sweep

__all__ = [
    "Facts",
    "Mounting",
    "RelaxationAnalysis",
    "RelaxationFinding",
    "RelaxationTest",
    "Sweep",
    "analyse",
    "mean",
    "resolved",
]
