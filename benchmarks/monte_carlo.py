"""A million Monte Carlo draws of E = k·L/(w·t) with the 95 % interval: ours, plain NumPy, suncal.

Ours returns both intervals, the scatter between blocks, the verdict of clause 8 and a histogram with them; plain NumPy
and suncal return the symmetric interval, mean and u.

    python benchmarks/monte_carlo.py --peer-python PATH
"""

from __future__ import annotations

from side_by_side import Case, main

K, L, W, T = (24734.25, 335.52), (2.990, 0.002), (0.025, 5e-5), (5e-5, 1e-6)


def ours() -> Case:
    from metrology import gum
    from metrology.gum.engine import simulate
    from metrology.gum.law import propagate
    from metrology.gum.monte_carlo import Plan

    def one(name: str, value: float, distribution: gum.Distribution) -> gum.Input:
        return gum.Input(name, value, (gum.Component("source", distribution),))

    inputs = (
        one("k", K[0], gum.Normal(K[1])),
        one("L", L[0], gum.Rectangular(L[1])),
        one("w", W[0], gum.Normal(W[1])),
        one("t", T[0], gum.Normal(T[1])),
    )
    knowledge = gum.Knowledge({item.name: item for item in inputs})
    modulus = gum.Measurand("E", lambda q: q["k"] * q["L"] / (q["w"] * q["t"]), "Pa")

    def work(trials: int) -> str:
        law = propagate([modulus], knowledge)
        ((found, _),) = simulate(law, knowledge, Plan(0.95, 1, max_trials=trials, adaptive=False))
        return f"[{found.low / 1e9:.2f}, {found.high / 1e9:.2f}] GPa of {found.trials} trials"

    return work


def plain() -> Case:
    import numpy as np

    def work(trials: int) -> str:
        generator = np.random.default_rng(1)
        k = generator.normal(*K, trials)
        length = generator.uniform(L[0] - L[1], L[0] + L[1], trials)
        w = generator.normal(*W, trials)
        t = generator.normal(*T, trials)
        modulus = k * length / (w * t)
        modulus.mean(), modulus.std(ddof=1)
        low, high = np.percentile(modulus, [2.5, 97.5])
        return f"[{low / 1e9:.2f}, {high / 1e9:.2f}] GPa of {trials} trials"

    return work


def suncal() -> Case:
    import suncal

    def work(trials: int) -> str:
        model = suncal.Model("E = k*L/(w*t)")
        model.var("k").measure(K[0]).typeb(std=K[1])
        model.var("L").measure(L[0]).typeb(dist="uniform", a=L[1])
        model.var("w").measure(W[0]).typeb(std=W[1])
        model.var("t").measure(T[0]).typeb(std=T[1])
        found = model.monte_carlo(samples=trials).expand("E", conf=0.95)
        return f"[{found.low / 1e9:.2f}, {found.high / 1e9:.2f}] GPa of {trials} trials"

    return work


if __name__ == "__main__":
    main(
        __file__,
        "10⁶ Monte Carlo draws of E = k·L/(w·t) with its 95 % interval",
        {"metrology": ours, "numpy": plain, "suncal": suncal},
        1_000_000,
    )
