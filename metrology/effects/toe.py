"""A line that is soft at first: a knee in the motion, a smooth toe in the readings under dead loads."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Readings, Scales, Size


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Extents over the largest elongation."""
    return [{"toe.extent": part * known["e"]} for part in (0.08, 0.15, 0.25, 0.4, 0.6)]


def reading(seen: Readings, force: float):
    """1 − exp(−F/F₀)."""
    return -np.expm1(-seen.force / force)


EFFECT = Effect(
    name="toe",
    title="Toe region: soft at first, then the full stiffness",
    equation="T = r·k·ε up to ε_t, T = k·(ε − (1 − r)·ε_t) beyond",
    parameters=(
        Parameter("toe.extent", "ε_t", "m", 0.0, 0.0, INF, (0.0, 0.05), 1e-5, "elongation at which the toe ends"),
        Parameter("toe.ratio", "r", "1", 0.5, 1e-3, 1e3, (0.05, 1.0), 0.01, "stiffness in the toe over full stiffness"),
    ),
    sign="two slopes in T against elongation with one knee",
    source="ASTM D638-14, annex A1 (toe compensation)",
    acts="line", built_in=True,
    causes=(
        Cause(
            "response", "toe",
            # The size is what it lacks of the full stiffness; its extent is a shape, and means nothing at ratio 1.
            (Size("toe.ratio", "1", 1.0, 0.02, 1.0, 0.01), "toe.extent"),
            consequence="k comes out too small, and E with it, as at the start of a tensile curve",
            advice="preload the line beyond ε_t, or fit the straight part only",
            separate="static loading in fine steps from zero load",
            pictures=("force-elongation", "frequency"), needs=("tether",), amount=-0.05, shapes=shapes,
            limits=lambda known: {"toe.extent": (0.01 * known["e"], 1.5 * known["e"])},
        ),
        Cause(
            "elongation", "toe",
            (Size("toe.extent", "m", 0.0, 0.0, INF, 1e-6), Size("toe.force", "N", 1.0, 1e-3, 1e5, 1.0, True)),
            title="Toe region",
            equation="x = … + a·(1 − exp(−F/F₀))",
            sign="more extension for the first loads than for later ones, in loading and unloading alike",
            consequence="k and E come out too small: the slope at the first loads is part of the mean",
            advice="preload the sample beyond the toe, or leave the first loads out",
            separate="smaller steps at small loads: a toe ends, a curvature goes on",
            pictures=("load",), amount=lambda seen: seen.u,
            shapes=lambda seen, _: [{"toe.force": part * seen.most} for part in (0.05, 0.15, 0.4)],
            limits=lambda seen: {"toe.force": (0.01 * seen.most, 0.7 * seen.most)}, reading=reading,
        ),
    ),
)  # fmt: skip
