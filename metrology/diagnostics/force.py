"""The force that a model lacks, from the balance of forces alone: no candidate, no fit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from metrology.coordinate import QUANTITIES
from metrology.diagnosis import Missing
from metrology.diagnostics.subject import Array
from metrology.estimation import MeasuredRun
from metrology.message import said
from metrology.rig import Rig, Run

BINS = 12
WINDOW = 0.15
"""Length of a window over the period of the motion."""
BY = ("v", "x", "T", "t")
"""What it may depend on, in the order of the columns of `_balance`."""


def missing_force(rig: Rig, runs: Sequence[MeasuredRun], values: Sequence[Mapping[str, float]]) -> Missing | None:
    """Mean of m·v′ − F + T in windows, binned against velocity, position, tension and time; the best one is given.

    v′, F and T are averaged with the same kernel h(t) ∝ 1 − s², s from −1 to 1 over the window, which by integration
    by parts makes ∫h·v′ a sum over the velocities themselves (Savitzky & Golay, Anal. Chem. 36 (1964) 1627).
    None without velocity and tension.

    Parameters
    ----------
    rig : Rig
        As fitted, for mass and natural frequency.
    runs : sequence of MeasuredRun
        With readings of v and T.
    values : sequence of mapping
        Estimates of the parameters of each run.
    """
    found = [
        _balance(rig.with_values(own), run)
        for run, own in zip(runs, values, strict=True)
        if {"v", "T"} <= set(run.channels)
    ]
    tables = [one for one in found if one is not None]
    if not tables:
        return None
    rows = np.concatenate(tables)
    force, u = rows[:, 0], rows[:, 1]
    binned = {name: _bins(rows[:, 2 + at], force, u) for at, name in enumerate(BY)}
    words = QUANTITIES[rig.coordinate]
    (drive, unit), by = words["F"], max(BY, key=lambda name: binned[name][3])
    against = words[by]
    at, value, spread = binned[by][:3]
    largest = int(np.argmax(np.abs(value)))
    forces, torques = (
        "The balance of forces lacks up to {size:.2g} {unit} (u = {u:.1g} {unit}) where the {against} is {at:.3g} "
        "{against_unit}; it depends most on {against}.",
        "The balance of torques lacks up to {size:.2g} {unit} (u = {u:.1g} {unit}) where the {against} is {at:.3g} "
        "{against_unit}; it depends most on {against}.",
    )
    sentence = said(
        forces if drive == "force" else torques, size=float(value[largest]), unit=unit, u=float(spread[largest]),
        against=against.word, at=float(at[largest]), against_unit=against.unit,
    )  # fmt: skip
    return Missing(
        said("missing {what}", what=drive), unit, *against, tuple(at.tolist()), tuple(value.tolist()),
        tuple(spread.tolist()),
        {words[name].word: part[3] for name, part in binned.items()}, sentence,
    )  # fmt: skip


def smoothing(rig: Rig, t: Array) -> tuple[Array, int]:
    """Weights ∝ 1 − s² of a window of `WINDOW` periods of the motion, and half its length in readings."""
    period = 2 * math.pi * math.sqrt(rig.m / max(rig.k, 1e-12))
    half = int(np.clip(WINDOW * period / float(np.median(np.diff(t))) / 2, 3, len(t) // 8))
    s = np.arange(-half, half + 1) / (half + 1)
    return (1 - s**2) / np.sum(1 - s**2), half


def _balance(rig: Rig, run: MeasuredRun) -> Array | None:
    """Rows of force, its u, velocity, position, tension, time."""
    seen = {name: run.used(name) for name in run.channels}
    t, v = run.stamps("v")[seen["v"]], run.readings("v")[seen["v"]]
    if len(t) < 40:
        return None
    step = float(np.median(np.diff(t)))
    kernel, half = smoothing(rig, t)
    slope = np.convolve(np.gradient(v, t), kernel, mode="same")
    clock = rig.value("clock.T") - rig.value("clock.v")
    tension = (np.interp(t + clock, run.stamps("T")[seen["T"]], run.readings("T")[seen["T"]])
               - rig.value("cell.zero")) / rig.value("cell.gain")  # fmt: skip
    push = rig.value("thrust.gain") * (1 - rig.value("thrust.fading") * _since(run.run, t)) * thrust(run.run, t)
    balance = rig.m * rig.value("mass.factor") * slope - np.convolve(push - tension, kernel, mode="same")
    position = (
        np.interp(t, run.stamps("x")[seen["x"]], run.readings("x")[seen["x"]]) if "x" in seen else np.cumsum(v) * step
    )
    begun = run.run.t0 if run.run.held_until is None else run.run.held_until
    first = max(half + 1, int(np.searchsorted(t, begun)) + half)
    chosen = np.arange(first, len(t) - half - 1, 2 * half + 1)
    u_slope = rig.m * run.noise["v"] * float(np.sqrt(np.sum(np.diff(kernel, prepend=0.0, append=0.0) ** 2))) / step
    u_tension = run.noise["T"] * float(np.sqrt(np.sum(kernel**2)))
    u = np.full(len(chosen), math.hypot(u_slope, u_tension))
    return np.column_stack([balance[chosen], u, v[chosen], position[chosen], tension[chosen], t[chosen]])


def thrust(run: Run, t: Array) -> Array:
    """Thrust of a run as commanded, at some times / s."""
    if run.force is None:
        return np.zeros_like(t)
    edges, forces, slopes = run.force.pieces
    at = np.searchsorted(edges, t, side="right") - 1
    found: Array = np.where(at >= 0, forces[at] + slopes[at] * (t - edges[at]), 0.0)
    return found


def _since(run: Run, t: Array) -> Array:
    """Time since the first edge of the thrust / s."""
    return np.zeros_like(t) if run.force is None else np.maximum(t - run.force.t[0], 0.0)


def _bins(by: Array, force: Array, u: Array) -> tuple[Array, Array, Array, float]:
    """Centre, mean and u of each bin, and the part of the variance beyond noise that the bins explain."""
    order = np.argsort(by)
    parts = [part for part in np.array_split(order, BINS) if len(part) > 1]
    at = np.array([by[part].mean() for part in parts])
    mean = np.array([force[part].mean() for part in parts])
    spread = np.array([max(force[part].std(ddof=1), float(u[part].mean())) / math.sqrt(len(part)) for part in parts])
    total = float(force.var() * len(force))
    between = sum(len(part) * (value - force.mean()) ** 2 for part, value in zip(parts, mean, strict=True))
    chance = (len(parts) - 1) * total / max(len(force) - 1, 1)
    return at, mean, spread, float(np.clip((between - chance) / max(total - chance, 1e-300), 0.0, 1.0))
