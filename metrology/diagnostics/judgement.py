"""What the evidence says: how probable each effect is, what it carries, what no listed effect explains."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from metrology.diagnosis import Verdict
from metrology.diagnostics.families import compressed, families
from metrology.diagnostics.fits import COARSE, cost
from metrology.diagnostics.judged import FAR, LIKELY, Judged
from metrology.diagnostics.likelihood import common, weighted
from metrology.diagnostics.probability import logistic, normalised
from metrology.diagnostics.search import EQUAL, Search
from metrology.diagnostics.sets import NONE, Set, is_whole, without
from metrology.diagnostics.subject import Fit
from metrology.diagnostics.tails import either
from metrology.diagnostics.unlisted import law_beside, sharpened
from metrology.diagnostics.view import View

CERTAIN = 1.0 / (1.0 + math.exp(-EQUAL))
"""Probability from which on an effect, or its group, is named, against other sets and an unlisted law: 20 to 1."""


def judge(search: Search, base: Fit, first: View, view: View) -> Judged:
    """Weigh the sets around the best fit, and ask whether an unlisted law does as well."""
    last = view.fit
    others = {name: fit for name in last.effects
              if (fit := _fit_of(search, view, without(view.effects, name, search.beside))) is not None}  # fmt: skip
    exchanged = search.exchanged(view)
    weights = normalised(_evidence(search, view))
    forms = search.subject.families(last)
    sharper, floor = sharpened(search, view, forms)
    sharper, found = compressed(sharper, families(sharper, forms, last.used))
    listed = 1.0 / weights.get(view.effects, 1.0)
    law, unlisted, instead, lawful = law_beside(search, view, sharper, found, listed)
    needed = law is not None and law.log_bayes > FAR
    if search.subject.is_scarce and law is not None and law.log_bayes > EQUAL:
        # Beside a law that is there all the same, an effect is what is far larger than all the rest of it.
        sized = [one.of_one_size for one in found]
        *_, beside, with_effects = law_beside(search, view, sharper, sized, listed, given=unlisted)
        if min(beside.values(), default=1.0) <= logistic(-FAR):
            needed, instead, lawful = True, beside, with_effects
    tried = dict.fromkeys(name for one in weights for name in one)
    # Sums that no order of a set moves by a digit (`math.fsum`): another process has another one.
    probability = {name: math.fsum(w for one, w in weights.items() if name in one) for name in tried}
    probability = {name: p * (1 - instead.get(name, 0.0)) for name, p in probability.items()}
    likely = {name: p for name, p in probability.items() if p > 0}
    alike = _groups(last.effects, exchanged, weights)
    there = {name: math.fsum(likely.get(one, 0.0) for one in group) for name, group in alike.items()}
    # Where an unlisted law is needed all the same, a name has to do far better than another such law in its place.
    most = logistic(-FAR) if needed else LIKELY
    unsure = tuple(name for name, group in alike.items() if _any_of(weights, group) <= CERTAIN)
    replaced = tuple(name for name in last.effects if name not in unsure and instead.get(name, 0.0) > most)
    doubtful = (*unsure, *(name for name in alike if name not in (*unsure, *replaced) and there[name] <= CERTAIN))
    possible = tuple((one,) for name in doubtful if there[name] > LIKELY for one in alike[name])
    groups = tuple(group for name, group in alike.items() if name not in doubtful and len(group) > 1)
    if law is not None and search.subject.is_scarce:
        floor *= math.exp(-2 * max(law.log_bayes, 0.0) / max(last.count, 1))
    share = _gone(view, floor, base, last)
    carries = {name: min(_gone(view, floor, one, last) for one in _contained(search, fit))
               for name, fit in others.items()}  # fmt: skip
    named = [name for name in last.effects if name not in (*replaced, *doubtful)]
    remains = unlisted > LIKELY or view.noise.misfit > COARSE
    minor = tuple(name for name in named if remains and carries.get(name, 1.0) <= LIKELY)
    named = [name for name in named if name not in minor]
    likeliest = max(weights, key=lambda one: weights[one])
    known = share
    if remains and named and is_whole(frozenset(named), search.beside):
        # What an unlisted law may be as well is not explained, however much of the misfit it carries.
        alone = _fit_of(search, view, frozenset(named))
        known = share if alone is None else _gone(view, floor, base, alone)
    verdict = _verdict(search, view, known, unlisted, named, (*groups, *possible), likeliest)
    if verdict in ("ambiguous", "explained in the main"):
        groups = (*groups, *(possible if named or possible else ((name,) for name in doubtful)))
    if verdict == "unexplained":
        # An inclusion probability holds where the list is complete.
        complete = 1.0 - max(unlisted, 1.0 - share)
        probability = {name: p * complete for name, p in probability.items()}
    return Judged(
        base, last, first, view, verdict, probability, groups, carries, share, law, unlisted, replaced, others,
        exchanged, tuple(search.failed), weights, doubtful, tuple(search.kinds(view, exchanged)), lawful,
        minor, -math.expm1(-_tails(search, view, last)),
    )  # fmt: skip


def unextended(search: Search, base: Fit, first: View, why: str) -> Judged:
    """Outcome without an extension: something is missing, but no set of listed effects that was found is any better."""
    alone = replace(search, fits={NONE: base}, failed=[*search.failed, why])
    found = judge(alone, base, first, replace(first, evidence={NONE: 0.0}))
    return replace(found, verdict="unexplained")


def _verdict(
    search: Search,
    view: View,
    share: float,
    unlisted: float,
    named: Sequence[str],
    groups: Sequence[Sequence[str]],
    likeliest: Set,
) -> Verdict:
    remainder = unlisted > LIKELY or view.noise.misfit > COARSE
    if search.subject.loses(view.fit):
        return "not finished"
    if not named and not remainder and view.fit.effects:
        # Neither a listed effect nor an unlisted law is more probable than not, nor that nothing is missing.
        return "ambiguous"
    if not named:
        # Nothing is missing where no set of effects is more probable than none.
        return "unexplained" if remainder or likeliest else "nothing missing"
    if not remainder:
        return "ambiguous" if groups else "explained"
    return "unexplained" if share < LIKELY else "explained in the main"


def _fit_of(search: Search, view: View, effects: Set) -> Fit | None:
    """Fit of the model with some of its effects; None where the budget has none left for it."""
    if effects not in search.fits:
        if search.spent >= search.budget:
            return None
        fit = search.subject.fit(tuple(one for one in view.fit.effects if one in effects), [view.fit.values])
        search.spent += cost(fit)
        if fit is None:
            return None
        search.fits[effects] = fit
    return search.fits[effects]


def _contained(search: Search, fit: Fit) -> list[Fit]:
    """A fit and those of the sets that it contains: a search may end above these."""
    own = frozenset(fit.effects)
    return [fit, *(each for one, each in search.fits.items() if one < own and search.is_fitted(one))]


def _evidence(search: Search, view: View) -> dict[Set, float]:
    """Ln evidence of sets: of those that were fitted, as fitted; by the straight line, where nothing is taken out.

    A set without an effect of the model is believed where it was fitted only: the straight line ends where the effect
    is far from small. Where few readings say how they scatter, they may do so with heavy tails.
    """
    evidence = search.evidence(view)
    own = evidence[view.effects]
    tails = _tails(search, view, view.fit)
    found = {one: value + tails for one, value in evidence.items()
             if one >= view.effects and not 0 < value - own <= search.least(view)}  # fmt: skip
    for one, fit in search.fits.items():
        if search.is_fitted(one) and one != view.effects:
            found[one] = own + search.over(view, fit) + _tails(search, view, fit)
    return found


def _tails(search: Search, view: View, fit: Fit) -> float:
    """Ln evidence of a fit to few readings whose noise may have heavy tails, over that of normal noise."""
    return either(fit, view.table.among, search.rounding(fit)) if search.subject.is_scarce else 0.0


def _groups(
    effects: Sequence[str], exchanged: Mapping[tuple[str, str], tuple[Fit, float]], weights: Mapping[Set, float]
) -> dict[str, tuple[str, ...]]:
    """Each effect of the model with those that do as well in its place, beside the other effects or without them."""
    found = {}
    for name in effects:
        equal = sorted(((other, more) for (own, other), (_, more) in exchanged.items()
                        if own == name and more > -EQUAL),
                       key=lambda one: -one[1])  # fmt: skip
        group = (name, *(other for other, _ in equal))
        # One more that makes them certain: sets that lack some of the other effects count here as well.
        others = sorted({each for one in weights for each in one} - set(effects) - set(group))
        wider = max(((*group, other) for other in others), key=lambda one: _any_of(weights, one), default=group)
        found[name] = wider if _any_of(weights, group) <= CERTAIN < _any_of(weights, wider) else group
    return found


def _any_of(weights: Mapping[Set, float], group: Sequence[str]) -> float:
    """Probability that at least one of some effects is there."""
    return math.fsum(w for one, w in weights.items() if not one.isdisjoint(group))


def _gone(view: View, floor: float, before: Fit, after: Fit) -> float:
    """Part of the misfit of one fit that is gone with another: (χ₀² − χ²) / (χ₀² − χ² of everything that is known).

    Parameters
    ----------
    view : View
        Gives the colours of the noise.
    floor : float
        χ² that the full list and every unlisted law leave, raised by the degrees of freedom that they took beyond the
        model: what noise alone would leave.
    before, after : Fit
        The two.
    """
    used = common([before, after])
    plain = replace(view.noise, misfit=1.0)
    left = [max(weighted(one, plain, used) - floor, 0.0) for one in (before, after)]
    return float(np.clip(1.0 - left[1] / left[0], 0.0, 1.0)) if left[0] > 0 else 0.0
