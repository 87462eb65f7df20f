"""An indicator, or a sample against a stop, that no longer follows the largest loads."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Array, Cause, Effect, Readings, Size


def reading(seen: Readings, force: float):
    """−max(F − F_s, 0)."""
    return -np.maximum(seen.force - force, 0.0)


def between(seen: Readings) -> Array:
    """Forces half way between two loads; the last but one load, beyond which compliance and force do the same."""
    loads = np.unique(seen.force)
    return np.append(0.5 * (loads[1:-1] + loads[:-2]), loads[-2:-1])


def places(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """Between the loads of the upper half."""
    middle = between(seen)
    return [{"saturation.force": float(one)} for one in middle[len(middle) // 2 :]]


def limits(seen: Readings) -> dict[str, tuple[float, float]]:
    """Up to the last but one load: nearer to the largest a larger compliance does the same, without end."""
    return {"saturation.force": (0.3 * seen.most, max(float(np.max(between(seen), initial=0.0)), 0.31 * seen.most))}


EFFECT = Effect(
    name="saturation",
    title="Saturation at large loads",
    equation="x = … − s·max(F − F_s, 0)",
    sign="the largest loads all read too little, from one load on, in every repeat",
    source="ISO 463:2006, 6 (measuring span of a dial gauge)",
    acts="reading",
    causes=(
        Cause(
            "elongation", "saturation",
            (
                Size("saturation.compliance", "m/N", 0.0, 0.0, INF, 1e-9),
                Size("saturation.force", "N", 1.0, 1e-3, 1e5, 1.0, True),
            ),
            consequence="k and E come out too large: the last loads pull the line down",
            advice="set the indicator so that its span holds all readings; leave the largest loads out",
            separate="the same loads with the indicator set back by a gauge block",
            pictures=("load",), amount=lambda seen: seen.u / seen.most, shapes=places,
            limits=limits, reading=reading,
        ),
    ),
)  # fmt: skip
