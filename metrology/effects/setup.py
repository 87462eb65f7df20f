"""Mount and load cell give way with the line, without mass."""

from metrology.effect import INF, Cause, Effect, Parameter, Pulled, Size


def reading(seen: Pulled):
    """C·F in the crosshead."""
    return seen.crosshead * seen.force


EFFECT = Effect(
    name="setup",
    title="Compliance of the set-up in series, massless",
    equation="e = ε + C·T, so that k → k/(1 + C·k), c → c/(1 + C·k)²",
    parameters=(
        Parameter("setup.compliance", "C", "m/N", 0.0, 0.0, INF, (0.0, 1e-3), 1e-7,
                  "compliance of mount and load cell"),
    ),
    sign="stiffness lower than the line's own, most for the stiffest line",
    source="ASTM E111-17, 9 (compliance of the machine); springs in series",
    acts="line", built_in=True,
    causes=(
        Cause(
            "response", "setup", ("setup.compliance",),
            consequence="k comes out too small by the factor 1/(1 + C·k), E with it, c by its square",
            advice="measure elongation at the specimen, or the compliance of mount and cell with a stiff bar",
            separate="an indicator on the mount under a dead load, or a second line of known, different stiffness",
            pictures=("force-elongation",), amount=lambda known: 0.01 / max(known["k"], 1.0), exact=True,
        ),
        Cause(
            "decay", "setup", (Size("setup.compliance", "m/N", 0.0, 0.0, INF, 1e-7),),
            title="Compliance of the set-up in series",
            equation="1/k_seen = 1/k + C",
            sign="none in these records: exactly a lower k and another c",
            consequence="k_dyn comes out too small by 1/(1 + C·k), c by its square",
            advice="aim the vibrometer at the specimen's both ends",
            separate="a second vibrometer on the frame, or the same sample on a frame of known, different stiffness",
            pictures=("force-elongation",), alone="alone it is exactly a lower k",
        ),
        Cause(
            "tension", "setup", (Size("setup.compliance", "m/N", 0.0, 0.0, INF, 1e-9, own=True),),
            title="Compliance of grips, cell and frame, of each mounting",
            equation="x = L·ε + C·F",
            sign="the crosshead moves by more than the specimen stretches, in proportion to the load",
            consequence="k and E by the crosshead come out too small by 1/(1 + C·k); by the extensometer they stand",
            advice="use the extensometer, or take C off; state it with its scatter between mountings",
            separate="a stiff bar of known section in the same grips",
            pictures=("load",), needs=("tether",), amount=lambda seen: 0.1 * seen.slope, reading=reading, defined=True,
            law="set-up",
        ),
        Cause(
            "tension", "constant setup", (Size("setup.constant", "m/N", 0.0, 0.0, INF, 1e-9),),
            title="Compliance of grips, cell and frame, the same in every mounting",
            equation="x = L·ε + C·F",
            sign="the crosshead moves by more than the specimen stretches, in proportion to the load, each time alike",
            consequence="k and E by the crosshead come out too small by 1/(1 + C·k); by the extensometer they stand",
            advice="use the extensometer, or take C off",
            separate="a stiff bar of known section in the same grips; specimens of two lengths",
            pictures=("load",), needs=("tether", "repeats"), amount=lambda seen: 0.1 * seen.slope, reading=reading,
            defined=True, law="set-up",
        ),
    ),
)  # fmt: skip
