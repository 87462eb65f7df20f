"""A specimen that is stiffer the faster it is pulled."""

from metrology.effect import Cause, Effect, Pulled, Size


def reading(seen: Pulled):
    """−(dx/dF)·F·ln(Ḟ/Ḟ₀) in both readings, Ḟ₀ the geometric mean of the rates."""
    return -seen.slope * seen.force * seen.rate


EFFECT = Effect(
    name="rate",
    title="Stiffness that depends on the rate",
    equation="ε = F/EA·(1 − b·ln(Ḟ/Ḟ₀)), Ḟ₀ the geometric mean of the rates of the specimens",
    sign="specimens that were pulled faster stretch less, by crosshead and extensometer alike",
    source="Ward & Sweeney, Mechanical Properties of Solid Polymers (3rd ed., 2013), 7: power law of the strain rate",
    acts="line",
    causes=(
        Cause(
            "tension", "rate effect", (Size("rate.exponent", "1", 0.0, 0.0, 1.0, 1e-3),),
            consequence="k and E are means over the rates; each belongs to a rate of its own",
            advice="state the rate with k and E; test at the rate of use",
            separate="specimens from the same place at rates that differ by ten and more, in an order drawn by lot",
            pictures=("load",), needs=("rates", "time"), amount=lambda seen: seen.u / (abs(seen.slope) * seen.most),
            reading=reading,
        ),
    ),
)  # fmt: skip
