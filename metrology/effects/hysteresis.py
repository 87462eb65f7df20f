"""A branch that yields: a loop that stays open however slow."""

from collections.abc import Container

import numpy as np

from metrology.effect import INF, Cause, Effect, Parameter, Readings, Scales, Size, choice


def shapes(known: Scales, _among: Container[str]) -> list[dict[str, float]]:
    """Yields over the largest elongation."""
    return [{"hysteresis.yield": part * known["e"]} for part in (0.03, 0.06, 0.12, 0.25, 0.5)]


ELEMENTS = 64
"""Yield forces, evenly up to the largest load: with ever more of them the branches are Rayleigh's parabolas."""


def reading(seen: Readings, kind: float):
    """Mean of how far elements with dry friction have moved, less the chord of the last cycle, which is part of k.

    An element moves on where the load has changed by more than twice its yield force since it turned (Prandtl;
    Ishlinskii). `kind`: twice whether the sample was relieved between repeats, and once more whether it had been loaded
    before the first.
    """
    relieved, before = divmod(round(kind), 2)
    most = seen.most
    yields = most * np.arange(1, ELEMENTS + 1) / ELEMENTS
    held, last = np.zeros(ELEMENTS), 0.0
    found = np.zeros(len(seen.force))

    def moved(force: float) -> float:
        nonlocal held, last
        held, last = np.clip(held + force - last, -yields, yields), force
        return float(np.mean(force - held))

    if before:
        moved(most)
        moved(0.0 if relieved else float(seen.force[0]))
    for at, force in enumerate(seen.force.tolist()):
        if relieved and at and seen.repeat[at] != seen.repeat[at - 1]:
            moved(0.0)
        found[at] = moved(force)
    low, high = (np.flatnonzero(seen.force == end)[-1] for end in (seen.force.min(), most))
    chord = (found[high] - found[low]) / (most - seen.force[low]) if high != low else 0.0
    return (found - chord * seen.force) / most


EFFECT = Effect(
    name="hysteresis",
    title="Bouc–Wen hysteresis",
    equation="T = k·ε + k_h·h, h′ = ε′·(1 − ½·(1 + sign(ε′·h))·|h/h_y|)",
    parameters=(
        Parameter("hysteresis.stiffness", "k_h", "N/m", 0.0, 0.0, INF, (0.0, 1e5), 0.1,
                  "stiffness of the yielding branch", linear=False),
        Parameter("hysteresis.yield", "h_y", "m", 1e-3, 1e-12, INF, (1e-6, 0.1), 1e-5, "elongation at which it yields"),
    ),
    sign="a loop in T against elongation that stays open however slow",
    source="Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249; Prandtl, Z. Angew. Math. Mech. 8 (1928) 85",
    acts="line", built_in=True,
    causes=(
        Cause(
            "response", "hysteresis", ("hysteresis.stiffness", "hysteresis.yield"),
            consequence="k depends on amplitude, c stands for a loss that does not depend on frequency",
            advice="state k and the loss per cycle with the amplitude",
            separate="a slow loading loop between two tensions",
            pictures=("loop",), amount=lambda known: 0.01 * known["k"], shapes=shapes,
            limits=lambda known: {
                "hysteresis.yield": (0.01 * known["e"], 3 * known["e"]),
                "hysteresis.stiffness": (0.0, 3 * known["k"]),
            },
        ),
        Cause(
            "elongation", "hysteresis",
            (Size("hysteresis.width", "m", 0.0, 0.0, INF, 1e-6), choice("hysteresis.kind", 4)),
            title="Hysteresis loop",
            equation="x = … + h·mean(F − z)/F_max, z′ = F′ while |z| < F_y, F_y evenly up to F_max",
            sign="readings are larger when unloading, the most in the middle of the range and alike at its ends",
            consequence="k and E are those of the chord of the last loop: a smaller range is stiffer",
            advice="state k and E with the range of the loads and the width of the loop",
            separate="hold each load twice as long: creep opens the loop, hysteresis does not",
            pictures=("load",), needs=("unloading",), amount=lambda seen: seen.u, reading=reading,
        ),
    ),
)  # fmt: skip
