"""Checks of what was imposed: whether a level was held, and the time that was asked for lies in a hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from metrology.check import Check
from metrology.message import counted, said
from metrology.relaxation.checks.done import LATER, Done
from metrology.relaxation.course import FINE
from metrology.relaxation.course import MOST as PIECES
from metrology.relaxation.test import RelaxationTest
from metrology.relaxation.unlike import Unlike, several, unlike

LEVELS = "held levels"
ASKED = "time asked for"
LINEAR = "linearity over the levels"
HOLD = 3.0
"""Times of a ramp that a level has to be held: a course that is shorter is that of the ramp."""
CHANGE = 10.0
"""Standard deviations of a reading by which the input has to change."""
EDGE = 0.02
"""Part of a hold by which a time may lie beyond its end, or of a ramp before: ends are known to a block of readings."""


def levels(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Whether something was held: for several times as long as the ramp to it."""
    still = [one.mounting.name for one in done if _rests(test, one)]
    if still:
        text = "The input does not change beyond its noise: no ramp in the record of {specimens:comma}."
        sentence = said(text, specimens=tuple(still))
        return Check(LEVELS, None, None, False, sentence)
    rough = [one.mounting.name for one in done if not one.whole]
    if rough:
        sentence = said(
            "The course of the input has more corners than the {count} pieces that are taken: {specimens:comma}. What "
            "was imposed is not known well enough. Hold fewer levels in one record, or state the instrument's "
            "'resolution' where its steps are read as corners.",
            count=PIECES,
            specimens=tuple(rough),
        )
        return Check(LEVELS, None, None, False, sentence)
    short = [one.mounting.name for one in done
             if not any(each.duration >= HOLD * one.levels.ramp for each in one.levels.held)]  # fmt: skip
    if short:
        sentence = said(
            "No level was held for {times:.0f} times as long as the ramp to it: {specimens:comma}. Ramp faster, or "
            "hold for longer.",
            times=HOLD,
            specimens=tuple(short),
        )
        return Check(LEVELS, None, None, False, sentence)
    most = max(len(one.levels.held) for one in done)
    off = max(each.range / (float(np.ptp(one.scene.answer.of.u)) or 1.0) for one in done for each in one.levels.held)
    off = max(off, FINE)  # what is less is rounding
    one_level = (
        "{count} level was held within {off:.2g} % of the range of the input; what it moved meanwhile is in the model."
    )
    many = (
        "Up to {count} levels were held within {off:.2g} % of the range of the input; what it moved meanwhile is in "
        "the model."
    )
    sentence = counted(one_level, many, most, off=100 * float(off))
    return Check(LEVELS, None, None, True, sentence)


def _rests(test: RelaxationTest, one: Done) -> bool:
    """Whether the course of the input does not stand out of the noise of its readings."""
    u = one.mounting.stretch if test.held == "elongation" else one.mounting.force
    scatter = float(np.median(np.abs(np.diff(u)))) / 0.9539
    return float(np.ptp(one.scene.answer.of.u)) < CHANGE * scatter


def linear(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Whether the answer is proportional to the level: of a stiffness that is not, the results are a mean over levels.

    Odds that none makes as large as 1/p have at most the probability p (Markov's inequality: their mean is 1).
    """
    seen: list[tuple[Unlike, str]] = []
    for one in done:
        if several(one.levels, one.scene.answer.of.u):
            time = one.mounting.time - one.mounting.time[0]
            seen.append((unlike(one.scene, one.best, one.noise, time), one.mounting.name))
    if not seen:
        sentence = said("Not made: one level alone does not show whether the stiffness depends on it.")
        return Check(LINEAR, None, None, None, sentence)
    most, name = max(seen, key=lambda each: each[0].odds)
    p = test.adjusted(float(np.exp(-max(most.odds, 0.0))), len(seen))
    # Of a held load the compliance changes.
    sign = 1.0 if test.held == "elongation" else -1.0
    changes = _changes(test, most)
    if p >= test.significance:
        text = "The answer is proportional to the level (from rest to the highest level {changes}; {specimen})."
        return Check(LINEAR, most.whole, p, True, said(text, changes=changes, specimen=name))
    kind = "stiffens" if sign * most.whole > 0 else "softens"
    kind = kind if abs(most.whole) > 2 * most.whole_u else "relaxes"
    return Check(LINEAR, most.whole, p, False, said(UNLIKE[kind], changes=changes, specimen=name))


UNLIKE = {
    "stiffens": "{specimen} stiffens as the level rises: from rest to the highest level {changes}. It is not linear "
    "viscoelastic; k_0, k_inf and the relaxed part are those of no level, but between them. Evaluate one level in each "
    "test.",
    "softens": "{specimen} softens as the level rises: from rest to the highest level {changes}. It is not linear "
    "viscoelastic; k_0, k_inf and the relaxed part are those of no level, but between them. Evaluate one level in each "
    "test.",
    "relaxes": "{specimen} relaxes otherwise as the level rises: from rest to the highest level {changes}. It is not "
    "linear viscoelastic; k_0, k_inf and the relaxed part are those of no level, but between them. Evaluate one level "
    "in each test.",
}
"""What a specimen does that is not linear."""
CHANGES = {
    "elongation": "its stiffness by ({whole:+.2g} ± {whole_u:.1g}) %",
    "load": "its compliance by ({whole:+.2g} ± {whole_u:.1g}) %",
}
RELAXES = {
    "elongation": "its stiffness by ({whole:+.2g} ± {whole_u:.1g}) %, what relaxes by ({part:+.2g} ± {part_u:.1g}) % "
    "beyond that",
    "load": "its compliance by ({whole:+.2g} ± {whole_u:.1g}) %, what relaxes by ({part:+.2g} ± {part_u:.1g}) % beyond "
    "that",
}
"""What changes with the level, by what is held; where something relaxes, that too."""


def _changes(test: RelaxationTest, most: Unlike) -> str:
    whole, whole_u = 100 * float(most.whole), 100 * float(most.whole_u)
    if not np.isfinite(most.part):
        return said(CHANGES[test.held], whole=whole, whole_u=whole_u)
    part, part_u = 100 * float(most.part), 100 * float(most.part_u)
    return said(RELAXES[test.held], whole=whole, whole_u=whole_u, part=part, part_u=part_u)


def asked(at: float, done: Sequence[Done]) -> Check:
    """Whether the time that was asked for lies between the longest ramp and the longest hold of every specimen."""
    ramp = max(one.levels.ramp for one in done)
    hold = min(max((each.duration for each in one.levels.held), default=0.0) for one in done)
    if ramp * (1 - EDGE) <= at <= hold * (1 + EDGE):
        text = "{at:.4g} s lie between the longest ramp ({ramp:.3g} s) and the end of the longest hold ({hold:.4g} s)."
        return Check(ASKED, at, None, True, said(text, at=float(at), ramp=float(ramp), hold=float(hold)))
    before = (
        "The stiffness at {at:.4g} s is extrapolated: that is before the end of the longest ramp ({ramp:.3g} s), and "
        "what follows there was not read. Ask for a time that the record holds, or hold for longer."
    )
    after = (
        "The stiffness at {at:.4g} s is extrapolated: that is after the longest hold ({hold:.4g} s), and what follows "
        "there was not read. Ask for a time that the record holds, or hold for longer."
    )
    sentence = said(before if at < ramp else after, at=float(at), ramp=float(ramp), hold=float(hold))
    return Check(ASKED, at, None, False, sentence, concerns=LATER)
