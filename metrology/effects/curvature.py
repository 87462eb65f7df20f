"""A load line that is not straight."""

from metrology.effect import INF, Cause, Effect, Pulled, Readings, Size, choice


def reading(seen: Readings, kind: float):
    """F²; or F³ over the largest force, as of a spring that stiffens with e² (the cubic stiffness of a motion)."""
    return seen.force**2 if round(kind) == 0 else seen.force**3 / seen.most


def pulled(seen: Pulled):
    """(F − F̄)² in both readings: the slope at the middle of the range stays."""
    return (seen.force - seen.middle) ** 2


EFFECT = Effect(
    name="curvature",
    title="Line that is not straight",
    equation="x = … + a·F²; or a·F³/F_max",
    sign="residuals bend over the whole range, in loading and unloading alike",
    source="second or third term of a power series of x(F)",
    acts="line",
    causes=(
        Cause(
            "elongation", "curvature",
            (Size("curvature.coefficient", "m/N²", 0.0, -INF, INF, 1e-9), choice("curvature.kind", 2)),
            consequence="k and E are means over the range of loads: 1/k = dx/dF holds at its middle only",
            advice="state k per range of load",
            separate="more loads over the same range, and beyond it",
            pictures=("load",), amount=lambda seen: seen.u / seen.most**2, reading=reading, law="stiffness",
        ),
        Cause(
            "tension", "curvature", (Size("curvature.coefficient", "m/N²", 0.0, -INF, INF, 1e-12),),
            title="Softening or hardening of the specimen",
            equation="ε = … + a/L·(F − F_m)²",
            sign="residuals bend over the whole range, by crosshead and extensometer alike",
            consequence="k and E are tangents at the middle of the range",
            advice="state k and E with the range, or choose a narrower one",
            separate="unload and pull again: what is elastic bends in the same way",
            pictures=("load",), amount=lambda seen: seen.u / seen.most**2, reading=pulled, law="stiffness",
        ),
        Cause(
            "tension", "uneven curvature",
            (Size("curvature.uneven", "m/N²", 0.0, -INF, INF, 1e-12, own=True),),
            title="Softening or hardening that differs between the specimens",
            equation="ε = … + a_i/L·(F − F_m)², a_i of specimen i, 0 on average",
            sign="residuals bend by crosshead and extensometer alike, of some specimens more than of others",
            consequence="k and E are tangents at the middle of the range",
            advice="state k and E with the range, or choose a narrower one",
            separate="unload and pull again: what is elastic bends in the same way",
            pictures=("load",), needs=("repeats",), amount=lambda seen: seen.u / seen.most**2, reading=pulled,
        ),
    ),
)  # fmt: skip
