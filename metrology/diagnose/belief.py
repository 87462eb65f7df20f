"""What to believe of rivals: which do equally well, whether they say the same, and how probable each of them is."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from metrology.diagnose.evidence import log_bayes
from metrology.diagnose.selection import PAYS, Rival
from metrology.diagnose.subject import Fit, Subject
from metrology.diagnosis import Test

MANY, ALIKE = 4, 5.0
"""So many causes that do equally well are no group unless they say the same within so many standard deviations."""
KINDS = 4
"""Kinds of one effect that are compared; more are places, of which the best stands for its neighbours."""
TWIN = 0.1
"""Standard deviations within which two models are one by two names."""
UNKNOWN = 0.02
"""Probability beforehand of a cause that is in no table."""


def alike(group: tuple[Rival, ...]) -> bool:
    """Whether all of a group say the same of the readings; else they only happen to do equally well."""
    return all(_apart(group[0].fit, other.fit) < ALIKE for other in group[1:])


def apart(group: tuple[Rival, ...]) -> int:
    """How many of a group are models of their own: what says the same by another name counts once."""
    own = [at for at, one in enumerate(group) if all(_apart(other.fit, one.fit) > TWIN for other in group[:at])]
    return len(own)


def _apart(one: Fit, other: Fit) -> float:
    """Distance between what two models say of the readings, in standard deviations."""
    parts = zip(one.full, other.full, one.used, other.used, strict=True)
    return math.sqrt(sum(float(np.sum((a - b)[mine & yours] ** 2)) for a, b, mine, yours in parts))


def equal(slot: tuple[Rival, ...]) -> tuple[Rival, ...]:
    """Return the best of a place, and what is better than none and so near to it that these data prefer neither."""
    close = [one for one in slot[1:] if one.log_bayes > slot[0].log_bayes - PAYS and one.log_bayes > 0]
    return (*slot[:1], *close)


def open_kinds(subject: Subject, rival: Rival) -> list[tuple[Fit, float]]:
    """Fits of an effect in its other kinds, such as another law of creep, each with its ln evidence over the best."""
    table, found = subject.candidates, []
    for size in table[rival.effect].parameters:
        if not size.held or size.high - size.low > KINDS or size.name not in rival.fit.values:
            continue
        for kind in size.places:
            if kind == round(rival.fit.values[size.name]):
                continue
            fit = subject.fit(rival.fit.effects, [{**rival.fit.values, size.name: float(kind)}])
            if fit is not None and (better := log_bayes(table, rival.fit, fit)) > -PAYS:
                found.append((fit, better))
    return found


def probabilities(slot: tuple[Rival, ...], nobody: float) -> list[float]:
    """Probability of each rival against the others and against none, all equally probable beforehand."""
    logs = np.array([0.0, *(min(rival.log_bayes, 1e300) for rival in slot)])
    weights = np.exp(logs - logs.max())
    return [float((1 - nobody) * weight) for weight in weights[1:] / weights.sum()]


def unknown(tests: Sequence[Test]) -> float:
    """Probability that the cause is one that nobody thought of, from what the extension leaves.

    No table holds every cause: two in a hundred beforehand. A p-value of what is left speaks for more of it by at most
    −1/(e·p·ln p) (Sellke, Bayarri & Berger, Am. Statist. 55 (2001) 62).
    """
    left = [one.p_value for one in tests if one.name.endswith("after extension")]
    p = max(min(left, default=1.0), 1e-12)
    odds = UNKNOWN / (1 - UNKNOWN) * (-1 / (math.e * p * math.log(p)) if p < 1 / math.e else 1.0)
    return odds / (1 + odds)
