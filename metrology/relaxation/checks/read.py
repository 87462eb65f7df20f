"""Checks of results against what was read: the stiffness at the time asked for, and in equilibrium."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from metrology.check import Check
from metrology.message import said
from metrology.relaxation.blocks import Array, Where
from metrology.relaxation.checks.done import FINAL, LATER, Done
from metrology.relaxation.checks.rest import drifts_at_rest
from metrology.relaxation.evidence import HALF, Supported, numbers
from metrology.relaxation.levels import WITHIN, Level
from metrology.relaxation.test import RelaxationTest

EQUILIBRIUM = "equilibrium and last reading"
AT = "stiffness and readings"
NEAR, LAST = 0.05, 0.1
"""Part of the time asked for, about it, and of a hold, at its end, over which readings are averaged."""
SMALL, LEAST = 5e-3, 1e-3
"""Relative difference of a stiffness at a time, and in equilibrium, that is of no account: of an instrument of class
0.5, and of what a Prony series leaves."""


@dataclass(frozen=True)
class Change:
    """By how much what answered differs from its zero, as read, with its u, and by the most probable form."""

    read: float
    u: float
    model: float


def change(one: Done, weights: Array, *, drift_known: bool) -> Change:
    """Change from rest to the blocks with these weights.

    The zero is that of the readings before the ramp, else the first reading, whatever zero the form found: u holds the
    scatter of both by all colours, at a level that half of the white residuals do not exceed, and half a division. A
    drift is taken off where readings at rest show it; else it is in u, or with `drift_known` is taken as none.
    """
    of, best = one.scene.answer.of, one.best
    y, model = of.y.copy(), best.model - best.values[0]
    drift = np.zeros_like(y)
    if best.form.drift:
        drift = best.values[1] * (of.time - of.time[0]) / (of.time[-1] - of.time[0])
    model = model - drift
    if drifts_at_rest(one):
        y, drift = y - drift, np.zeros_like(y)
    still = rested(one)
    if not one.levels.before:
        # A first mean that holds more than the first reading has begun to answer.
        y[0], model[0] = (one.mounting.force if one.scene.held == "elongation" else one.mounting.stretch)[0], 0.0
    difference = weights - np.where(still, of.count, 0.0) / of.count[still].sum()
    half = one.rounding * float(np.ptp(of.u))
    half *= 1.0 if one.scene.held == "elongation" else float(np.ptp(of.y) / np.ptp(of.u)) ** 2
    u2 = _scatter2(one, difference) + 2 * half**2 / 3
    u2 += 0.0 if drift_known else float(difference @ drift) ** 2 / 3
    return Change(float(difference @ y), float(np.sqrt(u2)), float(difference @ model))


def rested(one: Done) -> Where:
    """Blocks before the first ramp, else the first one."""
    still: Where = one.scene.answer.of.end <= one.levels.before
    return still if still.any() else np.asarray(np.arange(len(still)) == 0)


def _scatter2(one: Done, weights: Array) -> float:
    """Variance of a weighted sum of the means by the noise, mean over its colours."""
    of, best, white = one.scene.answer.of, one.best, one.noise.whitening
    rest = np.abs(white @ (of.y - best.model))
    free = len(of.y) / max(len(of.y) - len(best.values), 1)
    level2 = (np.median(rest, axis=1) / 0.6745) ** 2 * free
    # C = L·Lᵀ of a colour, and whitening is L⁻¹: wᵀ·C·w = |Lᵀ·w|².
    rows = np.linalg.solve(np.swapaxes(white, 1, 2), np.broadcast_to(weights[:, None], (len(white), len(weights), 1)))
    return float(best.weights @ (level2 * (rows[..., 0] ** 2).sum(axis=1)))


def stiffness(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Whether the stiffness at the time asked for is that of the readings there: force by stretch, less the zero.

    A form that is fitted to the whole record may miss it there, and take a zero that was not read.
    """
    from scipy.special import stdtr

    assert test.at is not None
    seen = list(_compared(test.at, done))
    if not seen:
        sentence = said("Not made: nothing was read at that time after a step.")
        return Check(AT, None, None, None, sentence)
    least, worst = 1.0, seen[0]
    for one in seen:
        p = 2 * float(stdtr(one.dof, -abs(one.off) / one.u))
        if p < least and abs(one.off) > SMALL * abs(one.value):
            least, worst = p, one
    p = test.adjusted(least, len(seen))
    if p >= test.significance:
        sentence = said("The stiffness at the time asked for is that of the readings there.")
        return Check(AT, abs(worst.off) / worst.u, p, True, sentence)
    sentence = said(
        "The stiffness at {at:.4g} s (force by stretch, {specimen}: {value:.4g}) is not what was read there, "
        "{read:.4g} ± {u:.1g} by the zero and the scatter of the readings: the model does not follow the record. Do "
        "not rely on it.",
        at=float(test.at),
        specimen=worst.name,
        value=worst.value,
        read=worst.value - worst.off,
        u=worst.u,
    )
    return Check(AT, abs(worst.off) / worst.u, p, False, sentence, concerns=LATER)


@dataclass(frozen=True)
class Compared:
    """A stiffness, by how much it is off what was read, and u of what was read, with its degrees of freedom."""

    name: str
    value: float
    off: float
    u: float
    dof: float


def _compared(at: float, done: Sequence[Done]) -> Iterator[Compared]:
    """The stiffness at a time of each specimen that was read then: counted from the middle of the ramp."""
    for one in done:
        of, reach = one.scene.answer.of, WITHIN * float(np.ptp(one.scene.answer.of.u))
        held = [(level, ramp) for level, ramp in zip(one.levels.held, one.levels.ramps, strict=False)
                if abs(level.value - float(of.u[0])) > reach]  # fmt: skip
        if "r_t" not in one.names or not held:
            continue
        level, ramp = max(held, key=lambda each: each[0].duration)
        then = level.start - ramp / 2 + at
        inside = (of.begin >= level.start) & (of.end <= level.stop)
        if not level.start <= then <= level.stop or not inside.any():
            continue
        found = change(one, _near(one, inside, (then - NEAR * at, then + NEAR * at)), drift_known=False)
        now, later = numbers(one.best, partial(one.scene.at, times=np.array([at, at + one.unread / 2])))[0]
        # Of a held load the answer is in the denominator.
        known = float(now) * found.read / found.model
        known = known if one.scene.held == "elongation" else 1 / known
        u = abs(known) * float(np.hypot(found.u / found.read, (later / now - 1) / np.sqrt(3)))
        value = float(one.said.values[one.names.index("r_t")])
        yield Compared(one.mounting.name, value, value - known, max(u, 1e-300), one.said.dof)


def _near(one: Done, inside: Where, ends: tuple[float, float]) -> Array:
    """Weights of the blocks in a hold whose middles lie between two times; of the nearest one at least."""
    of = one.scene.answer.of
    away = np.where(inside, np.abs(of.time - sum(ends) / 2), np.inf)
    near = inside & (of.time >= ends[0]) & (of.time <= ends[1])
    near[int(np.argmin(away))] = True
    return np.asarray(np.where(near, of.count, 0.0) / of.count[near].sum())


def equilibrium(test: RelaxationTest, done: Sequence[Done], found: Supported) -> Check:
    """Whether the equilibrium stiffness exceeds what was read last at the highest level.

    At a level that no reading exceeded, force by stretch is never less than in equilibrium, whatever was before:
    integrated by parts, F − k_∞·x is a sum of (x(t) − x(s)) with positive weights (and so is J_∞·F − x). What counts is
    the scatter of these readings and the zero; a u of k_∞ excuses nothing.
    """
    from scipy.special import stdtr

    if found.power > HALF:
        return Check(EQUILIBRIUM, None, None, None, said("A power law has no equilibrium."))
    worst, least, words = 0.0, 1.0, ""
    for one in done:
        known, u = _read_last(one)
        value = float(one.said.values[one.names.index("r_inf")])
        over = (value - known) / max(u, 1e-300)
        p = float(stdtr(one.said.dof, -over))
        if p < least and value - known > LEAST * abs(known):
            text = "{specimen}: {value:.5g} against {read:.5g}"
            least, words = p, said(text, specimen=one.mounting.name, value=value, read=known)
            worst = over / 2
    p = test.adjusted(least, len(done))
    if p < test.significance:
        sentence = said(
            "The equilibrium stiffness (force by stretch, {values}) exceeds what was read last at the highest level by "
            "{times:.2g} times the expanded uncertainty of these readings and their zero: no specimen stiffens as it "
            "relaxes. A drift that was taken off, a ramp that is not linear, or levels of unlike stiffness, may have "
            "made it so.",
            values=words,
            times=float(worst),
        )
        return Check(EQUILIBRIUM, worst, p, False, sentence, concerns=FINAL)
    sentence = said("The equilibrium stiffness does not exceed what was read last at the highest level.")
    return Check(EQUILIBRIUM, worst, p, True, sentence)


def _read_last(one: Done) -> tuple[float, float]:
    """Force by stretch at the end of the hold at the highest level, with its u."""
    of = one.scene.answer.of
    away = np.abs(of.u - of.u[0])
    # The last blocks that are as high as any: WITHIN of the range is a level.
    high = away >= (1 - WITHIN) * away.max()
    last = int(np.flatnonzero(high)[-1])
    span = next((each.duration for each in reversed(one.levels.held) if _holds(each, float(of.time[last]))), 0.0)
    part = high & (of.time >= of.time[last] - LAST * span) & (np.arange(len(of.time)) <= last)
    weights = np.where(part, of.count, 0.0) / of.count[part].sum()
    found = change(one, weights, drift_known=True)
    still = rested(one)
    imposed = float(weights @ of.u - np.average(of.u[still], weights=of.count[still]))
    value, u = found.read / imposed, found.u / abs(imposed)
    return (value, u) if one.scene.held == "elongation" else (1 / value, u / value**2)


def _holds(level: Level, time: float) -> bool:
    return level.start <= time <= level.stop
