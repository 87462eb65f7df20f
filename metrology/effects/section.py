"""A specimen that loses a part of its section: a yarn, a ply or a wire of it breaks."""

from metrology.effect import Cause, Effect, Pulled, Size, choice


def reading(seen: Pulled, place: float):
    """(dx/dF)·F in both readings, from one instant of one mounting on."""
    return seen.slope * seen.force * seen.after(place)


EFFECT = Effect(
    name="section",
    title="Specimen that loses a part of its section",
    equation="ε = F/EA + δ·ε₀ from one instant on, ε₀ by the test's line; δ is about the part lost over the part left",
    sign="one step of the stretch and more slope after it, by crosshead and extensometer alike",
    source="A. R. Bunsell & J. Renard, Fundamentals of Fibre Reinforced Composite Materials (2005): breaks of bundles",
    acts="line",
    causes=(
        Cause(
            "tension", "lost section", (Size("section.lost", "1", 0.0, 0.0, 1.0, 1e-4), choice("section.place", 1)),
            consequence="k and E are means over what was whole and what is left; the strength is that of the rest",
            advice="end the range before the step, or leave the specimen out with this reason",
            separate="look for what broke; unload, and pull again: the first slope does not come back",
            pictures=("order",), amount=lambda seen: seen.u / (abs(seen.slope) * seen.most),
            shapes=lambda seen, _: [{"section.place": float(at)} for at in seen.places],
            limits=lambda seen: {"section.place": (-0.5, len(seen.places) - 0.5)}, reading=reading,
        ),
    ),
)  # fmt: skip
