"""An indicator, or a sample, that reads another value on the way back."""

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size, choice


def reading(seen: Readings, kind: float):
    """Unloading off by the same amount; by it but at the largest load; by a loop that closes at both ends."""
    F = seen.force
    low, high = float(F.min()), float(F.max())
    part = (F - low) / max(high - low, 1e-300)
    return (seen.back, np.asarray(seen.back * (high > F), dtype=float), seen.back * 4 * part * (1 - part))[round(kind)]


EFFECT = Effect(
    name="backlash",
    title="Backlash of the indicator, or hysteresis",
    equation="x = … + b·g(F) when unloading",
    sign="unloading readings lie off loading ones at the same load",
    source="ISO 376:2011, 7.4 (reversibility error)",
    acts="reading",
    causes=(
        Cause(
            "elongation", "backlash", (Size("backlash.width", "m", 0.0, -INF, INF, 1e-6), choice("backlash.kind", 3)),
            consequence="k hardly changes where every load is read both ways; otherwise it is off by the slope of the "
            "difference",
            advice="read in one direction only, or tap the indicator",
            separate="indicator on a rigid stand with gauge blocks, both ways: backlash stays, hysteresis of the "
            "sample goes", pictures=("load",), needs=("unloading",), amount=lambda seen: seen.u, reading=reading,
        ),
    ),
)  # fmt: skip
