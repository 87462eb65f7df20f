"""A line that is soft at first: a knee in the motion, a smooth toe in the readings under dead loads."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Pulled, Readings, Scales, Size


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Extents over the largest elongation."""
    return [{"toe.extent": part * known["e"]} for part in (0.08, 0.15, 0.25, 0.4, 0.6)]


def reading(seen: Readings, force: float):
    """1 − exp(−F/F₀)."""
    return -np.expm1(-seen.force / force)


def specimen(seen: Pulled, force: float):
    """1 − exp(−F/F₀) in both readings."""
    return -np.expm1(-np.maximum(seen.force, 0.0) / force)


def grips(seen: Pulled, force: float):
    """1 − exp(−F/F₀) in the crosshead."""
    return seen.crosshead * specimen(seen, force)


def clip(seen: Pulled, force: float):
    """1 − exp(−F/F₀) in the extensometer."""
    return (1 - seen.crosshead) * specimen(seen, force)


def tried(name: str):
    """Forces F₀ over the largest one."""
    return lambda seen, _among: [{name: part * seen.most} for part in (0.02, 0.04, 0.08, 0.16)]


def within(name: str, most: float = 0.3):
    """Range of F₀ that the loads can show: a toe that does not end (e⁻³ at the largest load) is a curve, or a line."""
    return lambda seen: {name: (0.01 * seen.most, most * seen.most)}


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
        Cause(
            "tension", "toe",
            (Size("toe.extent", "m", 0.0, 0.0, INF, 1e-6), Size("toe.force", "N", 1.0, 1e-3, 1e7, 1.0, True, apart=6)),
            title="Toe region of the specimen",
            equation="ε = … + a/L·(1 − exp(−F/F₀))",
            sign="more stretch at first, by crosshead and extensometer alike",
            consequence="k and E come out too small: the slope at the first loads is part of the mean",
            advice="begin the range beyond the toe (ISO 527-1: 0.05 % strain)",
            separate="a preload, then the same range again: a toe of a curved or loose specimen goes",
            pictures=("load",), amount=lambda seen: seen.u, shapes=tried("toe.force"),
            # One that has not ended (e⁻⁵) would be hardening.
            limits=within("toe.force", 0.2),
            reading=specimen, law="stiffness",
        ),
        Cause(
            "tension", "slack",
            (Size("slack.extent", "m", 0.0, 0.0, INF, 1e-6, own=True),
             Size("slack.force", "N", 1.0, 1e-3, 1e7, 1.0, True, apart=6)),
            title="Slack of grips and frame",
            equation="x = … + a·(1 − exp(−F/F₀))",
            sign="the crosshead moves more at first, the extensometer does not",
            consequence="the set-up's compliance depends on the load; k and E by the extensometer stand",
            advice="preload; take C over the range of the line",
            separate="the stiff bar again, from zero load in small steps",
            pictures=("load",), needs=("tether",), amount=lambda seen: seen.u, shapes=tried("slack.force"),
            limits=within("slack.force"), reading=grips,
        ),
        Cause(
            "tension", "extensometer toe",
            (Size("clip.extent", "m", 0.0, -INF, INF, 1e-6, own=True),
             Size("clip.force", "N", 1.0, 1e-3, 1e7, 1.0, True, apart=6)),
            title="Extensometer that settles",
            equation="ε_read = … + a/L·(1 − exp(−F/F₀))",
            sign="the extensometer reads more, or less, at first, and the crosshead does not follow",
            consequence="k and E are off where the range holds its settling",
            advice="seat the knife edges at a preload; look at the pattern of the image correlation; mount it again",
            separate="a second extensometer on the opposite side",
            pictures=("load",), needs=("tether",), amount=lambda seen: seen.u, shapes=tried("clip.force"),
            limits=within("clip.force"), reading=clip,
        ),
    ),
)  # fmt: skip
