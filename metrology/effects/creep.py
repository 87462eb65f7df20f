"""Readings that grow under a load that stays."""

import numpy as np

from metrology.effect import INF, Cause, Effect, Pulled, Readings, Size, choice


def reading(seen: Readings, kind: float):
    """Σ ΔF_i·ln(1 + t − t_i), one reading to the next being a unit of time; or F·ln(1 + j).

    Boltzmann's superposition with a logarithmic compliance: every change of load goes on creeping; the reading comes
    one unit after the load.
    """
    if round(kind) == 1:
        return seen.force * np.log1p(seen.order)
    found = np.zeros(len(seen.force))
    for repeat in np.unique(seen.repeat):
        rows = np.flatnonzero(seen.repeat == repeat)
        steps = np.diff(seen.force[rows], prepend=0.0)
        t = np.arange(len(rows), dtype=float)
        found[rows] = np.log1p(np.maximum(t[:, None] - t[None, :] + 1, 0.0)) @ steps
    return found


def pulled(seen: Pulled, time: float):
    """Σ ΔF_i·ln(1 + (t − t_i)/τ) in both readings, less the line through it over F: k is that at the rate of the test."""
    found = np.zeros(len(seen.force))
    for channel in (0.0, 1.0):
        rows = np.flatnonzero(seen.crosshead == channel)
        t = seen.time[rows]
        steps = np.diff(seen.force[rows], prepend=0.0)
        crept = np.log1p(np.maximum(t[:, None] - t[None, :], 0.0) / time) @ steps
        if len(rows) > 2:
            line = np.column_stack([np.ones(len(rows)), seen.force[rows]])
            found[rows] = crept - line @ np.linalg.lstsq(line, crept, rcond=None)[0]
    return found


EFFECT = Effect(
    name="creep",
    title="Creep under load",
    equation="x = … + a·Σ ΔF_i·ln(1 + t − t_i), time in readings; or a·F·ln(1 + j)",
    sign="readings grow under a load that stays, and lag behind one that is taken off; the more the larger the load",
    source="Findley, Lai & Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials (1976), 5",
    acts="line",
    causes=(
        Cause(
            "elongation", "creep", (Size("creep.rate", "m/N", 0.0, 0.0, INF, 1e-7), choice("creep.kind", 2)),
            consequence="k and E come out too small, by the creep up to the reading; more so where loading goes up "
            "only",
            advice="wait the same time at each load; state the time with k",
            separate="hold the largest load for an hour and read every minute",
            pictures=("order",), amount=lambda seen: seen.u / seen.most, reading=reading,
        ),
        Cause(
            "tension", "creep",
            (Size("creep.rate", "m/N", 0.0, 0.0, INF, 1e-9), Size("creep.time", "s", 1.0, 1e-6, 1e9, 0.1, True)),
            title="Creep of the specimen under load",
            equation="ε = … + a/L·Σ ΔF_i·ln(1 + (t − t_i)/τ), less its line over F",
            sign="the specimen goes on stretching as time passes, the more the larger the load",
            consequence="k and E belong to the rate of this test; a slower one gives less",
            advice="state the rate with k and E; test at the rate of use",
            separate="hold the load at the end of the range and record; pull at a tenth of the rate",
            pictures=("order",), needs=("motion",), amount=lambda seen: seen.u / seen.most,
            shapes=lambda seen, _: [{"creep.time": part * float(np.ptp(seen.time))} for part in (0.03, 0.3, 3.0)],
            limits=lambda seen: {"creep.time": (1e-3 * float(np.ptp(seen.time)), 10 * float(np.ptp(seen.time)))},
            reading=pulled, law="stiffness",
        ),
    ),
)  # fmt: skip
