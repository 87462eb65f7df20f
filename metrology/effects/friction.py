"""Dry friction, with sticking: its switching stands in the equation of motion itself."""

from metrology.effect import INF, Cause, Effect, Parameter, Size

EFFECT = Effect(
    name="friction",
    title="Coulomb friction with stiction",
    equation="F = −F_c·(sign(v) + β) when sliding; v = 0 while |net force| ≤ σ·F_c·(1 ± β)",
    parameters=(
        Parameter("friction.force", "F_c", "N", 0.0, 0.0, INF, (0.0, 0.5), 1e-3, "friction when sliding"),
        Parameter("friction.static_ratio", "σ", "1", 1.0, 1.0, INF, (1.0, 2.0), 0.05,
                  "largest sticking over sliding force"),
        Parameter("friction.bias", "β", "1", 0.0, -1.0, 1.0, (-0.5, 0.5), 0.05,
                  "share by which it is larger for v > 0"),
    ),
    sign="amplitude falls by the same amount each half period, then the module sticks",
    source="Den Hartog, Trans. ASME 53 (1931) 107",
    built_in=True,
    causes=(
        Cause(
            "response", "friction", ("friction.force",),
            consequence="c comes out too large, the more so the smaller the amplitude; k hardly changes",
            advice="level and clean the table, check the air supply; subtract F_c from the thrust",
            separate="a coast run with the line slack: the speed falls in proportion to time; "
            "or a tilt of a known angle",
            pictures=("force-velocity",), amount=lambda known: 0.005 * known["force"],
        ),
        Cause(
            "decay", "friction", (Size("friction.force", "N", 0.0, 0.0, INF, 1e-4),),
            title="Dry (Coulomb) friction",
            equation="m·x″ + c·x′ + k·x = −F_c·sign(x′)",
            sign="the decay rate grows as the amplitude falls, in proportion to its inverse; the plate stops off its "
            "zero",
            consequence="ζ and c come out too large, c by 4·F_c/(π·ω·A), more so the smaller the amplitude A; "
            "k hardly changes",
            advice="let the plate hang free of guides and cables, and evaluate the first periods",
            separate="releases from half and from twice the amplitude: the rate times the amplitude stays the same",
            pictures=("rate",), amount=lambda known: 1e-4 * known["k"] * known["e"],
        ),
    ),
)  # fmt: skip
