"""Where a model is wrong, why, and what an extension gains: one engine for every method.

`response`, `decay`, `elongation` and `tension` diagnose a test; `rank` serves any `Subject` (a model, its candidate
effects, some data).
"""

from metrology.diagnosis import Cause, Detectable, Diagnosis, Gain, Missing, Part, Separation, Shift, Test, Value
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.decay import Decay, decay
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.discrepancy import explain
from metrology.diagnostics.discrepancy_setting import Known, Other, Setting
from metrology.diagnostics.elongation import Elongation, elongation
from metrology.diagnostics.engine import rank
from metrology.diagnostics.response import Settings, response
from metrology.diagnostics.runs import Response
from metrology.diagnostics.subject import Fit, Subject
from metrology.diagnostics.tension import Tension, tension
from metrology.effect import Size

__all__ = [
    "Candidate",
    "Cause",
    "Decay",
    "Detectable",
    "Diagnosis",
    "Direction",
    "Elongation",
    "Fit",
    "Gain",
    "Known",
    "Missing",
    "Other",
    "Part",
    "Response",
    "Separation",
    "Setting",
    "Settings",
    "Shift",
    "Size",
    "Subject",
    "Tension",
    "Test",
    "Value",
    "decay",
    "elongation",
    "explain",
    "rank",
    "response",
    "tension",
]
