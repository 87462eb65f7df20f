"""Free decay of a mass on the sample: natural frequency ω_n, damping ratio ζ and damping coefficient c."""

from metrology.decay.analysis import DecayAnalysis, DecayTest, analyse
from metrology.decay.finding import DampingShape, DecayFinding, DecayRecord

__all__ = ["DampingShape", "DecayAnalysis", "DecayFinding", "DecayRecord", "DecayTest", "analyse"]
