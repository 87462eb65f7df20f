"""One reading that was misread."""

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size, choice


def reading(seen: Readings, reading: float):
    """One reading off."""
    return np.asarray(np.arange(len(seen.force)) == round(reading), dtype=float)


EFFECT = Effect(
    name="misread",
    title="A misread reading",
    equation="x = … + Δ in one reading",
    sign="one reading far off, its neighbours well",
    source="JCGM 100:2008, 3.4.7 (blunders)",
    acts="reading",
    causes=(
        Cause(
            "elongation", "misread", (Size("misread.error", "m", 0.0, -INF, INF, 1e-6), choice("misread.reading", 1)),
            consequence="k and E are pulled by one reading, the most by one at the smallest or the largest load",
            advice="look at the raw sheet; a whole turn of the pointer or swapped digits give themselves away",
            separate="the same load again",
            pictures=("order",), amount=lambda seen: seen.u,
            shapes=lambda seen, _: [{"misread.reading": float(row)} for row in range(len(seen.force))],
            limits=lambda seen: {"misread.reading": (-0.5, len(seen.force) - 0.5)}, reading=reading,
        ),
    ),
)  # fmt: skip
