"""Law of propagation for E = k·L/(w·t) with the full budget: ours, suncal, GTC.

python benchmarks/law.py --peer-python PATH
"""

from __future__ import annotations

from side_by_side import Case, main

K, L, W, T = (24734.25, 335.52, 8), (2.990, 0.002), (0.025, 5e-5), (5e-5, 1e-6)


def ours() -> Case:
    from metrology import gum
    from metrology.gum.budget import budget
    from metrology.gum.law import propagate

    def work(_: int) -> str:
        k = gum.Input("k", K[0], (gum.Component("repeatability", gum.Normal(K[1]), K[2], "A"),))
        length = gum.Input("L", L[0], (gum.Component("tape", gum.Rectangular(L[1])),))
        w = gum.Input("w", W[0], (gum.Component("calliper", gum.Normal(W[1])),))
        t = gum.Input("t", T[0], (gum.Component("micrometer", gum.Normal(T[1])),))
        knowledge = gum.Knowledge({item.name: item for item in (k, length, w, t)})
        modulus = gum.Measurand("E", lambda q: q["k"] * q["L"] / (q["w"] * q["t"]), "Pa")
        law = propagate([modulus], knowledge)
        rows, coverage = budget(law, 0), law.coverage(0, 0.95)
        dof = law.dof(0)[0]
        return f"u = {law.u(0) / 1e9:.4f} GPa, ν = {dof or 0:.0f}, k = {coverage.k or 0:.3f}, {len(rows)} rows"

    return work


def suncal() -> Case:
    import suncal

    def work(_: int) -> str:
        model = suncal.Model("E = k*L/(w*t)")
        model.var("k").measure(K[0]).typeb(std=K[1], df=K[2])
        model.var("L").measure(L[0]).typeb(dist="uniform", a=L[1])
        model.var("w").measure(W[0]).typeb(std=W[1])
        model.var("t").measure(T[0]).typeb(std=T[1])
        found = model.calculate_gum()
        rows = found.proportions()["E"]
        u, dof = found.uncertainty["E"], found.degf["E"]
        k = found.expand("E", conf=0.95) / u
        return f"u = {u / 1e9:.4f} GPa, ν = {dof:.0f}, k = {k:.3f}, {len(rows)} rows"

    return work


def gtc() -> Case:
    import GTC

    def work(_: int) -> str:
        k = GTC.ureal(K[0], K[1], K[2], label="k")
        length = GTC.ureal(L[0], GTC.type_b.uniform(L[1]), label="L")
        w = GTC.ureal(W[0], W[1], label="w")
        t = GTC.ureal(T[0], T[1], label="t")
        modulus = k * length / (w * t)
        rows = GTC.reporting.budget(modulus)
        factor = GTC.reporting.k_factor(modulus.df, 95)
        return f"u = {modulus.u / 1e9:.4f} GPa, ν = {modulus.df:.0f}, k = {factor:.3f}, {len(rows)} rows"

    return work


if __name__ == "__main__":
    main(
        __file__,
        "Law of propagation for E = k·L/(w·t) with budget, degrees of freedom and coverage factor",
        {"metrology": ours, "suncal": suncal, "GTC": gtc},
        1,
        200,
    )
