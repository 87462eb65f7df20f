"""The paper's way: the stiffness and damping with the least RMS difference, nothing else let free."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from metrology.identify.inspection import without_saturation
from metrology.identify.measured import MeasuredRun
from metrology.identify.priors import lay_out
from metrology.identify.response import View, problem, values_of
from metrology.identify.search import starts
from metrology.identify.solver import Solution, solve
from metrology.rig import Rig

PAPER_CHANNELS = ("x", "T")
"""What the paper compares: the length of the line from the motion capture, and the force of the load cell."""


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
    """

    status: Literal["ok", "failed"]
    sentence: str
    k: float
    c: float
    rms: dict[str, float]
    objective: float


def paper_way(rig: Rig, runs: Sequence[MeasuredRun], *, channels: Sequence[str] = PAPER_CHANNELS) -> PaperWay:
    """Stiffness and damping by least RMS difference, the stated inputs taken as exact.

    Minimises Σ over runs and channels of (RMS difference / range of the readings)² over k and c, from several starts:
    every reading weighs the same within a channel, every channel the same. This is the reading given here to "the RMS
    discrepancy between the model output and the measured ones" (paper, IV.C), which does not say how metres and newtons
    were put together.

    Parameters
    ----------
    rig : Rig
        As stated.
    runs : sequence of MeasuredRun
        Those with the purpose 'identification' are used.
    channels : sequence of str
        Those that are compared, where measured.
    """
    chosen = [_weighted(without_saturation(one)[0], channels) for one in runs if one.purpose == "identification"]
    chosen = [one for one in chosen if any(name in channels for name in one.channels)]
    if not chosen:
        return PaperWay("failed", "no run has a channel to compare", math.nan, math.nan, {}, math.nan)
    layout = lay_out(rig, [one.name for one in chosen], ("k", "c"), ())
    use = [{name: one.used(name) & (name in channels) for name in one.channels} for one in chosen]
    posed = problem(rig, chosen, layout, use, View())
    best: Solution | None = None
    for start in starts(rig, layout):
        # The sum has kinks where a contact passes a reading: what is left of a step there is no failure.
        found = solve(posed, start, steps=30)
        if found.point is not None and (best is None or found.cost < best.cost):
            best = found
    if best is None or best.point is None:
        sentence = "no stiffness and damping were found: the motion cannot be followed from the stated values"
        return PaperWay("failed", sentence, math.nan, math.nan, {}, math.nan)
    terms = len({(one.name, name) for one in chosen for name in one.channels if name in channels})
    rms = _rms(rig.with_values(values_of(layout, 0, best.point.theta)), chosen, channels)
    k, c = (float(value) for value in best.point.theta)
    return PaperWay("ok", best.sentence, k, c, rms, math.sqrt(best.cost / terms))


def _weighted(measured: MeasuredRun, channels: Sequence[str]) -> MeasuredRun:
    """Return the run with weights 1/(range·√n) in place of the noise."""
    noise = {}
    for name in measured.channels:
        readings = measured.readings(name)[measured.used(name)]
        spread = float(np.ptp(readings)) or 1.0
        noise[name] = spread * math.sqrt(len(readings)) if name in channels else measured.noise[name]
    return replace(measured, noise=noise)


def _rms(rig: Rig, runs: Sequence[MeasuredRun], channels: Sequence[str]) -> dict[str, float]:
    from metrology.rig import simulate

    squares: dict[str, list[float]] = {}
    for measured in runs:
        moved = simulate(rig, measured.run)
        for name in measured.channels:
            if name in channels:
                used = measured.used(name)
                difference = measured.readings(name)[used] - getattr(moved, name)[used]
                squares.setdefault(name, []).extend((difference**2).tolist())
    return {name: math.sqrt(float(np.mean(values))) for name, values in squares.items()}
