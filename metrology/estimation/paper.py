"""The paper's way: the stiffness and damping with the least RMS difference, nothing else let free."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from metrology.estimation.inspection import without_saturation
from metrology.estimation.measured import MeasuredRun
from metrology.estimation.priors import lay_out
from metrology.estimation.problem import Array, Point, Problem, evaluate, slope
from metrology.estimation.response import View, problem, values_of
from metrology.estimation.search import starts
from metrology.estimation.solver import solve
from metrology.message import said
from metrology.rig import Rig, simulate

PAPER_CHANNELS = ("x", "T")
"""What the paper compares: the length of the line from the motion capture, and the force of the load cell."""

GRID = ((0.02, 13), (0.015, 7))
"""Half width, as a share, and points of the grid around the optimum of the derivatives, for k and c."""
CELL = tuple(2 * width / (count - 1) for width, count in GRID)
BASINS = 5
"""Points of the grid, the lowest ones apart from each other, from which a simplex descends."""
CLOSE = 1e-5
"""Size of the simplex, as a share of k and c, at which it has converged."""
JACKKNIFE = 3
"""Fewest runs that leave a scatter behind when each of them is left out in turn."""


@dataclass(frozen=True)
class PaperWay:
    """Result of the paper's way.

    Parameters
    ----------
    status : {'ok', 'failed'}
        And a `sentence`.
    k, c : float
        Stiffness / (N/m) and damping / (N·s/m); NaN when failed.
    rms : mapping of str to float
        RMS difference by channel over all runs, in the unit of the channel.
    objective : float
        What was minimised: the root of the mean over runs and channels of (RMS/range)².
    k_u, c_u : float or None
        Standard uncertainties by the jackknife over the runs; None for fewer than three.
    """

    status: Literal["ok", "failed"]
    sentence: str
    k: float
    c: float
    rms: dict[str, float]
    objective: float
    k_u: float | None = None
    c_u: float | None = None


def paper_way(
    rig: Rig,
    runs: Sequence[MeasuredRun],
    *,
    channels: Sequence[str] = PAPER_CHANNELS,
    start: tuple[float, float] | None = None,
) -> PaperWay:
    """Stiffness and damping by least RMS difference, the stated inputs taken as exact.

    Minimises Σ over runs and channels of (RMS difference / range of the readings)² over k and c: every reading weighs
    the same within a channel, every channel the same. This is the reading given here to "the RMS discrepancy between
    the model output and the measured ones" (paper, IV.C), which does not say how metres and newtons were put together.

    The sum has kinks, and many small minima, where a contact passes a reading. Derivatives only find the neighbourhood;
    there the lowest points of a grid are followed down by simplexes (Nelder & Mead 1965), and the lowest end is taken.

    Parameters
    ----------
    rig : Rig
        As stated.
    runs : sequence of MeasuredRun
        Those with the purpose 'identification' are used.
    channels : sequence of str
        Those that are compared, where measured.
    start : (float, float), optional
        Stiffness / (N/m) and damping / (N·s/m) where the search begins, such as those of a weighted fit; from the
        stated ones and several others unless given.

    Returns
    -------
    PaperWay
        k in N/m, c in N·s/m and the RMS differences by channel; a sentence alone where nothing was found.
    """
    chosen = [_weighted(without_saturation(one)[0], channels) for one in runs if one.purpose == "identification"]
    chosen = [one for one in chosen if any(name in channels for name in one.channels)]
    if not chosen:
        return _nothing(said("no run has a channel to compare"))
    layout = lay_out(rig, [one.name for one in chosen], ("k", "c"), ())
    use = [{name: one.used(name) & (name in channels) for name in one.channels} for one in chosen]
    posed = problem(rig, chosen, layout, use, View())
    begins = [np.array(start)] if start else starts(rig, layout)
    near = [found.point for one in begins if (found := solve(posed, one, steps=30, enough=1e-4)).point is not None]
    if not near:
        text = "no stiffness and damping were found: the motion cannot be followed from the stated values"
        return _nothing(said(text))
    lowest, evaluations, converged = _lowest(posed, min(near, key=lambda point: point.cost).theta)
    if not converged:
        return _nothing(said("not converged within {count} evaluations of the sum", count=evaluations))
    terms = len({(one.name, name) for one in chosen for name in one.channels if name in channels})
    rms = _rms(rig.with_values(values_of(layout, 0, lowest.theta)), chosen, channels)
    k, c = (float(value) for value in lowest.theta)
    words = "converged: the lowest of the small minima in {count} evaluations of the sum"
    return PaperWay(
        "ok", said(words, count=evaluations), k, c, rms, math.sqrt(lowest.cost / terms), *_jackknife(posed, lowest)
    )


def _jackknife(posed: Problem, lowest: Point) -> tuple[float | None, float | None]:
    """Standard uncertainties by leaving out one run at a time, u² = (n − 1)/n·Σ(θ_i − θ̄)².

    Efron, The Jackknife, the Bootstrap and Other Resampling Plans (1982), 3; each θ_i by one Gauss–Newton step from the
    lowest point, over whose kinks the runs move it by more than from one of them to the next.
    """
    count = len(posed.blocks)
    there = slope(posed, lowest) if count >= JACKKNIFE else None
    if there is None:
        return None, None
    grams = np.array([part.T @ part for part in there.blocks])
    pulls = np.array([part.T @ left for part, left in zip(there.blocks, lowest.residuals, strict=True)])
    try:
        steps = np.linalg.solve(grams.sum(axis=0) - grams, (pulls - pulls.sum(axis=0))[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        return None, None
    k_u, c_u = np.sqrt((count - 1) * steps.var(axis=0))
    return float(k_u), float(c_u)


def _nothing(sentence: str) -> PaperWay:
    return PaperWay("failed", sentence, math.nan, math.nan, {}, math.nan)


def _lowest(posed: Problem, centre: Array) -> tuple[Point, int, bool]:
    """Lowest point near `centre`: grid, then simplexes; evaluations, and whether the one that won has converged."""
    from scipy.optimize import minimize

    # On a lattice that does not move with the start, so that starts close by end at the same place.
    steps = np.log1p(CELL)
    centre = np.exp(steps * np.round(np.log(np.maximum(centre, 1e-12)) / steps))
    seen: dict[tuple[float, float], Point] = {}

    def cost(factors: Any) -> float:
        point = evaluate(posed, np.clip(centre * np.asarray(factors), posed.low, posed.high))
        if point is None:
            return math.inf
        seen[float(factors[0]), float(factors[1])] = point
        return point.cost

    axes = [1 + width * np.linspace(-1, 1, count) for width, count in GRID]
    grid = sorted((cost([on_k, on_c]), float(on_k), float(on_c)) for on_k in axes[0] for on_c in axes[1])
    ends = []
    for _, on_k, on_c in _apart(grid)[:BASINS]:
        corner = np.array([on_k, on_c])
        simplex = corner + np.array([[0.0, 0.0], [0.4 * CELL[0], 0.0], [0.0, 0.4 * CELL[1]]])
        options: Any = {"initial_simplex": simplex, "xatol": CLOSE, "fatol": math.inf, "maxfev": 300}
        ends.append(minimize(cost, corner, method="Nelder-Mead", options=options))
    best = min(seen.values(), key=lambda point: point.cost)
    return best, len(seen), bool(min(ends, key=lambda end: float(end.fun)).success)


def _apart(grid: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    """Points of a grid, lowest first, without those beside a lower one."""
    kept: list[tuple[float, float, float]] = []
    for cost, on_k, on_c in grid:
        if all(max(abs(on_k - k) / CELL[0], abs(on_c - c) / CELL[1]) > 1.5 for _, k, c in kept):
            kept.append((cost, on_k, on_c))
    return kept


def _weighted(measured: MeasuredRun, channels: Sequence[str]) -> MeasuredRun:
    """Return the run with weights 1/(range·√n) in place of the noise."""
    noise = {}
    for name in measured.channels:
        readings = measured.readings(name)[measured.used(name)]
        spread = float(np.ptp(readings)) or 1.0
        noise[name] = spread * math.sqrt(len(readings)) if name in channels else measured.noise[name]
    return replace(measured, noise=noise)


def _rms(rig: Rig, runs: Sequence[MeasuredRun], channels: Sequence[str]) -> dict[str, float]:
    squares: dict[str, list[float]] = {}
    for measured in runs:
        moved = simulate(rig, measured.run)
        for name in measured.channels:
            if name in channels:
                used = measured.used(name)
                difference = measured.readings(name)[used] - getattr(moved, name)[used]
                squares.setdefault(name, []).extend((difference**2).tolist())
    return {name: math.sqrt(float(np.mean(values))) for name, values in squares.items()}
