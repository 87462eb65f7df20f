"""What makes a cause visible: a few small curves of a test, before and after the extension."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from metrology.diagnose.finding import Curve, Picture, Role
from metrology.diagnose.force import smoothing
from metrology.diagnose.subject import Array, Fit, Marks
from metrology.identify.response import motion, values_of

if TYPE_CHECKING:
    from metrology.identify import Layout, MeasuredRun
    from metrology.rig import Motion, Rig

MOST = 400
"""Points that a curve keeps at most."""
BINS = 24
TITLES = {"x": "position", "v": "velocity", "T": "tension"}
UNITS = {"x": "m", "v": "m/s", "T": "N"}
ROLES: tuple[tuple[Role, str], ...] = (("before", "model as it stands"), ("after", "extended model"))


@dataclass(frozen=True)
class Followed:
    """One run as one model follows it: the rig with the values of the run, the motion, and the readings used."""

    run: MeasuredRun
    rig: Rig
    motion: Motion
    used: Mapping[str, Marks]

    def residual(self, channel: str) -> Array:
        """Measured less simulated, in the unit of the channel; NaN where a reading is not used."""
        found: Array = self.run.readings(channel) - np.asarray(getattr(self.motion, channel))
        return np.where(self.used[channel], found, np.nan)


def followed(rig: Rig, layout: Layout, runs: Sequence[MeasuredRun], fit: Fit) -> tuple[Followed, ...]:
    """Every run as a fitted model follows it; none where one cannot be followed."""
    found = []
    for at, (run, block, used) in enumerate(zip(runs, fit.problem.blocks, fit.used, strict=True)):
        values = values_of(layout, at, fit.theta)
        moved = motion(rig, run.run, values)
        if moved is None:
            return ()
        marks = {one.name: used[one.first : one.last] for one in block.segments}
        found.append(Followed(run, rig.with_values(values), moved, marks))
    return tuple(found)


Way = tuple[Role, str, Sequence[Followed]]
"""Role, name, and the runs as this model follows them."""


def of_response(before: Sequence[Followed], after: Sequence[Followed]) -> tuple[Picture, ...]:
    """Pictures of response runs.

    Parameters
    ----------
    before, after : sequence of Followed
        The same runs with the model as it stands and with the extended one; `after` is empty without an extension.
    """
    ways: list[Way] = [(role, name, runs) for (role, name), runs in zip(ROLES, (before, after), strict=True) if runs]
    if not before:
        return ()
    telling = max(range(len(before)), key=lambda at: _loudness(before[at]))
    channels = [name for name in TITLES if any(name in one.run.channels for one in before)]
    found = [*_forces(ways), _loop(ways, telling), *(_spectrum_of(ways, name) for name in channels), _delays(ways)]
    found += [_history(ways, telling, name) for name in channels if name in before[telling].run.channels]
    return tuple(picture for picture in found if picture is not None)


def _loudness(one: Followed) -> float:
    """Mean square of all residuals over noise."""
    squares = [np.nanmean((one.residual(name) / one.run.noise[name]) ** 2) for name in one.run.channels
               if one.used[name].any()]  # fmt: skip
    return float(np.mean(squares)) if squares else 0.0


# ---- response -----------------------------------------------------------------------------------------------------
def _forces(ways: Sequence[Way]) -> list[Picture | None]:
    """Force that a model lacks, m·Δv′ + ΔT with Δ measured less simulated, against velocity and elongation."""
    tables = [(role, name, _joined([_lacking(one) for one in runs])) for role, name, runs in ways]
    columns = (("velocity", "m/s", 1, "A step at zero is friction, a slope drag, a parabola quadratic drag."),
               ("elongation", "m", 2, "A slope is stiffness, a curve a line that stiffens or softens."))  # fmt: skip
    found: list[Picture | None] = []
    for against, unit, column, reading in columns:
        curves = [_binned(role, name, rows[:, column], rows[:, 0]) for role, name, rows in tables if len(rows) > BINS]
        told = tuple(one for one in curves if one is not None)
        title = f"Force that the model lacks, against {against}"
        found.append(Picture(f"force-{against}", title, against, unit, "force", "N", told, reading) if told else None)
    return found


def _lacking(one: Followed) -> Array:
    """Rows of force, velocity, elongation in windows, as in `force.missing_force`; none without v and T."""
    run = one.run
    if not {"v", "T"} <= set(run.channels) or len(run.stamps("v")) < 40:
        return np.empty((0, 3))
    t = run.stamps("v")
    kernel, half = smoothing(one.rig, t)
    v, T = (_filled(one.residual(name)) for name in ("v", "T"))
    step = float(np.median(np.diff(t)))
    slope = np.convolve(np.diff(v, prepend=v[0]) / step, kernel, mode="same")
    tension = np.convolve(np.interp(t, run.stamps("T"), T), kernel, mode="same")
    force = one.rig.m * one.rig.value("mass.factor") * slope + tension / one.rig.value("cell.gain")
    speed = np.convolve(_filled(run.readings("v")), kernel, mode="same")
    place = _filled(run.readings("x")) if "x" in run.channels else np.full(len(t), np.nan)
    place = np.interp(t, run.stamps("x"), place) if "x" in run.channels else place
    first = max(half + 1, int(np.searchsorted(t, run.run.held_until or run.run.t0)) + half)
    chosen = np.arange(first, len(t) - half - 1, max(half, 1))
    return np.column_stack([force[chosen], speed[chosen], place[chosen] - one.rig.taut])


def _loop(ways: Sequence[Way], at: int) -> Picture | None:
    """Tension against position of one run, from the first contact on."""
    one = ways[0][2][at]
    if not {"x", "T"} <= set(one.run.channels):
        return None
    t = one.run.stamps("T")
    begun = next((event.t for event in one.motion.events if event.kind == "taut"), float(t[0]))
    period = 2 * math.pi * math.sqrt(one.rig.m / max(one.rig.k, 1e-12))
    rows = np.flatnonzero((t >= begun - 0.1 * period) & (t <= begun + 3 * period))
    rows = rows[:: max(1, -(-len(rows) // MOST))]
    if len(rows) < 8:
        return None
    x = np.interp(t[rows], one.run.stamps("x"), _filled(one.run.readings("x")))
    curves = [Curve("measured", "measured", _floats(x), _floats(_filled(one.run.readings("T"))[rows]))]
    for role, name, runs in ways:
        moved = runs[at].motion
        place = np.interp(t[rows], runs[at].run.stamps("x"), np.asarray(moved.x))
        curves.append(curve(role, name, place, np.asarray(moved.T)[rows]))
    reading = "The area of a loop is the energy that a cycle loses; its slope is the stiffness."
    title = f"Tension against position, {one.run.name}"
    return Picture("loop", title, "position", "m", "tension", "N", tuple(curves), reading, joined=True)


def _spectrum_of(ways: Sequence[Way], channel: str) -> Picture | None:
    curves = []
    for role, name, runs in ways:
        parts = [(one.run.stamps(channel), one.residual(channel) / one.run.noise[channel])
                 for one in runs if channel in one.run.channels]  # fmt: skip
        curves.append(spectrum(role, name, parts))
    return spectra(f"Residual spectrum, {TITLES[channel]}", f"spectrum-{channel}", curves)


def _delays(ways: Sequence[Way]) -> Picture | None:
    """Time by which each channel of each run lags the model: r = −τ·y′, so τ = −Σ r·y′/Σ y′²."""
    curves = []
    for role, name, runs in ways:
        for channel in TITLES:
            rows = [(at, *_delay(one, channel)) for at, one in enumerate(runs, 1) if channel in one.run.channels]
            if rows:
                x, y, u = np.array(rows, float).T
                curves.append(curve(role, f"{channel}, {name}", x, y, u))
    if not curves:
        return None
    reading = "A channel that lags in every run has a clock, or a filter, of its own."
    return Picture("delay", "Delay against the model", "run", "1", "delay", "s", tuple(curves), reading)


def _delay(one: Followed, channel: str) -> tuple[float, float]:
    y = np.asarray(getattr(one.motion, channel))
    rate = np.gradient(y, one.run.stamps(channel))
    residual = one.residual(channel)
    seen = np.isfinite(residual)
    size = float(np.sum(rate[seen] ** 2)) or 1.0
    return -float(np.sum(residual[seen] * rate[seen])) / size, one.run.noise[channel] / math.sqrt(size)


def _history(ways: Sequence[Way], at: int, channel: str) -> Picture:
    curves = []
    for role, name, runs in ways:
        one = runs[at]
        x, y = extremes(one.run.stamps(channel), one.residual(channel) / one.run.noise[channel])
        curves.append(curve(role, name, x, y))
    title = f"Residual over time, {TITLES[channel]} of {ways[0][2][at].run.name}"
    return history(f"history-{channel}", title, curves)


# ---- pieces -------------------------------------------------------------------------------------------------------
def history(key: str, title: str, curves: Sequence[Curve]) -> Picture:
    """Residuals over noise against time."""
    reading = "Noise alone stays between ±2 nineteen times in twenty and has no shape."
    return Picture(key, title, "time", "s", "residual / u", "1", tuple(curves), reading, joined=True)


def spectra(title: str, key: str, curves: Sequence[Curve | None]) -> Picture | None:
    """Power of residuals over that of the stated noise, against frequency."""
    told = [one for one in curves if one is not None]
    if not told:
        return None
    ends = (min(one.x[0] for one in told), max(one.x[-1] for one in told))
    told.append(Curve("stated noise", "limit", ends, (1.0, 1.0)))
    reading = "What lies above 1 is not noise; where it begins tells how fast the missing thing is."
    return Picture(key, title, "frequency", "Hz", "power / noise", "1", tuple(told), reading, True, "both")


def spectrum(role: Role, name: str, parts: Sequence[tuple[Array, Array]]) -> Curve | None:
    """Periodograms of residuals over noise (1 for white noise as stated), averaged over runs and in bins of log f.

    Parameters
    ----------
    role, name : str
        Of the curve.
    parts : sequence of (t, residual)
        Of each run, evenly sampled; NaN for what is not used.
    """
    frequency, power = [], []
    for t, residual in parts:
        seen = np.isfinite(residual)
        if seen.sum() < 32:
            continue
        flat = np.where(seen, residual - np.nanmean(residual), 0.0)
        spread = np.abs(np.fft.rfft(flat)) ** 2 / seen.sum()
        frequency.append(np.fft.rfftfreq(len(t), float(np.median(np.diff(t))))[1:])
        power.append(spread[1:])
    if not frequency:
        return None
    f, p = np.concatenate(frequency), np.concatenate(power)
    edges = np.geomspace(f.min() * 0.999, f.max() * 1.001, 49)
    cell = np.digitize(f, edges)
    rows = [(f[cell == at].mean(), p[cell == at].mean()) for at in range(1, 49) if (cell == at).any()]
    x, y = np.array(rows).T
    return curve(role, name, x, np.maximum(y, 1e-6))


def extremes(x: Array, y: Array) -> tuple[Array, Array]:
    """Smallest and largest value of each of so many columns that `MOST` points are kept."""
    keep = np.isfinite(y)
    x, y = x[keep], y[keep]
    if len(x) <= MOST:
        return x, y
    parts = np.array_split(np.arange(len(x)), MOST // 2)
    rows = np.unique([part[pick(y[part])] for part in parts for pick in (np.argmin, np.argmax)])
    return x[rows], y[rows]


def _binned(role: Role, name: str, by: Array, value: Array) -> Curve | None:
    """Means in bins of equal count with the standard uncertainty of each."""
    keep = np.isfinite(by) & np.isfinite(value)
    by, value = by[keep], value[keep]
    if len(by) < 2 * BINS:
        return None
    parts = np.array_split(np.argsort(by), BINS)
    x, y = (np.array([column[part].mean() for part in parts]) for column in (by, value))
    u = np.array([value[part].std(ddof=1) / math.sqrt(len(part)) for part in parts])
    return curve(role, name, x, y, u)


def curve(role: Role, name: str, x: Array, y: Array, u: Array | None = None) -> Curve:
    """A curve of so many digits as a picture shows."""
    return Curve(name, role, _floats(x), _floats(y), () if u is None else _floats(u))


def _joined(tables: Sequence[Array]) -> Array:
    return np.concatenate(tables) if tables else np.empty((0, 3))


def _floats(values: Array) -> tuple[float, ...]:
    return tuple(float(f"{value:.6g}") for value in values)


def _filled(values: Array) -> Array:
    """Gaps bridged by straight lines."""
    seen = np.isfinite(values)
    if seen.all() or not seen.any():
        return np.where(seen, values, 0.0)
    at = np.arange(len(values))
    return np.asarray(np.interp(at, at[seen], values[seen]))
