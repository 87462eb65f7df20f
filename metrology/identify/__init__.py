"""Parameters from data: weighted least squares with priors on what the lab knows only within an uncertainty.

`fit` serves runs on the rig; `Problem`, `solve`, `covariance`, `log_evidence` and `interval` serve any model.
"""

from metrology.identify.covariance import Covariance, covariance, log_evidence
from metrology.identify.fit import Settings, fit
from metrology.identify.identification import Estimated, Identification, Residual, Source
from metrology.identify.measured import MeasuredRun
from metrology.identify.priors import Layout, Prior, lay_out
from metrology.identify.problem import Block, Problem, Segment, Unknown
from metrology.identify.profile import Interval, interval
from metrology.identify.solver import Solution, solve

__all__ = [
    "Block",
    "Covariance",
    "Estimated",
    "Identification",
    "Interval",
    "Layout",
    "MeasuredRun",
    "Prior",
    "Problem",
    "Residual",
    "Segment",
    "Settings",
    "Solution",
    "Source",
    "Unknown",
    "covariance",
    "fit",
    "interval",
    "lay_out",
    "log_evidence",
    "solve",
]
