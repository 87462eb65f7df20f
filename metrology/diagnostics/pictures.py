"""What makes a cause visible: a few small curves of a test, before and after the extension."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from metrology.coordinate import QUANTITIES, Quantity
from metrology.diagnosis import Curve, Picture, Role
from metrology.diagnostics.following import Followed
from metrology.diagnostics.subject import Array
from metrology.message import said
from metrology.rig import CHANNELS

MOST = 400
"""Points that a curve keeps at most."""
BLOCKS = 80
"""Means of residuals over a run: what is not noise shows in them before it shows in single readings."""
ROLES: tuple[tuple[Role, str], ...] = (("before", said("model as it stands")), ("after", said("extended model")))


class Form(Protocol):
    """A force that depends on one quantity, judged: places, amounts and their u, as `free_force.forms` gives them."""

    @property
    def family(self) -> str:
        """What it is, and of what: 'force of velocity'."""

    @property
    def dof(self) -> int:
        """Combinations that the readings see."""

    @property
    def at(self) -> Array:
        """Places, in the unit of the family."""

    @property
    def amounts(self) -> Array:
        """Force at each / N, or N·m where x is an angle."""

    @property
    def u(self) -> Array:
        """Their standard uncertainty."""


Way = tuple[Role, str, Sequence[Followed]]
"""Role, name, and the runs as this model follows them."""


def of_response(ways: Sequence[tuple[Sequence[Followed], Sequence[Form]]]) -> tuple[Picture, ...]:
    """Pictures of response runs.

    Parameters
    ----------
    ways : sequence of (runs, forms)
        Runs as the model follows them as it stands, and the smooth forces that it lacks; then those of the extended
        one, where there is one.
    """
    models: list[Way] = [(*ROLES[at], runs) for at, (runs, _) in enumerate(ways) if runs]
    if not models:
        return ()
    before = models[0][2]
    telling = max(range(len(before)), key=lambda at: _loudness(before[at]))
    channels = [name for name in CHANNELS if any(name in one.run.channels for one in before)]
    forces = _forces(_words(before[0]), [forms for _, forms in ways])
    found: list[Picture | None] = [*forces, _loop(models, telling), _delays(models)]
    found += [_spectrum_of(models, name) for name in channels]
    found += [_history(models, telling, name) for name in channels if name in before[telling].run.channels]
    return tuple(picture for picture in found if picture is not None)


def _words(one: Followed) -> Mapping[str, Quantity]:
    return QUANTITIES[one.rig.coordinate]


def _loudness(one: Followed) -> float:
    """Mean square of all residuals over noise."""
    squares = [np.nanmean((one.residual(name) / one.run.noise[name]) ** 2) for name in one.run.channels
               if one.used[name].any()]  # fmt: skip
    return float(np.mean(squares)) if squares else 0.0


# ---- response -----------------------------------------------------------------------------------------------------
def _forces(words: Mapping[str, Quantity], forms: Sequence[Sequence[Form]]) -> list[Picture]:
    """Force that a model lacks against velocity and against elongation."""
    columns = (
        ("v", "force-velocity", said("A step at zero is friction, a slope drag, a parabola quadratic drag.")),
        ("e", "force-elongation",
         said("A curve is a line that stiffens or softens; what k and c can explain is not seen.")),
    )  # fmt: skip
    force, found = words["F"], []
    for symbol, key, reading in columns:
        against = words[symbol]
        curves = [
            curve(role, name, one.at, one.amounts, one.u)
            for (role, name), own in zip(ROLES, forms, strict=False)
            for one in own
            if one.family == f"{force.word} of {against.word}" and one.dof
        ]
        if curves:
            text = (
                "Force that the model lacks, against {against}"
                if force.word == "force"
                else "Torque that the model lacks, against {against}"
            )
            title = said(text, against=against.word)
            found.append(Picture(key, title, *against, *force, tuple(curves), reading))
    return found


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
    curves = [Curve(said("measured"), "measured", _floats(x), _floats(_filled(one.run.readings("T"))[rows]))]
    for role, name, runs in ways:
        moved = runs[at].motion
        place = np.interp(t[rows], runs[at].run.stamps("x"), np.asarray(moved.x))
        curves.append(curve(role, name, place, np.asarray(moved.T)[rows]))
    reading = said("The area of a loop is the energy that a cycle loses; its slope is the stiffness.")
    across, up = _words(one)["x"], _words(one)["T"]
    tension, torque = "Tension against {against}, {run}", "Torque against {against}, {run}"
    title = said(tension if up.word == "tension" else torque, against=across.word, run=one.run.name)
    return Picture("loop", title, *across, *up, tuple(curves), reading, joined=True)


def _spectrum_of(ways: Sequence[Way], channel: str) -> Picture | None:
    curves = []
    for role, name, runs in ways:
        parts = [(one.run.stamps(channel), one.residual(channel) / one.run.noise[channel])
                 for one in runs if channel in one.run.channels]  # fmt: skip
        curves.append(spectrum(role, name, parts))
    word = _words(ways[0][2][0])[channel].word
    return spectra(said("Residual spectrum, {what}", what=word), f"spectrum-{channel}", curves)


def _delays(ways: Sequence[Way]) -> Picture | None:
    """Time by which each channel of each run lags the model: r = −τ·y′, so τ = −Σ r·y′/Σ y′²."""
    curves = []
    for role, name, runs in ways:
        for channel in CHANNELS:
            beside = 0.1 * ("xvT".index(channel) - 1) + 0.04 * (role == "after")
            rows = [
                (at + beside, *_delay(one, channel)) for at, one in enumerate(runs, 1) if channel in one.run.channels
            ]
            if rows:
                x, y, u = np.array(rows, float).T
                curves.append(curve(role, said("{what}, {model}", what=channel, model=name), x, y, u))
    if not curves:
        return None
    reading = said("A channel that lags in every run has a clock, or a filter, of its own.")
    title = said("Delay against the model")
    return Picture("delay", title, said("run"), "1", said("delay"), "s", tuple(curves), reading)


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
        t, residual = one.run.stamps(channel), one.residual(channel) / one.run.noise[channel]
        seen = np.isfinite(residual)
        parts = [part for part in np.array_split(np.flatnonzero(seen), BLOCKS) if len(part)]
        x, y = (np.array([column[part].mean() for part in parts]) for column in (t, residual))
        curves.append(curve(role, name, x, y * np.sqrt([len(part) for part in parts])))
    before = ways[0][2][at]
    text = "Means of residuals, {channel} of {run}"
    title = said(text, channel=_words(before)[channel].word, run=before.run.name)
    return history(f"history-{channel}", title, curves, quantity=said("mean / its u"))


# ---- pieces -------------------------------------------------------------------------------------------------------
def history(key: str, title: str, curves: Sequence[Curve], *, quantity: str = said("residual / u")) -> Picture:
    """Residuals over noise against time."""
    reading = said("Noise alone stays between ±2 nineteen times in twenty and has no shape.")
    return Picture(key, title, "time", "s", quantity, "1", tuple(curves), reading, joined=True)


def spectra(title: str, key: str, curves: Sequence[Curve | None]) -> Picture | None:
    """Power of residuals over that of the stated noise, against frequency."""
    seen = [one for one in curves if one is not None]
    if not seen:
        return None
    ends = (min(one.x[0] for one in seen), max(one.x[-1] for one in seen))
    seen.append(Curve(said("stated noise"), "limit", ends, (1.0, 1.0)))
    reading = said("What lies above 1 is not noise; where it begins tells how fast the missing thing is.")
    return Picture(key, title, said("frequency"), "Hz", said("power / noise"), "1", tuple(seen), reading, True, "both")


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


def curve(role: Role, name: str, x: Array, y: Array, u: Array | None = None) -> Curve:
    """A curve of so many digits as a picture shows."""
    return Curve(name, role, _floats(x), _floats(y), () if u is None else _floats(u))


def _floats(values: Array) -> tuple[float, ...]:
    return tuple(float(f"{value:.6g}") for value in values)


def _filled(values: Array) -> Array:
    """Gaps bridged by straight lines."""
    seen = np.isfinite(values)
    if seen.all() or not seen.any():
        return np.where(seen, values, 0.0)
    at = np.arange(len(values))
    return np.asarray(np.interp(at, at[seen], values[seen]))
