"""Causes that an elongation test may hide, and what each means for the laboratory."""

from __future__ import annotations

import math

from metrology.diagnose.candidate import Candidate, Size

INF = math.inf


def _choice(name: str, count: int) -> Size:
    """Which of several shapes: tried one by one, and paid for by the logarithm of their number."""
    return Size(name, "1", 0.0, -0.5, count - 0.5, 0.0, True)


TABLE: dict[str, Candidate] = {
    one.name: one
    for one in (
        Candidate(
            "creep", "Creep under load", "x = … + a·Σ ΔF_i·ln(1 + t − t_i), time in readings; or a·F·ln(1 + j)",
            (Size("creep.rate", "m/N", 0.0, 0.0, INF, 1e-7), _choice("creep.kind", 2)),
            "readings grow under a load that stays, and lag behind one that is taken off; the more the larger the load",
            "k and E come out too small, by the creep up to the reading; more so where loading goes up only",
            "wait the same time at each load; state the time with k",
            "hold the largest load for an hour and read every minute",
        ),
        Candidate(
            "slip", "Slip in a clamp", "x = … + Δ from one reading on",
            (Size("slip.set", "m", 0.0, 0.0, INF, 1e-6), _choice("slip.after", 1)),
            "one step that stays",
            "k and E come out too small where the step lies among loading, too large among unloading",
            "tighten the clamp, mark the sample at it, repeat",
            "marks on the sample at the clamp, read before and after",
        ),
        Candidate(
            "toe", "Toe region", "x = … + a·(1 − exp(−F/F₀))",
            (Size("toe.extent", "m", 0.0, 0.0, INF, 1e-6), Size("toe.force", "N", 1.0, 1e-3, 1e5, 1.0, True)),
            "more extension for the first loads than for later ones, in loading and unloading alike",
            "k and E come out too small: the slope at the first loads is part of the mean",
            "preload the sample beyond the toe, or leave the first loads out",
            "smaller steps at small loads: a toe ends, a curvature goes on",
        ),
        Candidate(
            "curvature", "Line that is not straight", "x = … + a·F²",
            (Size("curvature.coefficient", "m/N²", 0.0, -INF, INF, 1e-9),),
            "residuals bend over the whole range, in loading and unloading alike",
            "k and E are means over the range of loads: 1/k = dx/dF holds at its middle only",
            "state k per range of load",
            "more loads over the same range, and beyond it",
        ),
        Candidate(
            "backlash", "Backlash of the indicator, or hysteresis", "x = … + b·g(F) when unloading",
            (Size("backlash.width", "m", 0.0, -INF, INF, 1e-6), _choice("backlash.kind", 3)),
            "unloading readings lie off loading ones at the same load",
            "k hardly changes where every load is read both ways; otherwise it is off by the slope of the difference",
            "read in one direction only, or tap the indicator",
            "indicator on a rigid stand with gauge blocks, both ways: backlash stays, hysteresis of the sample goes",
        ),
        Candidate(
            "frame", "Frame and clamps in series", "x = … + C·F",
            (Size("frame.compliance", "m/N", 0.0, 0.0, INF, 1e-7),),
            "none: it is exactly a lower k",
            "k and E come out too small by 1/(1 + C·k)",
            "measure at the specimen, not at the frame",
            "an indicator on the mount under the same loads, or a specimen of another length: x/F against length has C "
            "as its intercept",
        ),
        Candidate(
            "drift", "Drift of temperature or of the indicator", "x = … + a·j, or a settling or growing one",
            (Size("drift.rate", "m", 0.0, -INF, INF, 1e-7), _choice("drift.kind", 3)),
            "readings move with their order, whatever the load",
            "k and E are off where loading goes up only; a cycle up and down takes a steady drift out",
            "record temperature; read up and down at a steady pace",
            "an hour of readings at constant load, temperature beside it",
        ),
        Candidate(
            "misread", "A misread reading", "x = … + Δ in one reading",
            (Size("misread.error", "m", 0.0, -INF, INF, 1e-6), _choice("misread.reading", 1)),
            "one reading far off, its neighbours well",
            "k and E are pulled by one reading, the most by one at the smallest or the largest load",
            "look at the raw sheet; a whole turn of the pointer or swapped digits give themselves away",
            "the same load again",
        ),
    )
}  # fmt: skip
"""Every candidate of an elongation test; 'slip' and 'misread' get as many choices as a test has readings."""
