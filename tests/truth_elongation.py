"""What truly happens to a sample under dead loads, for tests: own equations, and how an indicator is read.

Shares no code with `metrology`. A `Stretched` holds sample and set-up, `readings` one test as rows (repeat, direction,
load, reading in m), in time: every reading takes a minute, and creep goes on while the load hangs. SI throughout.
`distance` tells by how many standard deviations an effect moves the readings, slope and zeros taken out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

GRAVITY = 9.8065


@dataclass(frozen=True)
class Stretched:
    """Sample, frame, indicator.

    `creep` / 1: part of the extension that comes with ln(1 + t/min) after each load; `slip` / m at reading `where`;
    `toe` / m of slack that is pulled straight, gone as exp(−F/F₀), F₀ a sixth of the largest load; `curvature` /
    (1/N): x = F/k·(1 + curvature·F); `knee` / m at the largest load: from 0.55 of it on; `yields` / m:
    the same of the highest load so far in a repeat; `backlash` / m; `compliance` / (m/N) of
    the frame; `drift` / (m/min);
    `parting` / N, initial tension of a close-wound spring, whose coils part one after the other over a third of it;
    `misread` / m at reading `where`; `mounting` / (m/N): compliance that goes with a sine of the repeat's number. In
    nobody's table: `screw` / m, periodic error of the screw, 0.5 mm a turn; `gain` / 1, step of the indicator's scale
    from the third repeat on; `swapped`: two loads hung in each other's place in one repeat, with their difference in
    part; `sway` / m: goes with the load squared, every other repeat; `lag` / m by which a spindle stays behind, on the
    way up and down, from half of the largest load on, in the first and third repeat; `swing` / m: a sine of the order,
    0.8 of the test long.
    """

    k: float = 24734.25
    masses: tuple[float, ...] = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5)
    repeats: int = 4
    scatter: float = 3e-6
    division: float = 1e-6
    indicator: float = 1e-6
    zero: float = 2e-5
    mass_u: float = 2e-5
    where: int = 7
    unloads: bool = True
    creep: float = 0.0
    slip: float = 0.0
    toe: float = 0.0
    curvature: float = 0.0
    backlash: float = 0.0
    parting: float = 0.0
    knee: float = 0.0
    yields: float = 0.0
    compliance: float = 0.0
    drift: float = 0.0
    misread: float = 0.0
    mounting: float = 0.0
    screw: float = 0.0
    gain: float = 0.0
    swapped: float = 0.0
    sway: float = 0.0
    lag: float = 0.0
    swing: float = 0.0


EFFECTS = ("creep", "slip", "toe", "curvature", "backlash", "drift", "misread", "mounting")
UNKNOWN = ("screw", "gain", "swapped", "sway", "lag")
MATERIALS = {
    "al-1100": Stretched(),
    "peek": Stretched(k=1810.91, masses=(0.125, 0.25, 0.375, 0.5, 0.625, 0.75), scatter=6e-6),
    "nylon": Stretched(k=167.64, masses=(0.02, 0.05, 0.1, 0.15, 0.2), repeats=5, scatter=2e-5, division=1e-5),
    "spectra": Stretched(k=753.33, masses=(0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6), repeats=3, scatter=1e-5, division=2e-6),
}
SPRING = {
    "k": 193.0, "masses": tuple(0.0113 * at for at in range(1, 41)), "repeats": 1, "scatter": 1.5e-4, "division": 5e-4,
    "unloads": False,
}  # fmt: skip
"""A spring on which weights are added one by one, each read once on a ruler: what differs from the first material."""


def _order(one: Stretched) -> list[tuple[int, str, int]]:
    up = list(range(len(one.masses)))
    return [
        (repeat, direction, at)
        for repeat in range(one.repeats)
        for direction, loads in (("loading", up), ("unloading", up[::-1] if one.unloads else []))
        for at in loads
    ]


def exact(one: Stretched) -> np.ndarray:
    """Extensions at all readings without noise, zero and error of indication."""
    rows = _order(one)
    force = np.array(one.masses) * GRAVITY
    most = force[-1]
    hung = np.array([force[at] for _, _, at in rows])
    if one.swapped:
        cycle = 2 * len(force)
        first = cycle + 1
        hung[first], hung[first + 1] = (
            hung[first] + one.swapped * (hung[first + 1] - hung[first]),
            hung[first + 1] + one.swapped * (hung[first] - hung[first + 1]),
        )
    width = one.parting / 3
    pulled = width * np.logaddexp(0.0, (hung - one.parting) / width) if width else hung
    x = pulled / one.k * (1 + one.curvature * hung) + one.compliance * hung
    x = x + one.toe * (1 - np.exp(-6 * hung / most))
    anew = np.array([repeat for repeat, _, _ in rows])
    highest = np.concatenate([np.maximum.accumulate(hung[anew == repeat]) for repeat in np.unique(anew)])
    x = x + one.knee * np.maximum(hung / most - 0.55, 0.0) / 0.45
    x = x + one.yields * np.maximum(highest / most - 0.55, 0.0) / 0.45
    x = x + one.swing * np.sin(2 * np.pi * np.arange(len(rows)) / (0.8 * len(rows)))
    crept = np.zeros(len(rows))
    for at, (repeat, _, _) in enumerate(rows):
        begin = next(i for i, row in enumerate(rows) if row[0] == repeat)
        steps = np.diff(hung[begin : at + 1], prepend=0.0)
        since = 1.0 + np.arange(len(steps))[::-1]
        crept[at] = (steps * np.log1p(since)).sum() / one.k
    x = x + one.creep * crept
    back = np.array([direction == "unloading" for _, direction, _ in rows])
    x = x + one.backlash * back + one.drift * np.arange(len(rows))
    x[one.where + 1 :] += one.slip
    x[one.where] += one.misread
    x = x + one.screw * np.sin(2 * np.pi * x / 0.5e-3)
    number = np.array([row[0] for row in rows])
    x = x + one.mounting * hung * np.sin(2.0 * number + 1.0)
    x = np.where(number >= 2, (1 + one.gain) * x, x)
    late = np.where(back, 1.0, -1.0) * (hung >= 0.5 * most) * np.sqrt(hung / most) * np.isin(number, (0, 2))
    x = x + one.lag * late
    return x + one.sway * np.where(number % 2 == 0, 1, -1) * (hung / most) ** 2


def readings(one: Stretched, rng: np.random.Generator) -> list[tuple[str, str, str, float]]:
    """Rows (load, repeat, direction, reading)."""
    rows, x = _order(one), exact(one)
    wrong = one.indicator * rng.standard_normal(len(one.masses))
    hung = one.mass_u * rng.standard_normal(len(one.masses)) * GRAVITY / one.k
    zeros = one.zero * rng.standard_normal(one.repeats)
    found = []
    for (repeat, direction, at), value in zip(rows, x, strict=True):
        seen = 5e-4 + value + wrong[at] + hung[at] + zeros[repeat] + one.scatter * rng.standard_normal()
        found.append((f"m{at}", str(repeat + 1), direction, float(np.round(seen / one.division) * one.division)))
    return found


def distance(name: str, one: Stretched, size: float) -> float:
    """Standard deviations by which an effect moves the readings, slope, zeros and indication taken out."""
    moved = exact(replace(one, **{name: size})) - exact(one)
    rows = _order(one)
    force = np.array([one.masses[at] * GRAVITY for _, _, at in rows])
    number = np.array([row[0] for row in rows])
    load = np.array([row[2] for row in rows])
    sigma = np.hypot(one.scatter, one.division / np.sqrt(12))
    known = np.hypot(one.indicator, one.mass_u * GRAVITY / one.k)
    columns = np.column_stack([force, *(number == at for at in range(one.repeats))]).astype(float)
    V = sigma**2 * np.eye(len(rows)) + known**2 * (load[:, None] == load[None, :])
    root = np.linalg.cholesky(np.linalg.inv(V)).T
    q = np.linalg.qr(root @ (columns / np.linalg.norm(columns, axis=0)))[0]
    left = root @ moved
    left = left - q @ (q.T @ left)
    return float(np.linalg.norm(left))
