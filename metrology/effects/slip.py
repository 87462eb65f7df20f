"""A clamp that slips once: at the first peak of a motion, or between two readings under dead loads."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Pulled, Readings, Size, choice


def reading(seen: Readings, after: float):
    """One step that stays."""
    return np.asarray(np.arange(len(seen.force)) > after, dtype=float)


def places(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """After every reading but the last one of a repeat."""
    inside = [row for one in np.unique(seen.repeat) for row in np.flatnonzero(seen.repeat == one)[:-1]]
    return [{"slip.after": float(row)} for row in inside]


def grips(seen: Pulled, place: float):
    """One step of the crosshead that stays."""
    return seen.crosshead * seen.after(place)


def clip(seen: Pulled, place: float):
    """One step of the extensometer that stays."""
    return (1 - seen.crosshead) * seen.after(place)


def parts(name: str):
    """Every place of every record."""
    return lambda seen, _among: [{name: float(at)} for at in seen.places]


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
        Cause(
            "tension", "slip", (Size("slip.set", "m", 0.0, 0.0, INF, 1e-6), choice("slip.place", 1)),
            title="Slip in the grips",
            equation="x = … + Δ from one instant on",
            sign="one step of the crosshead that stays, the extensometer does not follow",
            consequence="the set-up's compliance comes out too large; k and E by the extensometer stand",
            advice="tighten the grips, mark the specimen at them, repeat",
            separate="marks on the specimen at the grips, read before and after",
            pictures=("order",), amount=lambda seen: seen.u, shapes=parts("slip.place"),
            limits=lambda seen: {"slip.place": (-0.5, len(seen.places) - 0.5)}, reading=grips,
        ),
        Cause(
            "tension", "extensometer slip", (Size("clip.set", "m", 0.0, -INF, INF, 1e-6), choice("clip.place", 1)),
            title="Slip of the extensometer",
            equation="ε_read = … + Δ/L from one instant on",
            sign="one step of the strain that stays, the crosshead does not follow",
            consequence="k and E are off by the step over the range",
            advice="clean the knife edges, raise the clip's force, mount it again",
            separate="a second extensometer; a light tap shows whether it holds",
            pictures=("order",), needs=("tether",), amount=lambda seen: seen.u, shapes=parts("clip.place"),
            limits=lambda seen: {"clip.place": (-0.5, len(seen.places) - 0.5)}, reading=clip,
        ),
    ),
)  # fmt: skip
