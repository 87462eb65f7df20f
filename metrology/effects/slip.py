"""A clamp that slips once: at the first peak of a motion, or between two readings under dead loads."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Readings, Size, choice


def reading(seen: Readings, after: float):
    """One step that stays."""
    return np.asarray(np.arange(len(seen.force)) > after, dtype=float)


def places(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """After every reading but the last one of a repeat."""
    inside = [row for one in np.unique(seen.repeat) for row in np.flatnonzero(seen.repeat == one)[:-1]]
    return [{"slip.after": float(row)} for row in inside]


EFFECT = Effect(
    name="slip",
    title="Clamp slip at the first peak",
    equation="x_t → x_t + Δ from the first turn of the taut line on",
    parameters=(Parameter("slip.set", "Δ", "m", 0.0, 0.0, INF, (0.0, 0.02), 1e-5, "permanent set"),),
    sign="tension drops at the first peak; taut position moves once",
    source="ISO 527-1:2019, 9.3 (slip in the grips)",
    acts="line", built_in=True,
    causes=(
        Cause(
            "response", "slip", ("slip.set",),
            consequence="free length wrong from the first peak on; k too small when it is fitted over both",
            advice="tighten the clamp, mark the line at it; discard the first pull",
            separate="measure the taut position again after the run",
            pictures=("force-elongation", "order"), needs=("tether",), amount=lambda known: 0.005 * known["e"],
        ),
        Cause(
            "elongation", "slip", (Size("slip.set", "m", 0.0, 0.0, INF, 1e-6), choice("slip.after", 1)),
            title="Slip in a clamp",
            equation="x = … + Δ from one reading on",
            sign="one step that stays",
            consequence="k and E come out too small where the step lies among loading, too large among unloading",
            advice="tighten the clamp, mark the sample at it, repeat",
            separate="marks on the sample at the clamp, read before and after",
            pictures=("order", "force-elongation"), amount=lambda seen: seen.u, shapes=places,
            limits=lambda seen: {"slip.after": (-0.5, len(seen.force) - 0.5)}, reading=reading,
        ),
    ),
)  # fmt: skip
