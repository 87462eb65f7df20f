"""A sample, or a clamp, that gives more from a load on and goes back the same way: a knee."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size
from metrology.effects.saturation import between


def reading(seen: Readings, force: float):
    """max(F − F_k, 0)."""
    return np.maximum(seen.force - force, 0.0)


def places(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """Between two loads."""
    return [{"softening.force": float(one)} for one in between(seen)]


def limits(seen: Readings) -> dict[str, tuple[float, float]]:
    """Between the second load and the last but one: nearer to an end a larger compliance does the same, without end."""
    loads = np.unique(seen.force)
    return {"softening.force": (float(loads[1]), float(loads[-2]))}


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
            pictures=("load",), amount=lambda seen: seen.u / seen.most, shapes=places,
            limits=limits, reading=reading, law="stiffness",
        ),
    ),
)  # fmt: skip
