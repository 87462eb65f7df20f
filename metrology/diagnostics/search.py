"""Search for the set of effects with the most evidence: always an answer, and it knows what it did not try."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

from metrology.diagnostics.fits import USUAL, Fits, cost
from metrology.diagnostics.line import line
from metrology.diagnostics.sets import NONE, Set, is_whole, without
from metrology.diagnostics.start_values import starts
from metrology.diagnostics.subject import LOST, Fit
from metrology.diagnostics.table import LARGEST, instead, table
from metrology.diagnostics.view import View, view_of
from metrology.message import said

AT_ONCE = 2
"""Sets that are fitted at a time before the best of them is looked at."""
EQUAL = 3.0
"""Difference in ln evidence from which on one is preferred to the other: 20 to 1, 'strong' of Kass & Raftery (J. Am.
Stat. Assoc. 90 (1995) 773)."""
TRIED = 4
"""Effects that are fitted in the place of one of the model."""
PATIENCE = 3
"""Rounds without a better set after which the straight line is not believed further."""
HALF = 0.5
"""Part of a promise in ln evidence for more of which a step with fewer effects is taken first."""


@dataclass
class Search(Fits):
    """Sets of effects, fitted one after the other where the straight line promises most.

    Parameters
    ----------
    subject, fits
        See `Fits`.
    budget : int
        Fits at most: they are counted, not timed, so that a search repeats.
    workers : int
        Fits at a time.
    say : callable
        Takes one line of text now and then.
    """

    budget: int
    workers: int
    say: Callable[[str], None]
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

    def _settled(self, here: View) -> View:
        """Return a view with every effect in its best kind: it was chosen beside fewer effects.

        Beside the better kind one may be needless that made up for the former, without which no other kind is better.
        Of fits that have the effect in its former kind none says what it does in this one beside others.
        """
        while self.spent < self.budget:
            kinds = [(name, fit) for name in here.fit.effects for _, fit in self._of_kinds(here.fit, name)]
            better = [(self.over(here, fit), name, fit) for name, fit in kinds]
            better += [(more, name, fewer) for name, fit in kinds for _, fewer, more in self._fewer(here, name, fit)]
            over, name, fit = max(better, key=lambda one: one[0], default=(0.0, "", here.fit))
            if over <= 0:
                break
            self.spent += cost(fit)
            self.fits = {one: each for one, each in self.fits.items() if name not in one}
            here = self._climbed(self.view(fit))
        return here

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
        smaller = self.smaller(wanted)
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


def _step(wanted: Set, found: Sequence[Set], evidence: Mapping[Set, float], own: float) -> Set:
    """Smallest part of a set among those found, the best of them, that promises more than half of what it promises."""
    promise = evidence[wanted] - own
    parts = [one for one in found if one <= wanted and evidence[one] - own > HALF * promise]
    return min(parts, key=lambda one: (len(one), -evidence[one]), default=wanted)
