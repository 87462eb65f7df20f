"""Readings that grow under a load that stays."""

import math
from collections.abc import Callable

import numpy as np

from metrology.effect import INF, Array, Cause, Effect, Pulled, Readings, Size, choice

LAWS = (np.log1p, None, np.cbrt, lambda t: -np.expm1(-t / 3.0))
"""Compliance over the time since a load was changed, a reading the unit: logarithmic; growing with the order instead;
Andrade's cube root (Proc. R. Soc. A 84 (1910) 1); an element of Kelvin and Voigt. Without either of the last two the
planted creep of `tests/diagnostics/test_supported.py` is outside of the interval."""


COURSES = (np.log1p, lambda t: -np.expm1(-t))
"""Compliance over the time since a load was changed, over τ: many relaxation times evenly, or one (Kelvin, Voigt).
Without the second, the planted creep of `tests/diagnostics/test_tension.py` is heating and memory as well."""
NODES = 28
"""Times, at Chebyshev's nodes of their logarithm, between which the superposition is interpolated: to 1e-10 of it, as
ln(1 + t/τ) has its nearest singularity at an imaginary part of π (Trefethen, Approximation Theory (2013), 8); of the
other course to 1e-5."""


def reading(seen: Readings, kind: float):
    """Σ ΔF_i·J(t − t_i), or F·ln(1 + j): what a load is followed by at the readings after it.

    Boltzmann's superposition: every change of load goes on creeping; the reading comes one unit after the load. The
    readings begin there: how much came before is what the law says, and laws that describe the readings alike differ
    in it by as much again. That is why there are several, and why each counts.
    """
    law = LAWS[round(kind)]
    if law is None:
        return seen.force * np.log1p(seen.order)
    found = np.zeros(len(seen.force))
    for repeat in np.unique(seen.repeat):
        rows = np.flatnonzero(seen.repeat == repeat)
        steps = np.diff(seen.force[rows], prepend=0.0)
        t = np.arange(len(rows), dtype=float)
        found[rows] = law(np.maximum(t[:, None] - t[None, :] + 1, 0.0)) @ steps
    return found


def superposed(seen: Pulled, time: float, course: float):
    """Σ ΔF_i·J((t − t_i)/τ) in both readings, by the whole history of the force."""
    least, most = limits(seen)["creep.time"]
    law = COURSES[round(course)]
    if not least <= time <= most:
        return _sum(seen, time, law)
    nodes = np.cos(math.pi * (np.arange(NODES) + 0.5) / NODES)
    name = f"creep {round(course)}"
    if name not in seen.kept:
        seen.kept[name] = np.array([_sum(seen, math.sqrt(least * most) * (most / least) ** (node / 2), law)
                                    for node in nodes])  # fmt: skip
    off = math.log(time**2 / (least * most)) / math.log(most / least) - nodes
    if not off.all():
        return seen.kept[name][np.flatnonzero(off == 0)[0]]
    weights = (-1.0) ** np.arange(NODES) * np.sqrt(1 - nodes**2) / off
    return weights @ seen.kept[name] / weights.sum()


def _sum(seen: Pulled, time: float, law: Callable[[Array], Array]):
    force, at = seen.history
    stamps, places = np.unique(seen.time, return_inverse=True)
    since = np.maximum(stamps[:, None] - at[None, :], 0.0)
    return (law(since / time) @ np.diff(force, prepend=0.0))[places]


def limits(seen: Pulled) -> dict[str, tuple[float, float]]:
    """Times within what a test shows."""
    return {"creep.time": (1e-3 * seen.duration, seen.duration)}


EFFECT = Effect(
    name="creep",
    title="Creep under load",
    equation="x = … + a·Σ ΔF_i·J(t − t_i), J = ln(1 + t), t^(1/3) or 1 − exp(−t/3), time in readings; or a·F·ln(1 + j)",
    sign="readings grow under a load that stays, and lag behind one that is taken off; the more the larger the load",
    source="Findley, Lai & Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials (1976), 5",
    acts="line",
    causes=(
        Cause(
            "elongation", "creep",
            (Size("creep.rate", "m/N", 0.0, 0.0, INF, 1e-7), choice("creep.kind", len(LAWS), extrapolated=True)),
            consequence="k and E come out too small, by the creep up to the reading; more so where loading goes up "
            "only",
            advice="wait the same time at each load; state the time with k",
            separate="hold the largest load for an hour and read every minute",
            pictures=("order",), amount=lambda seen: seen.u / seen.most, reading=reading,
        ),
        Cause(
            "tension", "creep",
            (Size("creep.rate", "m/N", 0.0, 0.0, INF, 1e-9),
             Size("creep.time", "s", 1.0, 1e-9, 1e12, 1.0, True, apart=3), choice("creep.course", len(COURSES))),
            title="Creep of the specimen under load",
            equation="ε = … + a/L·Σ ΔF_i·J((t − t_i)/τ), J(t) = ln(1 + t) or 1 − exp(−t)",
            sign="the specimen goes on stretching as time passes, the more the larger the load",
            consequence="k and E belong to the rate of this test; a slower one gives less",
            advice="state the rate with k and E; test at the rate of use",
            separate="hold the load at the end of the range and record; pull at a tenth of the rate",
            pictures=("order",), needs=("unloading", "time"), amount=lambda seen: seen.u / seen.most,
            shapes=lambda seen, _: [{"creep.time": part * seen.duration, "creep.course": float(course)}
                                    for course in range(len(COURSES)) for part in (0.003, 0.03, 0.3)],
            limits=limits, reading=superposed,
        ),
    ),
)  # fmt: skip
