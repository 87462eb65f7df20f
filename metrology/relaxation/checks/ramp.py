"""Check of the ramp: whether the answer is proportional to the input there, as superposition supposes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from metrology.check import Check
from metrology.message import said
from metrology.relaxation.checks.done import AT_ONCE, FINAL, LATER, Bends, Done, Seen
from metrology.relaxation.ramps import CHANGE, bend
from metrology.relaxation.test import RelaxationTest

RAMP = "linearity on the ramp"
TEN = 10.0
"""Times of a ramp after which its course no longer counts (ten-times rule: Lee & Knauss, Mech. Time-Depend. Mater. 4
(2000) 1)."""


def bent(test: RelaxationTest, done: Sequence[Done]) -> Bends:
    """Ramps on which a changing stiffness is significant, and amounts to more than `CHANGE`.

    Odds that none makes as large as 1/p have at most the probability p (Markov's inequality: their mean is 1).
    """
    each = [bend(one.scene, one.best, one.noise, one.levels, one.mounting.time - one.mounting.time[0]) for one in done]
    judged = sum(one is not None for one in each)
    found = [1.0 if one is None else test.adjusted(float(np.exp(-max(one.odds, 0.0))), judged) for one in each]
    names = [one.mounting.name for one, p, seen in zip(done, found, each, strict=True)
             if seen is not None and p < test.significance and abs(seen.whole) > CHANGE]  # fmt: skip
    return Bends(tuple(each), frozenset(names), min(found, default=1.0))


def ramp(test: RelaxationTest, seen: Seen) -> Check:
    """What was found of the ramps, and from which time on results do not depend on them."""
    bends = seen.bends
    known = [(found, one) for found, one in zip(bends.each, seen.whole, strict=True) if found is not None]
    if not known:
        sentence = said("Not made: several levels, or too few readings on the ramp.")
        return Check(RAMP, None, None, None, sentence)
    found, one = max(known, key=lambda each: (each[1].mounting.name in bends.names, each[0].odds))
    if not bends.names:
        sentence = said("On the ramp what answered is proportional to what was imposed, but for what relaxed.")
        return Check(RAMP, found.whole, bends.p, True, sentence)
    late = TEN * max(each.levels.ramp for each in seen.whole)
    sentence = said(
        "{specimen} is not linear on the ramp: where half of the input was imposed, {read:.2g} % of the answer at its "
        "end were read, and {linear:.2g} % by the most probable form. Superposition with one modulus does not hold "
        "there, so that the ramp is left out of the fit. What is read later than ten times the ramp ({late:.3g} s) is "
        "the stiffness at this level; there is none at once. Ask for a time ('at') after that, hold for longer, or "
        "ramp faster. Look for slack too: it bends the ramp as well.",
        specimen=one.mounting.name,
        read=100 * found.read,
        linear=100 * found.linear,
        late=float(late),
    )
    hold = min(max((each.duration for each in one.levels.held), default=0.0) for one in seen.whole)
    barred = [*AT_ONCE, "relaxed"]
    barred += [] if test.at is not None and test.at >= late else LATER
    barred += [] if hold >= late else FINAL
    return Check(RAMP, found.whole, bends.p, False, sentence, concerns=tuple(dict.fromkeys(barred)))
