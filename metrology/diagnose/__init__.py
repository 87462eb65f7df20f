"""Where a model is wrong, why, and what an extension gains: one engine for every method.

`response`, `decay`, `elongation` and `tension` diagnose a test; `rank` serves any `Subject` (a model, its candidate
effects, some data).
"""

from metrology.diagnose.candidate import Candidate
from metrology.diagnose.decay import Decay, decay
from metrology.diagnose.discrepancy import Known, Other, Setting, explain
from metrology.diagnose.elongation import Elongation, elongation
from metrology.diagnose.engine import rank
from metrology.diagnose.response import Settings, response
from metrology.diagnose.runs import Response
from metrology.diagnose.subject import Direction, Fit, Subject
from metrology.diagnose.tension import Tension, tension
from metrology.diagnosis import Cause, Detectable, Diagnosis, Gain, Missing, Part, Separation, Shift, Test, Value
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
