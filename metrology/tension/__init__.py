"""Tension in a testing machine: stiffness, modulus, strength and the set-up's compliance from continuous records."""

from metrology.tension.analysis import TensionAnalysis, analyse
from metrology.tension.finding import TensionFinding
from metrology.tension.test import Mounting, Range, TensionTest

__all__ = ["Mounting", "Range", "TensionAnalysis", "TensionFinding", "TensionTest", "analyse"]
