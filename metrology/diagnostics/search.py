"""Search for the set of effects with the most evidence: always an answer, and it knows what it did not try."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property

from scipy.special import logsumexp

from metrology.diagnostics.likelihood import Noise, common, slow_motion, weighted
from metrology.diagnostics.line import line
from metrology.diagnostics.sets import (
    NEGLIGIBLE,
    NONE,
    Scarce,
    Set,
    is_whole,
    log_likelihood,
    log_prior,
    price,
    ways,
    without,
)
from metrology.diagnostics.start_values import starts
from metrology.diagnostics.subject import LOST, Fit, Marks, Subject
from metrology.diagnostics.table import LARGEST, instead, table
from metrology.diagnostics.view import View, view_of
from metrology.effect import Size
from metrology.message import said

AT_ONCE = 2
"""Sets that are fitted at a time before the best of them is looked at."""
EQUAL = 3.0
"""Difference in ln evidence from which on one is preferred to the other: 20 to 1, 'strong' of Kass & Raftery (J. Am.
Stat. Assoc. 90 (1995) 773)."""
PLACES = 3
"""Decimal places of a difference in ln evidence: 0.1 % of a probability, which the parabola does not hold to more."""
COARSE = 2.0
"""λ from which on what no model explains adds more to an uncertainty than the noise does."""
TRIED = 4
"""Effects that are fitted in the place of one of the model."""
KINDS = 4
"""Kinds of an effect up to which all are compared; more are places, of which the best stands for its neighbours."""
LEAST = math.log(NEGLIGIBLE)
"""Ln of the evidence over the best model's from which on a kind is in a mean."""
USUAL = 25
"""Derivatives of a usual fit: half of those of responses take fewer."""
PATIENCE = 3
"""Rounds without a better set after which the straight line is not believed further."""
FORM = 5e-3
"""Part of what an effect does by which its form may be off: a compliance in series is quasi-static, which is off by
(c·ω/k)², 2.4e-3 for the stiffest tape of the paper; a friction of 7 µN was named for it."""
HALF = 0.5
"""Part of a promise in ln evidence for more of which a step with fewer effects is taken first."""


@dataclass
class Search:
    """Sets of effects, fitted one after the other where the straight line promises most.

    Parameters
    ----------
    subject : Subject
        Model, candidates, data.
    budget : int
        Fits at most: they are counted, not timed, so that a search repeats.
    workers : int
        Fits at a time.
    say : callable
        Takes one line of text now and then.
    """

    subject: Subject
    budget: int
    workers: int
    say: Callable[[str], None]
    fits: dict[Set, Fit] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)
    spent: int = 0
    glances: dict[Set, float] = field(default_factory=dict)

    # ---- views ------------------------------------------------------------------------------------------------
    def view(self, fit: Fit) -> View:
        """Straight line through a fit with every candidate, its noise, and the evidence of all sets around it."""
        fit = self.subject.finished(fit)
        self.fits[frozenset(fit.effects)] = fit
        self.spent += int(fit.dear) - 1
        others = [
            name for name in self.subject.candidates if name not in fit.effects and self.is_open(fit.effects, name)
        ]
        return view_of(fit, self.subject, self.subject.directions(fit, others), self.fits[NONE], self.rounding(fit))

    @cached_property
    def beside(self) -> Mapping[str, str]:
        """For every candidate the one without which it is not tried."""
        return {name: one.cause.beside for name, one in self.subject.candidates.items()}

    def is_open(self, effects: Collection[str], name: str) -> bool:
        """Whether a candidate may be added to these effects."""
        return not self.subject.candidates[name].instead and self.beside[name] in ("", *effects)

    # ---- search -----------------------------------------------------------------------------------------------
    def run(self, base: Fit, here: View) -> View:
        """Best view that the budget allows, from the base model on."""
        self.fits[NONE] = base
        here = self._settled(self._climbed(here))
        seen = {here.effects}
        while self.spent < self.budget:
            # Of two sets each may do better in the metric of the other: none is looked at twice.
            others = [one for one in self.exchanged(here).values() if frozenset(one[0].effects) not in seen]
            best = max(others, key=lambda one: one[1], default=None)
            if best is None or best[1] <= 0:
                break
            here = self._settled(self._climbed(self.view(best[0])))
            seen |= {frozenset(best[0].effects), here.effects}
        return self._determined(here)

    def _determined(self, here: View) -> View:
        """Return the view, or that of the best fit whose sizes the readings determine beside one another.

        Where they do not, no evidence of the sets around a fit exists; on its way the search may pass such a fit.
        """
        if here.table.amounts(here.effects) is not None:
            return here
        others = [fit for one, fit in self.fits.items() if self.is_fitted(one) and one != here.effects]
        views = (self.view(fit) for fit in sorted(others, key=lambda fit: -self.over(here, fit)))
        return next((one for one in views if one.table.amounts(one.effects) is not None), here)

    def _climbed(self, here: View) -> View:
        """Follow the straight line to better sets, until it promises none or keeps no promise."""
        idle = 0
        while self.spent < self.budget and idle < PATIENCE:
            wanted = self.promising(here)
            if not wanted:
                break
            better = self._best(here, self.fit_sets(here, wanted[: self._room()]))
            idle = 0 if better is not None else idle + 1
            here = better or here
        return here

    def _room(self) -> int:
        """Fits that the budget has left for, if none takes more than any before it; one at least."""
        return max(1, (self.budget - self.spent) // max(map(cost, self.fits.values())))

    def evidence(self, here: View) -> dict[Set, float]:
        """Ln evidence of the sets around a fit, set right by the fits without one of its effects where there are any.

        An effect that is far from straight in its size leaves another evidence than the straight line says. A set
        without it is set right by the fit that is most like it in what it has besides: where the line promises that
        others do as well in its place, and a fit of these did not, it would promise the same of those and one more.
        """
        own = here.evidence.get(here.effects, -math.inf)
        off = {name: self._off(here, name, own) for name in here.fit.effects}
        return {one: value + math.fsum(_nearest(off[name], one - here.effects) for name in here.effects - one)
                for one, value in here.evidence.items()}  # fmt: skip

    def _off(self, here: View, name: str, own: float) -> list[tuple[Set, float]]:
        """What fits without an effect have besides the others, and how much lower than by the line they are."""
        return [(one - here.effects, self.over(here, fit) - (here.evidence[one] - own))
                for one, fit in self.fits.items()
                if here.effects - one == {name} and self.is_fitted(one)
                and math.isfinite(here.evidence.get(one, -math.inf))]  # fmt: skip

    def least(self, here: View) -> float:
        """Ln evidence that is not sought any more: the forms of the effects in the fit may be off by as much."""
        gone = (self.defined(here).mean_cost - here.fit.mean_cost) * here.fit.count
        return 0.5 * FORM**2 * max(gone, 0.0)

    def defined(self, here: View) -> Fit:
        """Fit with those effects of a view alone that are what their equation says: beside it forms may be off."""
        found = frozenset(name for name in here.effects if self.subject.candidates[name].cause.defined)
        return self.fits[found if self.is_fitted(found) else NONE]

    def rounding(self, fit: Fit) -> float:
        """Cost that rounding of the readings leaves of any model; 0 where the noise is estimated from many."""
        return fit.count * self.subject.floor**2 if self.subject.is_scarce else 0.0

    def is_fitted(self, one: Set) -> bool:
        """Whether a set has a fit of its own."""
        return one in self.fits and frozenset(self.fits[one].effects) == one

    def over(self, here: View, fit: Fit) -> float:
        """Ln evidence of a fit over that of a view, both as they were fitted, in the metric of the view.

        Rounded: a fit at a kink of its model, such as a friction near zero, ends where its way led it, and with other
        last digits on another processor.
        """
        if id(fit) not in here.compared:
            both = [here.fit, fit]
            of_fit, of_view = (self.log_evidence(one, here.noise, both, here) for one in (fit, here.fit))
            here.compared[id(fit)] = fit, round(of_fit - of_view, PLACES)
        return here.compared[id(fit)][1]

    def promising(self, here: View) -> list[Set]:
        """Sets not yet fitted that the straight line puts above the fit, the best first."""
        if self._is_lost(here.fit):
            return self._glanced(here)
        evidence = self.evidence(here)
        own = evidence.get(here.effects, -math.inf)
        ranked = sorted(evidence, key=lambda one: -evidence[one])
        # A shape that is sought between the places where it was tried fits at least as well as there.
        open_ = {name: member.open for name, member in here.table.members.items()}
        found = [one for one in ranked if one not in self.fits
                 and evidence[one] + math.fsum(open_[name] for name in one) > own + self.least(here)]  # fmt: skip
        # Far off the straight line leads astray: the fewer effects it adds at once, the nearer is where it ends.
        return list(dict.fromkeys(_step(one, found, evidence, own) for one in found[:AT_ONCE]))

    def _is_lost(self, fit: Fit) -> bool:
        """Whether a straight line through a fit says little: it lost the motion, or is far off and no optimum."""
        return self.subject.loses(fit) or (fit.spent and fit.mean_cost > LOST)

    def _glanced(self, here: View) -> list[Set]:
        """Sets of one effect more, not yet fitted, that do best at the beginning of the motion; none is too large."""
        if len(here.effects) >= LARGEST:
            return []
        wanted = {here.effects | {name}: name for name in self.subject.candidates
                  if name not in (*here.effects, *self.subject.untestable())
                  and self.is_open(here.effects, name)}  # fmt: skip
        new = [one for one in wanted if one not in self.glances]
        with ThreadPoolExecutor(self.workers) as pool:
            found = list(pool.map(lambda one: self._glance(here, wanted[one]), new))
        self.glances |= {one: value for one, (value, _) in zip(new, found, strict=True)}
        self.spent += int(math.fsum(steps for _, steps in found)) // USUAL
        ranked = sorted((one for one in wanted if one not in self.fits), key=lambda one: self.glances[one])
        return [one for one in ranked if math.isfinite(self.glances[one])][:AT_ONCE]

    def _glance(self, here: View, name: str) -> tuple[float, float]:
        """Glance at the fit with one effect more: its cost for each reading, and the derivatives that it took."""
        member, size = here.table.members.get(name), self.subject.candidates[name].size
        trial = member.column.direction.values if member and member.column.direction else {}
        shape = {one: value for one, value in trial.items() if one != size.name}
        return self.subject.glance((*here.fit.effects, name), {**here.fit.values, **shape})

    def exchanged(self, here: View) -> dict[tuple[str, str], tuple[Fit, float]]:
        """Fits with one effect in the place of another, where the straight line does not rule them out.

        Another law of the same thing is fitted whatever the line says: that is straight in the size of the first, and
        ends far before nothing of it is left. By the effect of the view and the one in its place: fit, and its ln
        evidence over that of the view.
        """
        evidence = self.evidence(here)
        own, found = evidence[here.effects], {}
        near = {one: value for one, value in evidence.items() if value > own - 2 * EQUAL}
        near |= {one: own + self.over(here, fit) for one, fit in self.fits.items() if self.is_fitted(one)}
        for name in here.fit.effects:
            rest = without(here.effects, name, self.beside)
            for other, more in instead(here.line, self.subject.candidates, name).items():
                if more > -2 * EQUAL:
                    near[rest | {other}] = max(near.get(rest | {other}, -math.inf), own + more)
            others = [one for one in near if one > rest and len(one) == len(rest) + 1 and name not in one
                      and is_whole(one, self.beside)]  # fmt: skip
            others = sorted(others, key=lambda one: -near[one])[:TRIED]
            for one in dict.fromkeys([*others, *(rest | {other} for other in self._same(name, here.effects))]):
                (other,) = one - rest
                if not self.is_fitted(one) and self.spent < self.budget:
                    fit = self._fit(here, one)
                    self.spent += cost(fit)
                    self.fits[one] = here.fit if fit is None else fit
                if self.is_fitted(one):
                    found[name, other] = (self.fits[one], self.over(here, self.fits[one]))
            found |= self._equivalent(here, name)
        return found

    def _same(self, name: str, model: Set) -> list[str]:
        """Effects outside of a model that are laws of the same thing as one of it, and can be told from it."""
        laws = {one: other.cause.law for one, other in self.subject.candidates.items()}
        out = (*model, *self.subject.untestable())
        return [one for one, law in laws.items() if law and law == laws[name] and one not in out]

    def kinds(self, here: View, exchanged: Mapping[tuple[str, str], tuple[Fit, float]]) -> list[tuple[str, Fit, float]]:
        """Fits of a view's effects, and of those that do as well, in their other kinds, such as another law of creep.

        Each with the effect of the view that it is, or in whose place it is, and its ln evidence over the view's. The
        readings may prefer a kind by what another effect is off by: far less probable ones count.
        """
        models = [(name, name, here.fit, 0.0) for name in here.fit.effects]
        models += [(name, other, fit, more) for (name, other), (fit, more) in exchanged.items()]
        found = ((name, fit, self._over_kind(here, (model, more), fit, size))
                 for name, other, model, more in models for size, fit in self._of_kinds(model, other))  # fmt: skip
        return [one for one in found if one[2] > LEAST]

    def _of_kinds(self, model: Fit, name: str) -> Iterator[tuple[Size, Fit]]:
        """Fits of a model with one of its effects in another kind, and the size that says which."""
        for size in self.subject.candidates[name].parameters:
            if not size.held or size.high - size.low > KINDS or size.name not in model.values:
                continue
            for kind in size.places:
                if kind != round(model.values[size.name]):
                    fit = self.subject.fit(model.effects, [{**model.values, size.name: float(kind)}])
                    if fit is not None:
                        yield size, fit

    def _settled(self, here: View) -> View:
        """Return a view with every effect in its best kind: it was chosen beside fewer effects.

        Of fits that have the effect in its former kind none says what it does in this one beside others.
        """
        while self.spent < self.budget:
            kinds = ((name, fit) for name in here.fit.effects for _, fit in self._of_kinds(here.fit, name))
            better = [(self.over(here, fit), name, fit) for name, fit in kinds]
            over, name, fit = max(better, key=lambda one: one[0], default=(0.0, "", here.fit))
            if over <= 0:
                break
            self.spent += cost(fit)
            self.fits = {one: each for one, each in self.fits.items() if name not in one}
            here = self._climbed(self.view(fit))
        return here

    def _over_kind(self, here: View, model: tuple[Fit, float], fit: Fit, size: Size) -> float:
        """Ln evidence of another kind: where kinds differ most beyond the readings, alike for all that fit nearly.

        No form is exact, so that many readings choose one by what is hardly seen, and it then says alone what came
        before them. Those count that leave less than COARSE times as much, at which a form is refuted.
        """
        if not size.extrapolated:
            return self.over(here, fit)
        return model[1] if fit.chi_squared < COARSE * model[0].chi_squared else -math.inf

    def _equivalent(self, here: View, name: str) -> dict[tuple[str, str], tuple[Fit, float]]:
        """Fit in which another cause does exactly what an effect does: beside it nothing of it can be seen."""
        other = self.subject.equivalent(here.fit, name)
        if other is None:
            return {}
        effect, values = other
        one = (here.effects - {name}) | {effect}
        if one not in self.fits:
            fit = self.subject.fit((*(each for each in here.fit.effects if each != name), effect), [values])
            self.fits[one] = here.fit if fit is None else fit
        fitted = self.is_fitted(one)
        return {(name, effect): (self.fits[one], self.over(here, self.fits[one]))} if fitted else {}

    def fit_sets(self, here: View, wanted: Sequence[Set]) -> list[Fit]:
        """Fits of sets of effects, from where a view says that they lie; those that have an answer."""
        self.say("fitting " + "; ".join(" + ".join(sorted(one)) or "the base model" for one in wanted))
        with ThreadPoolExecutor(self.workers) as pool:
            found = list(pool.map(lambda one: self._fit(here, one), wanted))
        self.spent += sum(map(cost, found))
        for one, fit in zip(wanted, found, strict=True):
            if fit is None:
                text = "{effects:figures}: its model has no answer, and it is left out"
                self.failed.append(said(text, effects=" + ".join(sorted(one))))
            else:
                self.fits[one] = fit
        for one in wanted:
            self.fits.setdefault(one, here.fit)
        return [fit for fit in found if fit is not None]

    def _fit(self, here: View, wanted: Set) -> Fit | None:
        """Fit of a set: from where the straight line leads, then from nearer to a smaller model while that is lower.

        The last start is hardly anything else than the smaller model: a larger one is never worse than that.
        """
        here = self._listed(here, wanted)
        order = [name for name in here.fit.effects if name in wanted]
        order += sorted(wanted - here.effects)
        smaller = self._smaller(wanted)
        best: Fit | None = None
        steps = 0.0
        for values in self._near(tuple(order), starts(here, self.subject.candidates, wanted, smaller)):
            fit = self.subject.fit(tuple(order), [values])
            steps += 0 if fit is None else fit.steps
            if fit is not None and (best is None or fit.mean_cost < best.mean_cost):
                best = fit
            if best is not None and not (smaller is not None and best.mean_cost > smaller.mean_cost):
                break
        return None if best is None else replace(best, steps=steps)

    def _listed(self, here: View, wanted: Set) -> View:
        """Return the view with those effects in its table that are tried only in the place of others."""
        candidates = self.subject.candidates
        more = [name for name in wanted - here.effects if candidates[name].instead]
        if not more:
            return here
        listed = line(here.fit, candidates, self.subject.directions(here.fit, more), here.noise, here.fit.used)
        return replace(here, line=listed, table=table(listed, candidates))

    def _smaller(self, wanted: Set) -> Fit | None:
        """Best fit of a smaller set within one; None within the empty set."""
        found = [fit for one, fit in self.fits.items() if one < wanted and self.is_fitted(one)]
        return min(found, key=lambda fit: fit.mean_cost, default=None)

    def _near(self, effects: tuple[str, ...], starts: Sequence[dict[str, float]]) -> Iterator[dict[str, float]]:
        """Starts that have not lost the motion; all, where all have: such a search takes long, and ends elsewhere."""
        lost = True
        for values in starts:
            if not self.subject.is_far(effects, values):
                lost = False
                yield values
        if lost:
            yield from starts

    def _best(self, here: View, found: Sequence[Fit]) -> View | None:
        """View of the fit with the most evidence, if it has more than where the search is; in the sharper metric."""
        if not found:
            return None
        best = max(found, key=lambda fit: self.log_evidence(fit, here.noise, [here.fit, *found], here))
        there = self.view(best)
        by = min((here.noise, there.noise), key=lambda one: one.misfit)
        both = [here.fit, best]
        if self.log_evidence(best, by, both, here) > self.log_evidence(here.fit, by, both, here):
            return there
        return None

    def log_evidence(self, fit: Fit, by: Noise, beside: Sequence[Fit], view: View) -> float:
        """Ln evidence of a fit times its prior, on the readings that carry weight in all that it is compared with."""
        blocks, table = len(fit.problem.blocks), self.subject.candidates
        cost = sum(price(table[name], view.line.count, blocks) for name in fit.effects)
        used = common([fit, *beside])
        scarce = Scarce(self.fits[NONE].free, self.fits[NONE].free) if self.subject.is_scarce else None
        likely = log_likelihood(weighted(fit, by, used) + self.rounding(fit), scarce,
                                sum(ways(table[name], blocks) for name in fit.effects))  # fmt: skip
        return likely - cost + log_prior(len(fit.effects), view.table.among) + self._spared(fit, by, used)

    def _spared(self, fit: Fit, by: Noise, used: Sequence[Marks]) -> float:
        """Ln of how much likelier a model is where it may also have a steady drift alone, or no slow motion at all.

        It is fitted with all that is slow; a model whose effects move the mean of the motion by themselves needs none.
        """
        if not self.subject.slow:
            return 0.0
        steady, whole = slow_motion(fit, by, used, self.subject.slow)[0]
        return float(logsumexp([0.0, steady - whole, -whole]))


def cost(fit: Fit | None) -> int:
    """How many usual fits one counts for: along a bent valley, or of dear motions, it takes as long as several."""
    return 1 if fit is None else 1 + int(fit.steps * fit.dear) // USUAL


def _nearest(off: Sequence[tuple[Set, float]], besides: Set) -> float:
    """Difference by the fit that is most like a set in what it has besides; of several alike the smallest."""
    return min(((len(one ^ besides), value) for one, value in off), default=(0, 0.0))[1]


def _step(wanted: Set, found: Sequence[Set], evidence: Mapping[Set, float], own: float) -> Set:
    """Smallest part of a set among those found, the best of them, that promises more than half of what it promises."""
    promise = evidence[wanted] - own
    parts = [one for one in found if one <= wanted and evidence[one] - own > HALF * promise]
    return min(parts, key=lambda one: (len(one), -evidence[one]), default=wanted)
