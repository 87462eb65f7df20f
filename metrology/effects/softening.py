"""A sample, or a clamp, that gives more from a load on and goes back the same way: a knee."""

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size
from metrology.effects import saturation

LEAST = 0.5
"""Smallest knee over the largest load: k is that of the loads below it, and so of most of them.

An initial tension is the same curve of load, with the k of the loads above. From 0.35 on, where that one ends, a spring
whose coils part at 0.3 of the largest load (`tests/diagnostics/test_decay_elongation.py`) was the one or the other, and
its u(k) a tenth of k."""


def reading(seen: Readings, force: float):
    """max(F − F_k, 0)."""
    return np.maximum(seen.force - force, 0.0)


def between(seen: Readings, least: float, *, beyond: int = 1) -> list[float]:
    """Places of a knee between two loads, from such a force on; the largest that it may have where there is none."""
    low, high = within(seen, least, beyond=beyond)
    return [float(one) for one in saturation.between(seen) if low <= one <= high] or [high]


def within(seen: Readings, least: float, *, beyond: int = 1) -> tuple[float, float]:
    """From such a force, and the second load, to the last one that has so many loads beyond it.

    Nearer to an end a larger compliance does the same, without end.
    """
    loads = np.unique(seen.force)
    low = max(float(loads[:2][-1]), least)
    return low, max(float(loads[-1 - beyond :][0]), low)


EFFECT = Effect(
    name="softening",
    title="Softening above a load",
    equation="x = … + a·max(F − F_k, 0)",
    sign="a knee in extension against load, in loading and unloading alike and in every repeat",
    source="a spring in series with the line, preloaded to F_k, opens beyond it",
    acts="line",
    causes=(
        Cause(
            "elongation", "softening",
            (
                Size("softening.compliance", "m/N", 0.0, 0.0, INF, 1e-9),
                Size("softening.force", "N", 1.0, 1e-3, 1e5, 1.0, True),
            ),
            consequence="k and E come out too small: they hold below F_k only",
            advice="end the range of loads below F_k, or state k on either side of it",
            separate="more loads about F_k; a mark on the sample at the clamp shows whether the clamp opens",
            pictures=("load",), amount=lambda seen: seen.u / seen.most,
            shapes=lambda seen, _: [{"softening.force": one} for one in between(seen, LEAST * seen.most)],
            limits=lambda seen: {"softening.force": within(seen, LEAST * seen.most)},
            reading=reading, law="stiffness",
        ),
    ),
)  # fmt: skip
