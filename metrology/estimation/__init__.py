"""Parameters from data: weighted least squares with priors on what the lab knows only within an uncertainty.

`fit` serves runs on the rig; `Problem`, `solve`, `covariance`, `log_evidence` and `interval` serve any model.
"""

from metrology.estimation.budget import knowns, shares
from metrology.estimation.covariance import Covariance, covariance, log_evidence
from metrology.estimation.exact import followed
from metrology.estimation.finding import ChannelRow, PaperRow, ParameterRow, ResponseFinding, finding
from metrology.estimation.fit import Settings, fit, fit_own
from metrology.estimation.identification import Estimated, Identification, Joint, Residual, Source
from metrology.estimation.measured import MeasuredRun
from metrology.estimation.paper import PaperWay, paper_way
from metrology.estimation.priors import Layout, Prior, lay_out
from metrology.estimation.problem import Block, Problem, Segment, Unknown
from metrology.estimation.profile import Interval, interval
from metrology.estimation.response import beside_contact, slopes
from metrology.estimation.solver import Solution, solve

__all__ = [
    "Block",
    "ChannelRow",
    "Covariance",
    "Estimated",
    "Identification",
    "Interval",
    "Joint",
    "Layout",
    "MeasuredRun",
    "PaperRow",
    "PaperWay",
    "ParameterRow",
    "Prior",
    "Problem",
    "Residual",
    "ResponseFinding",
    "Segment",
    "Settings",
    "Solution",
    "Source",
    "Unknown",
    "beside_contact",
    "covariance",
    "finding",
    "fit",
    "fit_own",
    "followed",
    "interval",
    "knowns",
    "lay_out",
    "log_evidence",
    "paper_way",
    "shares",
    "slopes",
    "solve",
]
