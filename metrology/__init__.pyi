from metrology.api import Budget as Budget
from metrology.api import Plot as Plot
from metrology.api import Plots as Plots
from metrology.api import Quantity as Quantity
from metrology.api import Results as Results
from metrology.api import diagnose as diagnose
from metrology.api import identify as identify
from metrology.api import load as load
from metrology.api import run as run
from metrology.errors import MetrologyError as MetrologyError
from metrology.rig import Force as Force
from metrology.rig import Rig as Rig
from metrology.rig import Run as Run
from metrology.rig import simulate as simulate

__version__: str
__all__ = [
    "Budget",
    "Force",
    "MetrologyError",
    "Plot",
    "Plots",
    "Quantity",
    "Results",
    "Rig",
    "Run",
    "__version__",
    "diagnose",
    "identify",
    "load",
    "run",
    "simulate",
]
