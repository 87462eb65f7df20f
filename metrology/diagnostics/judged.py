"""Outcome of a diagnosis, before it is put into words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from metrology.diagnosis import Verdict
from metrology.diagnostics.laws import Law
from metrology.diagnostics.sets import NEGLIGIBLE, Set
from metrology.diagnostics.subject import Fit
from metrology.diagnostics.view import View

LIKELY = 0.5
"""Probability from which on an effect is in the model (median probability model; Barbieri & Berger, Ann. Statist. 32
(2004) 870), and share of the misfit from which on a model explains it, or one of its effects: more than half."""
FAR = 5.0
"""Difference in ln evidence that decides: 150 to 1, 'very strong' of Kass & Raftery (see `search.EQUAL`)."""


@dataclass(frozen=True)
class WithLaw:
    """An unlisted law with a part of the effects of a model.

    Parameters
    ----------
    kept : set of str
        Effects that are still there.
    values : mapping of str to (float, float)
        Unknowns with their standard uncertainties.
    log_evidence : float
        Ln evidence over that of the model.
    """

    kept: Set
    values: Mapping[str, tuple[float, float]]
    log_evidence: float


@dataclass(frozen=True)
class Judged:
    """Outcome of a diagnosis, before it is put into words.

    Parameters
    ----------
    base, last : Fit
        The model as stated, and with the set of effects that has the most evidence.
    first, view : View
        Straight lines through the two.
    verdict : str
        Step of the ladder.
    probability : mapping of str to float
        Inclusion probability of every effect that was looked at.
    groups : tuple of tuple of str
        Effects that these data cannot tell apart, the most probable first; an effect alone where they do not decide
        whether it is there: it is more probable than not, or the only model that there is.
    carries : mapping of str to float
        For each effect of the model: part of what is left without it that it takes away.
    share : float
        Part of the misfit of the stated model that the effects explain.
    law : Law or None
        Unlisted law that explains most of what is left, and with `unlisted` its probability.
    replaced : tuple of str
        Effects of the model in whose place an unlisted law would do as well.
    others : mapping of str to Fit
        For each effect of the model: the model without it.
    exchanged : mapping of (str, str) to (Fit, float)
        For an effect of the model and another in its place: that fit, and its ln evidence over the model's.
    failures : tuple of str
        What could not be fitted.
    weights : mapping of set of str to float
        Probability of every set of effects.
    doubtful : tuple of str
        Effects of the model that are not named, since they and those that do as well are not certain.
    kinds : tuple of (str, Fit, float)
        Effect of the model that is there in another kind, or in whose place another is; that fit, and its ln evidence
        over the model's.
    lawful : tuple of WithLaw
        What an unlisted law says that the data do not rule out.
    minor : tuple of str
        Effects of the model that carry less than what remains: certain, but not named.
    heavy : float
        Probability that noise of few readings has heavy tails.
    """

    base: Fit
    last: Fit
    first: View
    view: View
    verdict: Verdict
    probability: Mapping[str, float]
    groups: tuple[tuple[str, ...], ...]
    carries: Mapping[str, float]
    share: float
    law: Law | None
    unlisted: float
    replaced: tuple[str, ...]
    others: Mapping[str, Fit]
    exchanged: Mapping[tuple[str, str], tuple[Fit, float]]
    failures: tuple[str, ...] = ()
    weights: Mapping[Set, float] = field(default_factory=dict)
    doubtful: tuple[str, ...] = ()
    kinds: tuple[tuple[str, Fit, float], ...] = ()
    lawful: tuple[WithLaw, ...] = ()
    minor: tuple[str, ...] = ()
    heavy: float = 0.0

    @property
    def nothing(self) -> float:
        """Probability that no listed effect is missing."""
        return float(self.weights.get(frozenset(), 0.0))

    @property
    def is_extended(self) -> bool:
        """Whether there is a model beside the stated one."""
        return bool(self.last.effects) and self.verdict != "not finished"

    @property
    def misfit(self) -> float:
        """λ at the end: what no model explains, over the noise, where the unknowns act."""
        return self.view.noise.misfit

    @property
    def is_certain(self) -> bool:
        """Whether something besides what is named is missing for certain, whatever it is."""
        undecided = {group[0] for group in self.groups if len(group) == 1}
        named = {*self.last.effects, *(name for group in self.groups for name in group)} - undecided
        return math.fsum(w for one, w in self.weights.items() if one <= named) < NEGLIGIBLE

    def is_named(self, effect: str) -> bool:
        """Whether an effect of the model is given as a cause."""
        return (
            effect in self.last.effects
            and self.verdict not in ("not finished", "unexplained")
            and effect not in (*self.replaced, *self.doubtful, *self.minor)
        )
