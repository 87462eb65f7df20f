"""What the evidence says: how probable each effect is, what it carries, what no listed effect explains."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from metrology.diagnosis import Verdict
from metrology.diagnostics.laws import Family, Few, Law, compressed, estimates, families, of_families, together
from metrology.diagnostics.likelihood import (
    Line,
    Noise,
    base_places,
    common,
    effect_places,
    line,
    misfit,
    narrow,
    orthonormal,
    weighted,
)
from metrology.diagnostics.search import COARSE, EQUAL, Search, View, cost
from metrology.diagnostics.sets import (
    INVISIBLE,
    NEGLIGIBLE,
    NONE,
    Scarce,
    Set,
    is_whole,
    log_likelihood,
    log_prior,
    without,
)
from metrology.diagnostics.subject import Direction, Fit
from metrology.diagnostics.tails import either
from metrology.noise import Colour

Model = TypeVar("Model", Set, Set | None)
LIKELY = 0.5
"""Probability from which on an effect is in the model (median probability model; Barbieri & Berger, Ann. Statist. 32
(2004) 870), and share of the misfit from which on a model explains it, or one of its effects: more than half."""
CERTAIN = 1.0 / (1.0 + math.exp(-EQUAL))
"""Probability from which on an effect, or its group, is named, against other sets and an unlisted law: 20 to 1."""
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


def judge(search: Search, base: Fit, first: View, view: View) -> Judged:
    """Weigh the sets around the best fit, and ask whether an unlisted law does as well."""
    last = view.fit
    others = {name: fit for name in last.effects
              if (fit := _fit_of(search, view, without(view.effects, name, search.beside))) is not None}  # fmt: skip
    exchanged = search.exchanged(view)
    weights = _normalised(_evidence(search, view))
    forms = search.subject.families(last)
    sharper, floor = _sharper(search, view, forms)
    sharper, found = compressed(sharper, families(sharper, forms, last.used))
    listed = 1.0 / weights.get(view.effects, 1.0)
    law, unlisted, instead, lawful = _unlisted(search, view, sharper, found, listed)
    needed = law is not None and law.log_bayes > FAR
    if search.subject.is_scarce and law is not None and law.log_bayes > EQUAL:
        # Beside a law that is there all the same, an effect is what is far larger than all the rest of it.
        sized = [one.of_one_size for one in found]
        *_, beside, with_effects = _unlisted(search, view, sharper, sized, listed, given=unlisted)
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


def _normalised(evidence: Mapping[Model, float]) -> dict[Model, float]:
    top = max(evidence.values())
    weights = {one: math.exp(max(value - top, -700.0)) for one, value in evidence.items()}
    total = math.fsum(weights.values())
    return {one: value / total for one, value in weights.items()}


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


# ---- unlisted laws ------------------------------------------------------------------------------------------------
def _sharper(search: Search, view: View, forms: Sequence[Direction]) -> tuple[Line, float]:
    """Line of the model in a metric to whose misfit the unlisted laws do not count, and what noise alone leaves."""
    fit = view.fit
    if search.subject.is_scarce:
        cost = weighted(fit, view.noise, fit.used) + search.rounding(fit)
        level = math.sqrt(cost / max(fit.count - view.line.base.shape[1], 1))
        channels = {one.name: Colour(level, np.array([1.0 / level])) for block in fit.problem.blocks
                    for one in block.segments}  # fmt: skip
        return _in_shape(line(fit, search.subject.candidates, (), Noise(channels), fit.used), search), cost
    whole = _beside_lines(search, view, forms)
    every, left = whole.explained_with([one.rows for one in families(whole, forms, fit.used)])
    sought = np.hstack([whole.base, *(one.rows for one in whole.columns if one.direction is None)])
    least = min(misfit(whole, sought, (every, left)), view.noise.misfit)
    # χ² that everything that is known leaves of the readings, as if nothing but noise had been fitted.
    return whole.with_misfit(least), float(left @ left + every.width - orthonormal(sought).shape[1])


def _in_shape(found: Line, search: Search) -> Line:
    """Line of a fit to few readings with its effects in the shapes that were found: far off, no shape is straight."""
    unknowns, candidates = found.fit.problem.unknowns, search.subject.candidates
    columns = []
    for one in found.columns:
        shapes = {size.name for size in candidates[one.effect].parameters if size.shape}
        places, _ = effect_places(found.fit, candidates[one.effect])
        away = [at for at, place in enumerate(places) if unknowns[place].name.split("@")[0] in shapes]
        columns.append(replace(one, rows=np.delete(one.rows, away, axis=1)))
    return replace(found, columns=tuple(columns))


def _beside_lines(search: Search, view: View, forms: Sequence[Direction]) -> Line:
    """Line of a view with a misfit of 1, where the noise about unlisted lines is that of each record there."""
    whole = view.line.with_misfit(1.0)
    lines = [one.rows for one in families(whole, [one for one in forms if one.is_line], view.fit.used)]
    beside = narrow(whole, lines, view.noise.misfit)
    if not beside:
        return whole
    by = replace(whole.noise, narrow=(*whole.noise.narrow, *beside))
    tried = [one.direction for one in whole.columns if one.direction is not None]
    return line(view.fit, search.subject.candidates, tried, by, view.fit.used)


def _unlisted(
    search: Search, view: View, sharper: Line, found: Sequence[Family], listed: float, given: float | None = None
) -> tuple[Law | None, float, dict[str, float], tuple[WithLaw, ...]]:
    """Best unlisted law, its probability together with any effects of the model, and for each that of a law instead.

    Last the unknowns of the base with a law and every part of the model. Only a law of one quantity takes the place of
    an effect, and only where the readings do not refute it. `listed`: evidence of all sets of listed effects over that
    of the model, each of which a law may be beside as well as beside the model. `given`: probability that a law is
    there, where it is known: all else is asked of the models with one.
    """
    table, own, free = view.table, view.effects, view.table.free
    simple = [family for family in found if family.is_simple]
    evidence: dict[Set, float] = {}
    laws: dict[Set, list[Law]] = {}
    # In the metric of the sharper line, which has one level of noise where readings are few.
    level = next((one.level for one in sharper.noise.channels.values()), 1.0)
    rounding = table.rounding / level**2
    scarce = None if free is None else Scarce(free, free / level**2)
    for one in _parts(view.fit.effects, search.beside):
        wide = sum(table.members[name].ways for name in one)
        few = None if scarce is None else Few(scarce, wide, rounding)
        laws_of, squares = of_families(sharper, simple, one, few)
        if not laws_of:
            return None, 0.0, {}, ()
        law = together(laws_of)
        prices = math.fsum(table.members[name].price for name in one)
        likely = log_likelihood(squares + rounding, scarce, wide) - prices
        if one == own:
            # A fit ends above its straight line where a size is pressed against a bound.
            reached = max(squares + rounding, sharper.count - sharper.base.shape[1]) if scarce else squares
            alone_squares = squares
            alone = log_likelihood(reached, scarce, wide) - prices + log_prior(len(one), table.among + 1)
            every, _ = of_families(sharper, found, one, few)
            whole = together(every)
            beside = likely + whole.log_bayes + log_prior(len(one) + 1, table.among + 1) - alone
        elif free is None and _refuted(sharper, squares - law.gone):
            continue
        evidence[one] = likely + law.log_bayes + log_prior(len(one) + 1, table.among + 1)
        laws[one] = laws_of
    # Of the model without a law, that is.
    over = {one: value - alone for one, value in evidence.items()}
    others = listed if given is None else 0.0
    instead_of = _probabilities(over, others)
    instead = {name: math.fsum(w for one, w in instead_of.items() if name not in one) for name in own}
    laws[own] = every
    everywhere = {**over, own: beside + math.log(listed)}
    unlisted = math.fsum(_probabilities(everywhere, others).values())
    # Of few readings, the unknowns are those of the models that can be given, not of all sets like one of them.
    over = everywhere if free is None else {**over, own: beside}
    weights = _probabilities(over, others)
    if given is not None:
        odds = math.log(given) - math.log(max(1.0 - given, 1e-300)) + math.log(listed)
        over = {one: math.log(max(w, 1e-300)) + odds for one, w in weights.items()}
    fitted = [(one, law, over[one] + math.log(part)) for one, w in weights.items() if w > NEGLIGIBLE
              for law, part in zip(laws[one], _shares(laws[one]), strict=True) if w * part > NEGLIGIBLE]  # fmt: skip
    if free is not None:
        fitted = [each for each in fitted if not _has(sharper, each[1], each[0])] or fitted
    if free is None and _refuted(sharper, alone_squares - whole.gone):
        # Of laws that all leave more than noise none is true: each that carries much is a guess, as good as it carries.
        fitted = [(own, law, beside + math.log(law.gone)) for law in every if law.log_bayes > FAR] or fitted
    lawful = tuple(WithLaw(one, _named_values(search, sharper, one, law), more) for one, law, more in fitted)
    return whole, unlisted, instead, lawful


def _has(sharper: Line, law: Law, kept: Set) -> bool:
    """Whether a law can be one of some effects: such an effect beside it would be of any size, and k with it."""
    taken = orthonormal(np.hstack([sharper.base, law.rows]))
    own = (one.rows for one in sharper.columns if one.direction is None and one.effect in kept)
    left = ((rows, rows - taken @ (taken.T @ rows)) for rows in own)
    return any(np.linalg.norm(after) <= INVISIBLE * np.linalg.norm(rows) for rows, after in left)


def _shares(laws: Sequence[Law]) -> list[float]:
    """Part that each family has in the evidence of all."""
    from scipy.special import softmax

    return [float(share) for share in softmax([law.log_bayes for law in laws])]


def _refuted(sharper: Line, left: float) -> bool:
    """Whether a law leaves of the readings what is no noise: χ² in the metric of a line, over that of the noise."""
    return bool(left * sharper.noise.misfit > COARSE * (sharper.count - sharper.base.shape[1]))


def _probabilities(over: Mapping[Set, float], others: float) -> dict[Set, float]:
    """Probability of each of some models beside others, of whose evidence together that of the models is given over."""
    found = _normalised({None: math.log(others), **over} if others > 0 else {**over})
    return {one: w for one, w in found.items() if one is not None}


def _named_values(search: Search, sharper: Line, kept: Set, law: Law) -> dict[str, tuple[float, float]]:
    """Unknowns of the base with some effects and a law, and their standard uncertainties, by name.

    The straight part of a law is as large as the rest of it, for all that the readings say, and is in k or c.
    """
    shift, u = estimates(sharper, kept, law)
    places = base_places(sharper.fit, search.subject.candidates)
    unknowns, theta = sharper.fit.problem.unknowns, sharper.fit.theta
    return {(name := unknowns[at].name): (float(theta[at] + moved), math.hypot(own, law.off.get(name, 0.0)))
            for at, moved, own in zip(places, shift, u, strict=True)}  # fmt: skip


def _parts(effects: Sequence[str], beside: Mapping[str, str]) -> list[Set]:
    """Every set of some effects, each beside what it needs."""
    every = (frozenset(one) for count in range(len(effects) + 1) for one in combinations(effects, count))
    return [one for one in every if is_whole(one, beside)]


def logistic(odds: float) -> float:
    """Probability of odds that are given by their logarithm."""
    return 1.0 / (1.0 + math.exp(-min(max(odds, -700.0), 700.0)))
