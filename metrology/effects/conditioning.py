"""A sample whose first loading is another line than all that follows: a strand that beds in, knots that tighten."""

from metrology.effect import INF, Cause, Effect, Readings, Size, choice


def reading(seen: Readings, kind: float):
    """Highest load so far: in each repeat anew (0), where each is another mounting or sample, or in the test (1)."""
    return seen.highest(mounted=round(kind) == 0)


EFFECT = Effect(
    name="conditioning",
    title="First loading that leaves a set",
    equation="x = … + a·F_m, F_m the highest load so far",
    sign="more extension when a load is reached for the first time, which stays when it is taken off",
    source="ISO 2307:2019, 9 (bedding in of ropes before the elongation is measured)",
    acts="line",
    causes=(
        Cause(
            "elongation", "conditioning",
            (Size("conditioning.compliance", "m/N", 0.0, 0.0, INF, 1e-9), choice("conditioning.kind", 2)),
            consequence="k and E come out too small where first loadings are used: those of unloading, or of loading "
            "again, hold",
            advice="load once to the largest load, and take it off, before the first reading",
            separate="load again without taking the sample out: a set does not grow, creep and drift go on",
            pictures=("load",), needs=("unloading",), amount=lambda seen: seen.u / seen.most, reading=reading,
            # A drift differs from it by what is read at the turn only: together, one large against the other, they
            # would follow a backlash of any form, and k with them.
            law="set or drift",
        ),
    ),
)  # fmt: skip
