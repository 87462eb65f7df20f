"""A sample that hardly extends below its initial tension: a close-wound spring, a stranded or glued line."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size

ROUND = (0.05, 0.15)
"""Load over which coils part one after the other, over that at which they part. Between 0.2 and 0.4 one at eight loads
took the place of a curvature with two faults of single readings (elongation-s61-pair-10 of the benchmark)."""
LOW = 0.35
"""Largest initial tension over the largest load: with 0.7 a curvature at nine standard deviations did as well."""


def reading(seen: Readings, force: float, roundness: float):
    """w·ln(1 + exp((F₀ − F)/w)), w = r·F₀: F₀ − F where the line of the larger loads lies lower; none well above F₀."""
    width = roundness * force
    return width * np.logaddexp(0.0, (force - seen.force) / width)


def shapes(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """Between the lower loads, from sharp to round."""
    loads = np.unique(seen.force)
    middle = 0.5 * (loads[1:] + loads[:-1])
    low = middle[middle <= LOW * seen.most]
    return [
        {"initial_tension.force": float(one), "initial_tension.roundness": part}
        for one in (low if low.size else middle[:1]) for part in ROUND
    ]  # fmt: skip


EFFECT = Effect(
    name="initial_tension",
    title="Initial tension: hardly any extension below a load",
    equation="x = … + s·w·ln(1 + exp((F₀ − F)/w)), w = r·F₀",
    sign="the smallest loads extend the sample less than later ones do, in loading and unloading alike",
    source="EN 13906-2:2013 (initial tension of extension springs)",
    acts="line",
    causes=(
        Cause(
            "elongation", "initial tension",
            (
                Size("initial_tension.compliance", "m/N", 0.0, 0.0, INF, 1e-7),
                Size("initial_tension.force", "N", 1.0, 1e-3, 1e5, 1.0, True),
                Size("initial_tension.roundness", "1", 0.1, *ROUND, 0.1, True, apart=3),
            ),
            consequence="k and E come out too large: the loads below F₀ make the line flatter",
            advice="begin with a load above the initial tension, or leave the first loads out",
            separate="fine steps of small loads: where the coils part, or the strands begin to slide, can be seen",
            pictures=("load",), needs=("loads",), amount=lambda seen: seen.u / seen.most, shapes=shapes,
            limits=lambda seen: {"initial_tension.force": (0.01 * seen.most, LOW * seen.most)}, reading=reading,
            law="stiffness",
        ),
    ),
)  # fmt: skip
