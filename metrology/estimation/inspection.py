"""What is wrong with measured runs before anything is fitted: signs, start state, saturation, excitation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from metrology.errors import Fault
from metrology.estimation.measured import MeasuredRun
from metrology.estimation.noise import resolution
from metrology.estimation.problem import Array, Marks
from metrology.message import counted, said
from metrology.rig import Rig

FLAT = 5
"""Readings in a row at exactly the largest value that a cell does not give unless it is saturated."""
CLEAR = 8.0
"""How many standard uncertainties a wrong sign has to stand out."""
START = (8.0, 0.05)
"""A start is impossible when off by more than this many standard uncertainties, and than this length / m (rad)."""
AGAINST = -0.5
"""Correlation of tension and position, of a line that also pushes, from which on one of them has a wrong sign."""
COLUMNS = {
    "position": {"x": "x", "v": "v", "T": "T"},
    "angle": {"x": "angle", "v": "rate", "T": "torque"},
}
"""What x is → what the readings of a channel are called."""


def faults(rig: Rig, runs: Sequence[MeasuredRun]) -> list[Fault]:
    """Faults that make a fit meaningless: wrong sign conventions, impossible start states, runs without excitation.

    Parameters
    ----------
    rig : Rig
        As stated.
    runs : sequence of MeasuredRun
        Measured runs.

    Returns
    -------
    list of Fault
        Empty where nothing is wrong.
    """
    found: list[Fault] = []
    for measured in runs:
        found += [*_tension_sign(rig, measured), *_position_sign(rig, measured), *_velocity_sign(measured)]
        found += [*_start_state(measured), *_excitation(measured)]
    return found


def _used(measured: MeasuredRun, channel: str) -> tuple[Array, Array]:
    used = measured.used(channel)
    return measured.stamps(channel)[used], measured.readings(channel)[used]


def _where(measured: MeasuredRun, channel: str) -> str:
    return f"{measured.name}.{COLUMNS[measured.coordinate][channel]}"


def _tension_sign(rig: Rig, measured: MeasuredRun) -> list[Fault]:
    if "T" not in measured.channels or rig.attachment == "none":
        return []
    if rig.attachment == "both ways":
        return _tension_against_position(measured)
    readings = _used(measured, "T")[1]
    low, high = np.quantile(readings, (0.002, 0.998)) - np.median(readings[: max(5, len(readings) // 50)])
    if -low > max(3 * abs(high), CLEAR * measured.noise["T"]):
        pulled = "a tension" if measured.coordinate == "position" else "a torque"
        got = f"{pulled} that falls to {readings.min():.3g} {measured.unit('T')} when the line pulls"
        expected = f"{pulled} that is positive when the line pulls"
        return [Fault(_where(measured, "T"), got, expected, "change its sign")]
    return []


def _tension_against_position(measured: MeasuredRun) -> list[Fault]:
    """T = k·e + c·e′ grows with x, whichever way the module swings."""
    if "x" not in measured.channels:
        return []
    (t_x, x), (t_T, T) = _used(measured, "x"), _used(measured, "T")
    clear = np.ptp(T) > CLEAR * measured.noise["T"] and np.ptp(x) > CLEAR * measured.noise["x"]
    if min(len(t_x), len(t_T)) < 10 or not clear:
        return []
    if float(np.corrcoef(T, np.interp(t_T, t_x, x))[0, 1]) > AGAINST:
        return []
    words = COLUMNS[measured.coordinate]
    got, expected = f"{words['T']} falls as {words['x']} grows", f"{words['T']} that grows with {words['x']}"
    return [Fault(_where(measured, "T"), got, expected, "change the sign of one of them")]


def _pushed(measured: MeasuredRun) -> tuple[float, float, float] | None:
    """First time span of constant thrust that is not zero, and the thrust."""
    force, run = measured.run.force, measured.run
    if force is None or force.kind != "constant":
        return None
    pushing = np.flatnonzero(force.values)
    if not pushing.size:
        return None
    at = int(pushing[0])
    start = max(float(force.t[at]), run.t0, run.held_until or -math.inf)
    stop = float(force.t[at + 1]) if at + 1 < len(force.t) else run.end
    return start, stop, float(force.values[at])


def _position_sign(rig: Rig, measured: MeasuredRun) -> list[Fault]:
    """Position runs against the thrust of a module on which no line pulls yet: its first clear departure decides."""
    from scipy.ndimage import median_filter

    pushed, run = _pushed(measured), measured.run
    still = run.x0 == rig.taut and run.v0 == 0.0
    loose = {"none": True, "tether": run.x0 < rig.taut, "both ways": still}[rig.attachment]
    if pushed is None or "x" not in measured.channels or not loose:
        return []
    t, x = _used(measured, "x")
    start, stop, thrust = pushed
    before, inside = t < start, (t >= start) & (t <= stop)
    if inside.sum() < 10:
        return []
    rest = float(np.median(x[before])) if before.sum() > 3 else run.x0
    drift = run.v0 * (t[inside] - start)
    # A single reading that is far off says nothing of a motion: the median of five neighbours.
    moved = median_filter(x[inside] - rest - drift, 5, mode="mirror") * math.copysign(1.0, thrust)
    noise = measured.noise["x"]
    # The first clear departure decides: later the line pulls back.
    clear = np.flatnonzero(np.abs(moved) > max(25 * noise, 1e-3))
    if clear.size and moved[clear[0]] < 0:
        moves, drive = ("a position", "thrust") if measured.coordinate == "position" else ("an angle", "torque")
        got = f"{moves} that moves against the {drive} of {thrust:g} {measured.unit('T')}"
        words = COLUMNS[measured.coordinate]
        fix = f"change the sign of {words['x']} (and {words['v']}), or of the {drive} in 'thrust'"
        return [Fault(_where(measured, "x"), got, f"{moves} that grows with the {drive}", fix)]
    return []


def _velocity_sign(measured: MeasuredRun) -> list[Fault]:
    if not {"x", "v"} <= set(measured.channels):
        return []
    (t_x, x), (t_v, v) = _used(measured, "x"), _used(measured, "v")
    if len(t_x) < 10 or len(t_v) < 10:
        return []
    # Displacement over spans from the velocity against that from the position: noise cannot turn its sign.
    travel = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t_v))])
    knots = np.linspace(max(t_x[0], t_v[0]), min(t_x[-1], t_v[-1]), 40)
    from_v = np.diff(np.interp(knots, t_v, travel))
    from_x = np.diff(np.interp(knots, t_x, x))
    if np.abs(from_x).max() < CLEAR * measured.noise["x"]:
        return []
    if float(from_v @ from_x) < -0.5 * float(from_x @ from_x):
        (x_word, v_word, _), turns = COLUMNS[measured.coordinate].values(), measured.coordinate == "angle"
        got = "a rate against the change of angle" if turns else "a velocity against the change of position"
        fix = f"change the sign of {v_word}, or of {x_word}"
        return [Fault(_where(measured, "v"), got, f"{v_word} = d{' ' if turns else ''}{x_word}/dt", fix)]
    return []


def _start_state(measured: MeasuredRun) -> list[Fault]:
    if "x" not in measured.channels:
        return []
    t, x = _used(measured, "x")
    run = measured.run
    begun = run.t0 if run.held_until is None else run.held_until
    first = np.flatnonzero(t >= begun)[:5]
    held = np.flatnonzero(t < begun)[-5:]
    near = held if held.size else first
    if not near.size or abs(float(t[near[0]]) - begun) > 0.5:
        return []
    # A module that is let go may turn within a few readings: it can have begun as far beyond them as they lie apart.
    apart = 0.0 if held.size else float(np.ptp(x[near]))
    low, high = float(x[near].min()) - apart, float(x[near].max()) + apart
    off = max(low - run.x0, run.x0 - high)
    if off > max(START[0] * measured.noise["x"], START[1]):
        unit = measured.unit("x")
        got = f"{run.x0:g} {unit}, where the first readings say {np.median(x[near]):.4g} {unit}"
        return [Fault(f"{measured.name}.run.x0", got, "a start state that the readings can have begun from")]
    return []


def _excitation(measured: MeasuredRun) -> list[Fault]:
    moved = any(
        np.ptp(_used(measured, name)[1]) > 12 * measured.noise[name] + 2 * resolution(_used(measured, name)[1])
        for name in measured.channels
    )
    if moved:
        return []
    return [Fault(measured.name, "no motion beyond the noise in any channel", "a run in which the module moves")]


def without_saturation(measured: MeasuredRun) -> tuple[MeasuredRun, tuple[str, ...]]:
    """Return the run with the flat ends of a saturated cell left out, and the sentences that say so.

    Parameters
    ----------
    measured : MeasuredRun
        A run, with or without a load cell.

    Returns
    -------
    tuple of MeasuredRun and tuple of str
        The same run where nothing is flat.
    """
    if "T" not in measured.channels or not measured.used("T").any():
        return measured, ()
    T, used = measured.readings("T"), measured.used("T")
    low, high = float(T[used].min()), float(T[used].max())
    # Of a line that only pulls, the lowest reading is that of a slack one: flat, and right.
    ends = [high, low] if low < 0 and -low >= 0.5 * high else [high]
    rounded = resolution(T) > 2 * measured.noise["T"]
    sentences = []
    for end in ends:
        flat = _flat(used & (np.abs(T - end) <= 1e-12 * abs(end)))
        if not flat.any() or (rounded and flat.sum() < 4 * FLAT):
            continue
        used = used & ~flat
        text = (
            "{run}: the load cell was saturated at {end:.4g} {unit}; {count} readings are left out"
            if measured.coordinate == "position"
            else "{run}: the torque cell was saturated at {end:.4g} {unit}; {count} readings are left out"
        )
        sentences.append(said(text, run=measured.name, end=end, unit=measured.unit("T"), count=int(flat.sum())))
    return (replace(measured, use={**measured.use, "T": used}) if sentences else measured), tuple(sentences)


def _flat(at_end: Marks) -> Marks:
    """Readings of the stretches at an end that are too long for chance."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], at_end.astype(int), [0]])))
    flat = np.zeros(at_end.shape, dtype=bool)
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if last - first >= FLAT:
            flat[first:last] = True
    return flat


def remarks(measured: MeasuredRun) -> tuple[str, ...]:
    """What a reader has to know about one run."""
    found, run = [], measured.name
    gaps = {name: int((~np.isfinite(measured.readings(name))).sum()) for name in measured.channels}
    listed = tuple(
        counted("{count} gap in {channel}", "{count} gaps in {channel}", count, channel=name)
        for name, count in gaps.items()
        if count
    )
    if listed:
        found.append(said("{run}: {gaps:comma}", run=run, gaps=listed))
    noise = ", ".join(f"{name} {measured.noise[name]:.3g} {measured.unit(name)}" for name in measured.channels)
    found.append(said("{run}: standard uncertainty of one reading: {noise:figures}", run=run, noise=noise))
    force, end = measured.run.force, float(measured.run.end)
    if force is not None and force.kind == "constant" and float(force.t[-1]) > end:
        found.append(said("{run}: the thrust profile goes on after the record ends at {end:g} s", run=run, end=end))
    return tuple(found)
