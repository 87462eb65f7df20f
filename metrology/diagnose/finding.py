"""Values of a diagnosis under the name that the rooms of the engine use; `metrology.diagnosis` holds them.

They stand apart since whoever reads `results.json` needs the values and not the engine, which brings the rig with it.
"""

from metrology.diagnosis import (
    Cause,
    Curve,
    Detectable,
    Diagnosis,
    Discrepancy,
    Explanation,
    Floats,
    Gain,
    Judgement,
    Missing,
    Part,
    Picture,
    Role,
    Separation,
    Shift,
    Support,
    Test,
    Value,
    Verdict,
)

__all__ = [
    "Cause",
    "Curve",
    "Detectable",
    "Diagnosis",
    "Discrepancy",
    "Explanation",
    "Floats",
    "Gain",
    "Judgement",
    "Missing",
    "Part",
    "Picture",
    "Role",
    "Separation",
    "Shift",
    "Support",
    "Test",
    "Value",
    "Verdict",
]
