"""Memory of the highest tension: a line that remembers how far it was pulled, until it is pulled further."""

from metrology.effect import INF, Cause, Effect, Pulled, Size, choice


def reading(seen: Pulled, kind: float):
    """F_m, which stays when the force falls (bedding-in); or F·(F_m − F)/F_max, softer below F_m (Mullins)."""
    highest = seen.highest
    return highest if round(kind) == 0 else seen.force * (highest - seen.force) / seen.most


EFFECT = Effect(
    name="memory",
    title="Memory of the highest tension",
    equation="ε = … + a/L·F_m; or a/L·F·(F_m − F)/F_max, F_m the highest force so far",
    sign="the first loading to a new highest force takes another way than every later one below it",
    source="Diani, Fayolle & Gilormini, Eur. Polym. J. 45 (2009) 601 (Mullins); ISO 18692-1:2018 (bedding-in of ropes)",
    acts="line",
    causes=(
        Cause(
            "tension", "memory", (Size("memory.amount", "m/N", 0.0, 0.0, INF, 1e-9), choice("memory.kind", 2)),
            title="Memory of the highest tension: bedding-in of a rope, or Mullins softening",
            consequence="k of a first loading is another one than k of every later loading below the highest force; "
            "k and E are those after bedding-in",
            advice="state the highest tension before the test; bed the line in, and state k with mean load and "
            "amplitude",
            separate="cycles to one load, then to a higher one: what depends on time alone shows in every cycle",
            pictures=("load",), needs=("unloading",), amount=lambda seen: seen.u / seen.most, reading=reading,
        ),
    ),
)  # fmt: skip
