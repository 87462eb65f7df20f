"""Two candidates that promise more together than one at a time, as where each takes back what the other does."""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import replace

import numpy as np

from metrology.diagnose.linear import Score, Screen

TOGETHER = 0.98
"""Cosine of two directions beyond which they are not sought together."""
MOST = 4
"""Pairs that are fitted."""


def promising(scores: Screen, signed: Container[str], least: float) -> list[tuple[Score, Score]]:
    """Pairs of different candidates, in their best shapes, with the amounts (`factor`) that the data ask for of both.

    Amounts w in units of d from [[1, r], [r, 1]]·w = z, r the cosine of two directions, take up zᵀ·w of χ². Stated
    inputs, and what acts in several ways, such as a hum, take no part.

    Parameters
    ----------
    scores : Screen
        At a model that has neither.
    signed : container of str
        Candidates that may act either way.
    least : float
        χ² that a pair has to take up beyond the better one of the two.
    """
    places = [
        at
        for at, one in enumerate(scores.scores)
        if len(one.factors) == 1 and one.d > 0 and one.direction.stated is None
    ]
    plain = [scores.scores[at] for at in places]
    z = np.array([math.copysign(one.z, one.factor) for one in plain])
    r = scores.cosines[np.ix_(places, places)]
    apart = np.abs(r) < TOGETHER
    w = np.where(apart, z[:, None] - r * z, 0.0) / np.where(apart, 1 - r**2, 1.0)
    promise = np.triu(w * z[:, None] + w.T * z, 1)
    either = np.array([one.direction.effect in signed for one in plain], dtype=bool)
    allowed = apart & ((w >= 0) | either[:, None]) & ((w.T >= 0) | either)
    promise[~allowed | (promise < np.maximum(z[:, None] ** 2, z**2) + least)] = 0.0
    found: dict[tuple[str, str], tuple[Score, Score]] = {}
    for i, j in np.argwhere(promise > 0)[np.argsort(-promise[promise > 0], kind="stable")]:
        names = (plain[i].direction.effect, plain[j].direction.effect)
        if len(found) < MOST and names not in found and names[0] != names[1]:
            one, other = plain[i], plain[j]
            found[names] = (
                replace(one, factor=float(w[i, j]) / one.d),
                replace(other, factor=float(w[j, i]) / other.d),
            )
    return list(found.values())
