"""The public interface of Python: load a campaign, evaluate it, look at what came out.

Everything here is stable within a version of the package; other modules are not. Numbers are in SI.
"""

from metrology.api.plot import Plot, Plots
from metrology.api.quantity import Budget, Quantity
from metrology.api.results import Results
from metrology.api.running import load, run
from metrology.api.single import diagnose, identify

__all__ = ["Budget", "Plot", "Plots", "Quantity", "Results", "diagnose", "identify", "load", "run"]
