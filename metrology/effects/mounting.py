"""Compliance of clamps and load train that is another one each time a sample is mounted."""

from metrology.effect import INF, Cause, Effect, Readings, Size


def reading(seen: Readings):
    """C·F."""
    return seen.force


EFFECT = Effect(
    name="mounting",
    title="Compliance that differs between mountings",
    equation="x = … + C_r·F in repeat r",
    sign="the slope of extension against load differs between repeats by more than the scatter of the readings",
    source="ISO 6892-1:2019, annex G (compliance of the testing machine); JCGM 100:2008, 4.2.2",
    acts="reading",
    causes=(
        Cause(
            "elongation", "mounting", (Size("mounting.compliance", "m/N", 0.0, -INF, INF, 1e-9, own=True),),
            consequence="k and E of one mounting hold for that mounting; their mean is known as far as they differ",
            advice="measure the extension at the sample, not at the crosshead; seat the clamps alike, and state the "
            "spread",
            separate="a second indicator, on the sample itself; the same sample mounted several times",
            pictures=("load",), needs=("repeats",), amount=lambda seen: seen.u / seen.most, reading=reading,
        ),
    ),
)  # fmt: skip
