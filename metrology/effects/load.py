"""One load of an elongation test that is not the stated one, or was exchanged."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Readings, Size, choice


def reading(seen: Readings, which: float):
    """All readings at one load."""
    return np.asarray(seen.force == np.unique(seen.force)[round(which)], dtype=float)


def places(seen: Readings, _among: Container[str]) -> list[dict[str, float]]:
    """Every load."""
    return [{"load.which": float(at)} for at in range(len(np.unique(seen.force)))]


EFFECT = Effect(
    name="load",
    title="A load that is not the stated one",
    equation="x = … + Δ at one load",
    sign="all readings at one load are off alike, loading and unloading, in every repeat",
    source="OIML R 111-1:2004, 5 (maximum permissible errors of weights)",
    acts="reading",
    causes=(
        Cause(
            "elongation", "load", (Size("load.error", "m", 0.0, -INF, INF, 1e-6), choice("load.which", 1)),
            consequence="k and E are pulled by one load, the most by the smallest or the largest",
            advice="weigh the loads again; two neighbours off by as much, one up and one down, were exchanged",
            separate="the same load on a balance",
            pictures=("load",), amount=lambda seen: seen.u, shapes=places,
            limits=lambda seen: {"load.which": (-0.5, len(np.unique(seen.force)) - 0.5)}, reading=reading,
        ),
    ),
)  # fmt: skip
