"""Checks of what lies beyond the record: the stiffness at once and in equilibrium, and a DMA sweep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from metrology.check import Check
from metrology.message import said
from metrology.relaxation.checks.done import AT_ONCE, FINAL, Done
from metrology.relaxation.evidence import HALF, Supported
from metrology.relaxation.finding import Compared
from metrology.relaxation.test import RelaxationTest

START = "instantaneous stiffness"
DURATION = "duration"
BRANCHES = "number of branches"
DMA = "DMA sweep"
BOUND = 1.0
"""Longest relaxation time over the longest hold from which on what it leaves is not known to end: at it, 37 % of the
branch are still to come, and it bends off a line by less than it goes on."""
TO_COME = 0.02
"""Part of k by which it may still change after the record without its being an extrapolation."""

SWEEP = {
    (True, True): "{inside} of {count} frequencies lie in the range of the records: the largest |E_n| is {worst:.2g} "
    "({modulus} at {frequency:.3g} Hz).",
    (True, False): "{inside} of {count} frequencies lie in the range of the records: the largest |E_n| is {worst:.2g} "
    "({modulus} at {frequency:.3g} Hz), more than 1: sweep and hold do not show the same specimen.",
    (False, True): "{inside} of {count} frequencies lie in the range of the records; no uncertainty of the sweep is "
    "stated: the largest |E_n| is {worst:.2g} ({modulus} at {frequency:.3g} Hz).",
    (False, False): "{inside} of {count} frequencies lie in the range of the records; no uncertainty of the sweep is "
    "stated: the largest |E_n| is {worst:.2g} ({modulus} at {frequency:.3g} Hz), more than 1: sweep and hold do not "
    "show the same specimen.",
}
"""Whether the sweep states its uncertainty, and whether it agrees → what is said of it."""


def branches(test: RelaxationTest, found: Supported) -> Check:
    """Whether a further branch might have been supported: none was weighed beyond `branches`."""
    form = found.forms[found.best]
    if test.branches and not form.power and form.branches >= test.branches:
        sentence = said(
            "The most probable form has as many branches as were allowed ({count}): the readings may tell of more, and "
            "of an equilibrium that is lower. State more 'branches' (6 at most), or ask for the stiffness at a time "
            "('at').",
            count=test.branches,
        )
        return Check(BRANCHES, float(form.branches), None, False, sentence)
    sentence = said("The readings support fewer branches than were allowed.")
    return Check(BRANCHES, float(form.branches), None, True, sentence)


def start(done: Sequence[Done], found: Supported) -> Check:
    """Whether the stiffness at once is read or extrapolated: what relaxes faster than the ramp took is not seen."""
    if found.power > HALF:
        text = said("A power law has no instantaneous stiffness: none is given.")
        if done[0].scene.held == "load":
            text = said("A power law of creep has an instantaneous stiffness by its part that does not grow with time.")
        return Check(START, None, None, None, text)
    times = [float(np.exp(one.best.values[-1 - at])) for one in done for at in range(one.best.form.branches)]
    ramp = max(one.levels.ramp for one in done)
    fastest = min(times, default=np.inf)
    if fastest >= ramp:
        return Check(START, fastest, None, True, said("No branch is faster than the ramp."))
    sentence = said(
        "The fastest branch ({fastest:.2g} s) is faster than the ramp ({ramp:.2g} s): the instantaneous stiffness is "
        "extrapolated to times before its end, as if nothing faster followed. Load faster, or ask for the stiffness at "
        "a time ('at').",
        fastest=fastest,
        ramp=float(ramp),
    )
    return Check(START, fastest, None, False, sentence, concerns=AT_ONCE)


def duration(done: Sequence[Done], found: Supported) -> Check:
    """Whether the equilibrium is read or extrapolated: what is still to come after the last hold."""
    if found.power > HALF:
        sentence = said("A power law has no equilibrium: no equilibrium stiffness is given.")
        return Check(DURATION, None, None, None, sentence)
    worst, name = 0.0, ""
    for one in done:
        held = max((each.duration for each in one.levels.held), default=0.0)
        form = one.best.form
        if form.power:
            continue
        end = float(one.times[:, 2].max(initial=0.0))
        if end > BOUND * held:
            sentence = said(
                "The slowest branch of {specimen} is not bounded by the record: its time reaches {end:.2g} s, the "
                "longest hold {held:.4g} s. A steady flow, or a drift, would look the same: there is no equilibrium "
                "stiffness to rely on. Hold for longer, or ask for the stiffness at a time ('at').",
                specimen=one.mounting.name,
                end=end,
                held=float(held),
            )
            return Check(DURATION, end, None, False, sentence, concerns=FINAL)
        now, final = one.scene.at(form, one.best.values, np.array([held]))[0], one.scene.final(form, one.best.values)
        left = abs(float(now) / final - 1)
        if left >= worst:
            worst, name = left, one.mounting.name
    if worst > TO_COME:
        sentence = said(
            "The equilibrium is extrapolated: after the longest hold {part:.2g} % of its stiffness are still to come "
            "({specimen}), if no slower branch follows. Hold for longer, or ask for the stiffness at a time ('at').",
            part=100 * float(worst),
            specimen=name,
        )
        return Check(DURATION, worst, None, False, sentence, concerns=FINAL)
    text = "At the end of the longest hold at most {part:.2g} % of the equilibrium stiffness are still to come."
    return Check(DURATION, worst, None, True, said(text, part=100 * float(worst)))


def sweep(dma: Sequence[Compared]) -> Check:
    """E_n of storage and loss modulus at the frequencies that the records support."""
    seen = [(abs(en), word, one.frequency) for one in dma
            for en, word in ((one.storage_en, "E′"), (one.loss_en, "E″")) if en is not None]  # fmt: skip
    if not seen:
        sentence = said("Not made: no frequency of the sweep lies in the range that the records support.")
        return Check(DMA, None, None, None, sentence)
    worst, word, frequency = max(seen)
    inside = sum(one.storage_en is not None for one in dma)
    stated, passed = all(one.storage_u is not None for one in dma), worst <= 1.0
    sentence = said(
        SWEEP[stated, passed],
        inside=inside,
        count=len(dma),
        worst=float(worst),
        modulus=word,
        frequency=float(frequency),
    )
    return Check(DMA, worst, None, passed, sentence)
