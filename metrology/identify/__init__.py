"""Parameters from data: weighted least squares with priors on what the lab knows only within an uncertainty.

`fit` serves runs on the rig; `Problem`, `solve`, `covariance`, `log_evidence` and `interval` serve any model.
"""

from metrology.identify.budget import knowns, shares
from metrology.identify.covariance import Covariance, covariance, log_evidence
from metrology.identify.exact import followed
from metrology.identify.finding import ChannelRow, PaperRow, ParameterRow, ResponseFinding, finding
from metrology.identify.fit import Settings, fit, fit_own
from metrology.identify.identification import Estimated, Identification, Joint, Residual, Source
from metrology.identify.measured import MeasuredRun
from metrology.identify.paper import PaperWay, paper_way
from metrology.identify.priors import Layout, Prior, lay_out
from metrology.identify.problem import Block, Problem, Segment, Unknown
from metrology.identify.profile import Interval, interval
from metrology.identify.response import beside_contact, slopes
from metrology.identify.solver import Solution, solve

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
