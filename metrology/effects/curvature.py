"""A load line that is not straight."""

from metrology.effect import INF, Cause, Effect, Readings, Size


def reading(seen: Readings):
    """F²."""
    return seen.force**2


EFFECT = Effect(
    name="curvature",
    title="Line that is not straight",
    equation="x = … + a·F²",
    sign="residuals bend over the whole range, in loading and unloading alike",
    source="second term of a power series of x(F)",
    acts="line",
    causes=(
        Cause(
            "elongation", "curvature", (Size("curvature.coefficient", "m/N²", 0.0, -INF, INF, 1e-9),),
            consequence="k and E are means over the range of loads: 1/k = dx/dF holds at its middle only",
            advice="state k per range of load",
            separate="more loads over the same range, and beyond it",
            pictures=("load",), amount=lambda seen: seen.u / seen.most**2, reading=reading,
        ),
    ),
)  # fmt: skip
