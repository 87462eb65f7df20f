"""Checks of readings at rest, before the first ramp: a load before the record, a drift of the instrument."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from metrology.check import Check
from metrology.message import said
from metrology.relaxation.blocks import Blocks
from metrology.relaxation.checks.done import FINAL, LATER, Done
from metrology.relaxation.evidence import SURE, Supported
from metrology.relaxation.test import RelaxationTest

DRIFT = "drift or relaxation"
REST = "rest before the ramp"
RESTS = 16
"""Means into which readings at rest are divided: a line through them leaves 14 degrees of freedom."""


def drift(done: Sequence[Done], found: Supported) -> Check:
    """Whether the readings distinguish a drift of the instrument from what the specimen does.

    A relaxation over more decades than the branches span is evenly slow too: a drift counts as one of the instrument
    only where it shows while nothing was held.
    """
    p = found.drift
    if p <= 1 - SURE:
        text = "No drift of the readings is supported (probability {p:.2g})."
        return Check(DRIFT, p, None, True, said(text, p=float(p)))
    if p < SURE and _is_significant(found):
        sentence = said(
            "A slow change goes on, and the readings do not decide whether the instrument drifted (probability "
            "{p:.2g}) or the specimen relaxes, or flows, more slowly than its branches: the equilibrium is another by "
            "each. Read the instrument unloaded for a while before the ramp and after a return.",
            p=float(p),
        )
        return Check(DRIFT, p, None, False, sentence, concerns=FINAL)
    if p < SURE:
        sentence = said(
            "The readings do not decide whether the instrument drifted (probability {p:.2g}): results are means over "
            "both. Read the instrument unloaded for a while before the ramp and after a return.",
            p=float(p),
        )
        return Check(DRIFT, p, None, False, sentence, covered=True)
    if all(drifts_at_rest(one) for one in done):
        text = "The readings drift evenly (probability {p:.3g}), before the ramp as well; the drift is taken off."
        return Check(DRIFT, p, None, True, said(text, p=float(p)))
    sentence = said(
        "An even drift fits the readings (probability {p:.3g}) and is taken off, but readings at rest alone do not "
        "show it: it may be a relaxation, or a flow, that goes on, and the equilibrium stiffness is then too high. "
        "Read the instrument unloaded for a while before the ramp and after a return.",
        p=float(p),
    )
    return Check(DRIFT, p, None, False, sentence)


def _is_significant(found: Supported) -> bool:
    """Whether the drift of the most probable form that has one is none of chance, in any specimen."""
    drifting = [at for at, form in enumerate(found.forms) if form.drift and not form.power]
    best = max(drifting, key=lambda at: float(found.probability[at]))
    fits = [of_specimen[best] for of_specimen in found.fits]
    return any(abs(one.values[1]) > _reach() * float(np.sqrt(one.covariance[1, 1])) for one in fits)


def drifts_at_rest(one: Done) -> bool:
    """Whether a line through the readings before the first ramp has a slope, and that of the drift that was fitted.

    Readings after a return to zero recover from the hold, and do not tell the instrument's drift from that.
    """
    best, of, still = one.best, one.scene.answer.of, _still(one)
    if not best.form.drift or still is None:
        return False
    duration = float(of.time[-1] - of.time[0])
    fitted, u_fitted = best.values[1] / duration, float(np.sqrt(best.covariance[1, 1])) / duration
    return still.p < 1 - 0.99 and abs(still.slope - fitted) < _reach() * float(np.hypot(still.u, u_fitted))


def _reach() -> float:
    """Standard uncertainties within which a slope at rest lies in 99 of 100 records."""
    from scipy.special import stdtrit

    return float(stdtrit(RESTS - 2, 0.995))


@dataclass(frozen=True)
class Still:
    """Line through what answered before the first ramp: slope, its u, its duration, and how likely none is so steep."""

    slope: float
    u: float
    duration: float
    p: float


def _still(one: Done) -> Still | None:
    """Fit the line to means of the readings in the metric of each colour, at the level of what it leaves.

    The colours have the probabilities that the whole record gives them. Student's distribution is exact for each.
    """
    from scipy.special import stdtr

    time = one.mounting.time - one.mounting.time[0]
    n = int((time < one.levels.before).sum())
    if n < RESTS:
        return None
    answer = one.mounting.force if one.scene.held == "elongation" else one.mounting.stretch
    start = np.linspace(0, n, RESTS + 1).astype(np.int64)
    t, y = (np.add.reduceat(channel[:n], start[:-1]) / np.diff(start) for channel in (time, answer))
    of = Blocks(start, t, t, y, time[start[:-1]], time[start[1:] - 1])
    roots = np.linalg.cholesky(one.noise.at(of))
    away = t - t.mean()
    white = np.linalg.solve(roots, np.column_stack([np.ones(RESTS), away / away[-1], y - y.mean()]))
    r = np.asarray(np.linalg.qr(white, mode="r"))
    # Triangular factor of [1, t, y]: slope = r₁₂/r₁₁, what is left is r₂₂.
    slopes = r[:, 1, 2] / r[:, 1, 1] / away[-1]
    own = np.abs(r[:, 2, 2] / r[:, 1, 1]) / np.sqrt(RESTS - 2) / away[-1]
    weights = one.best.weights
    p = float(weights @ (2 * stdtr(RESTS - 2, -np.abs(slopes) / np.maximum(own, 1e-300))))
    slope = float(weights @ slopes)
    u = float(np.sqrt(weights @ (own**2 + (slopes - slope) ** 2)))
    return Still(slope, u, float(t[-1] - t[0]), p)


def rest(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Whether what answered stands still before the first ramp: the model begins at rest.

    What a load before the record still relaxes by goes on after the ramp: it bars what is read later, and the
    instantaneous stiffness only where it amounts to more than the uncertainty of the step.
    """
    seen = [(still, one) for one in done if (still := _still(one)) is not None]
    if not seen:
        sentence = said("Not made: fewer than {count} readings before the first ramp.", count=RESTS)
        return Check(REST, None, None, None, sentence)
    # What drifts on is in the model.
    moving = [(still, one) for still, one in seen if not drifts_at_rest(one)]
    least, one = min(moving, key=lambda each: each[0].p, default=seen[0])
    part = abs(least.slope) * least.duration / (float(np.ptp(one.scene.answer.of.y)) or 1.0)
    p = test.adjusted(least.p, len(seen)) if moving else 1.0
    if p >= test.significance:
        sentence = said("What answered stood still before the first ramp, but for its noise.")
        return Check(REST, part, p, True, sentence)
    sentence = said(
        "What answered changes before the first ramp ({specimen}: by {part:.2g} % of its range), and does not go on "
        "so: the specimen was loaded before the record begins, and still relaxes. Unload it and wait, or begin the "
        "record before the first load.",
        specimen=one.mounting.name,
        part=100 * float(part),
    )
    return Check(REST, part, p, False, sentence, concerns=() if part > 2 * _step(one) else (*FINAL, *LATER))


def _step(one: Done) -> float:
    """Relative standard uncertainty of the instantaneous stiffness by the record; infinite where there is none."""
    if "r_0" not in one.names:
        return float("inf")
    at = one.names.index("r_0")
    return float(one.said.u[at] / abs(one.said.values[at]))
