"""Which effects pay: joint fits of the promising ones, compared by evidence, one after the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from metrology.diagnose import couples, flexible, residuals
from metrology.diagnose.evidence import OCCAM, log_bayes
from metrology.diagnose.linear import Score, Screen, screen
from metrology.diagnose.subject import LOST, Coarse, Fit, Flexible, Slow, Subject, Twofold

Found = TypeVar("Found")
Item = TypeVar("Item")

PAYS = 3.0
"""Gain in ln evidence from which on an effect is taken, or one is preferred to another."""
STARTS = ((1.0, 1.0), (1.0, 0.0), (0.4, 0.0), (2.5, 0.0))
"""Starts of an extended fit: factors on the amount that the straight line suggests, and on what the unknowns do."""
PEAKS = 3
"""Shapes of a candidate from which fits begin where much is amiss."""
TRIES = 4
"""Starts of one extended fit."""
FITS = 60
"""Fits after which every candidate is given one start only; counted between rounds, so that a diagnosis repeats."""
PART = 0.25
"""Part of what a force of any form would gain that the best candidate has to gain, to be worth going on with."""
REST = 0.01
"""Part of χ² that an extension may leave beyond chance where it is negligible."""
SPECK = 1e-3
"""Part of what an extension took that it may leave where it is negligible."""
KEPT = 0.6
"""Part of the fall of χ² that the straight line promises which, once there, makes further starts needless."""
NEAR = 0.9
"""Part of the leader's fall of χ² that a candidate has to promise by its score to be given further starts."""
MANY = 12
"""Shapes of candidates that are fitted at a time."""
MOST = 3
"""Effects that one model may be given."""
ROUNDS = 2 * MOST
"""Rounds of adding, and of revising what is there: an effect that was replaced leaves room for another."""
LAST = 0.1
"""Part of the best promise below which a candidate waits until the others leave something; what they must not leave."""
BEHIND = 0.5
"""Part of the way from the best to the worst of all first looks beyond which a candidate is hopelessly behind."""
TIMES = 10.0
"""Times the best sum of squares of a first look that are as hopeless."""
CLEAR = 60.0
"""Sum of squares of a first look by which a candidate has to be behind for that."""


@dataclass(frozen=True)
class Rival:
    """A model with one effect more, and its ln evidence over the model without it."""

    effect: str
    fit: Fit
    log_bayes: float


@dataclass(frozen=True)
class Look:
    """Where the fit of a candidate begins, and whether it is worth going on from there."""

    values: Mapping[str, float]
    goes_on: bool = True


@dataclass(frozen=True)
class Step:
    """One round of the selection: the model before, the scores at it, and the rivals fitted."""

    before: Fit
    screen: Screen
    rivals: tuple[Rival, ...]


@dataclass
class Search:
    """Forward selection with what it needs, and a record of what it did."""

    subject: Subject
    rng: np.random.Generator
    false_alarm: float
    workers: int = 2
    progress: Callable[[str], None] = lambda _text: None
    failures: list[str] = field(default_factory=list)
    places: dict[tuple[int, str], tuple[Fit, Fit, tuple[Rival, ...]]] = field(default_factory=dict)
    beyond: dict[str, tuple[Rival, ...]] = field(default_factory=dict)
    screens: dict[int, tuple[Fit, Screen]] = field(default_factory=dict)
    fits: int = 0

    # ---- screening ----------------------------------------------------------------------------------------------
    def screened(self, fit: Fit, effects: Sequence[str] | None = None) -> Screen:
        """Scores of all candidates that the model does not carry yet."""
        names = [name for name in (effects or self.subject.candidates) if name not in fit.effects]
        directions = self.subject.directions(fit, names)
        signed = [self.subject.candidates[one.effect].signed for one in directions]
        found = screen(fit, directions, signed, self.rng, self.false_alarm)
        self.screens[id(fit)] = (fit, found)  # the fit is kept, so that its identity stays its own
        return found

    # ---- fits ---------------------------------------------------------------------------------------------------
    def rivals(self, before: Fit, scores: Sequence[Score]) -> tuple[Rival, ...]:
        """Joint fits of the model with each of these candidates, by evidence.

        Those that promise least are only tried where the best of the others leaves something to gain.
        """
        effects = dict.fromkeys(one.direction.effect for one in scores)
        first = [name for name in effects if self._comes_first(before, name, scores)]
        last = [name for name in effects if name not in first]
        fits = self._tried(before, first, scores) if first else []
        best = min(fits, key=lambda fit: fit.mean_cost, default=None)
        if last and (best is None or self._leaves(before, best)):
            fits += self._tried(before, last, scores)
        return self.ranked(before, self._with_twins(fits))

    def _with_twins(self, fits: Sequence[Fit], seen: Sequence[tuple[Fit, str]] = ()) -> list[Fit]:
        """Fits with what says the same by another cause, each cause, their last effect, as its best fit.

        `seen`: models of which one effect has its twin sought as well.
        """
        if not isinstance(self.subject, Twofold):
            return list(fits)
        twins = [self.subject.twin(fit, name) for fit, name in (*((fit, fit.effects[-1]) for fit in fits), *seen)]
        best: dict[str, Fit] = {}
        for fit in (*fits, *(twin for twin in twins if twin is not None)):
            name = fit.effects[-1]
            best[name] = min(best.get(name, fit), fit, key=lambda one: one.mean_cost)
        return list(best.values())

    def _leaves(self, before: Fit, best: Fit) -> bool:
        """Whether the best candidate so far leaves something to the others, as far as that is known."""
        known = isinstance(self.subject, Flexible)
        return not known or self.excess(best) > LAST * 0.5 * (before.cost - best.cost)

    def _comes_first(self, before: Fit, name: str, scores: Sequence[Score]) -> bool:
        """Whether a candidate promises enough; where the model loses the motion and promises are idle, is simple."""
        if before.mean_cost > LOST and isinstance(self.subject, Slow):
            return self.subject.is_simple(name)
        return _promise(name, scores) >= LAST * max(float(one.z) ** 2 for one in scores)

    def _tried(self, before: Fit, effects: Sequence[str], scores: Sequence[Score]) -> list[Fit]:
        """Fits with each of these candidates, in parallel; further starts for those that owe what they promise."""
        begun = {name: self._all_starts(before, name, scores) for name in effects}
        looks = self._looked(before, {name: starts[0] for name, starts in begun.items()})
        found = dict(zip(looks, self._each(lambda name: self._begun(before, name, looks[name]), looks), strict=True))
        lead = max((before.cost - fit.cost for fit in found.values() if fit is not None), default=0.0)
        most = TRIES if self.fits < FITS else 1
        late: dict[str, tuple[list[dict[str, float]], float]] = {}
        for name in effects:
            promise, peaks = _promise(name, scores), sum(one.direction.effect == name for one in scores)
            if looks[name].goes_on and most > 1 and _owes(before, found[name], promise, lead):
                late[name] = (begun[name][1:most], promise)
            elif looks[name].goes_on and peaks > 1 and most > 1 and _leads(before, found[name], lead):
                # Each peak of the scores is a valley of its own: what led into one says nothing of the others.
                late[name] = (begun[name][1:peaks], math.inf)
        # Counted before they are made, so that it does not hang on the order in which they end.
        self.fits += len(effects) + sum(len(starts) for starts, _ in late.values())
        again = self._each(lambda name: self._again(before, name, *late[name]), late)
        for name, fit in zip(late, again, strict=True):
            first = found[name]
            if first is None or (fit is not None and fit.mean_cost < first.mean_cost):
                found[name] = fit
        for name, fit in found.items():
            self.progress(f"tried {name}")
            self._noted(name, fit)
        return [fit for fit in found.values() if fit is not None]

    def _each(self, one: Callable[[Item], Found], items: Iterable[Item]) -> list[Found]:
        """One after the other, as many at a time as there are workers."""
        with ThreadPoolExecutor(self.workers) as pool:
            return list(pool.map(one, items))

    def _looked(self, before: Fit, starts: Mapping[str, Mapping[str, float]]) -> dict[str, Look]:
        """First look at every candidate, where that is worth it: from where to go on, and whether."""
        subject = self.subject
        if not isinstance(subject, Slow) or len(starts) < 2:
            return {name: Look(start) for name, start in starts.items()}
        seen = self._each(lambda name: subject.glance(before, (*before.effects, name), starts[name]), starts)
        costs = [one.cost for one in seen if math.isfinite(one.cost)]
        far = max(min(BEHIND * (max(costs) - min(costs)), TIMES * min(costs)), CLEAR) if costs else math.inf
        return {
            name: Look(
                one.values if math.isfinite(one.cost) else start,
                not math.isfinite(one.cost) or one.cost <= min(costs) + far,
            )
            for (name, start), one in zip(starts.items(), seen, strict=True)
        }

    def _begun(self, before: Fit, name: str, look: Look) -> Fit | None:
        effects = (*before.effects, name)
        if not look.goes_on and isinstance(self.subject, Slow):
            return self.subject.ended(effects, look.values)
        return self.subject.fit(effects, [look.values])

    def _again(self, before: Fit, name: str, starts: Sequence[Mapping[str, float]], promise: float) -> Fit | None:
        """Best fit with a candidate from further starts, until what the straight line promised is there."""
        best: Fit | None = None
        for start in starts:
            found = self.subject.fit((*before.effects, name), [start])
            if found is not None and (best is None or found.mean_cost < best.mean_cost):
                best = found
            if best is not None and before.cost - best.cost > KEPT * promise:
                break
        return best

    def _all_starts(self, before: Fit, name: str, scores: Sequence[Score]) -> list[dict[str, float]]:
        """Starts of a candidate: the suggested one in every shape first, then the others."""
        own = [self.starts(before, score) for score in scores if score.direction.effect == name]
        return [starts[0] for starts in own] + [start for starts in own for start in starts[1:]]

    def ranked(self, before: Fit, fits: Sequence[Fit], names: Sequence[str] = ()) -> tuple[Rival, ...]:
        """Rivals by evidence, each compared with the best on the readings that carry weight in both and before.

        Not on those of all rivals at once: one whose contacts lie elsewhere would take the evidence of all others away.
        """
        if not fits:
            return ()
        table = self.subject.candidates
        alone = [log_bayes(table, before, fit) for fit in fits]
        top = fits[int(np.argmax(alone))]
        best = max(alone)
        found = []
        for name, fit in zip(names or [fit.effects[-1] for fit in fits], fits, strict=True):
            beside = log_bayes(table, before, fit, [top]) - log_bayes(table, before, top, [fit])
            found.append(Rival(name, fit, best if fit is top else best + beside))
        return tuple(sorted(found, key=lambda rival: -rival.log_bayes))

    def _noted(self, name: str, fit: Fit | None) -> None:
        """Say once of an effect that its fit failed, or ended with its steps used up."""
        words = "its model has no answer at any start, and it is left out"
        if fit is not None:
            words = "a search used up its steps before it converged; judged where it ended"
        told = f"{name}: {words}"
        if (fit is None or fit.spent) and told not in self.failures:
            self.failures.append(told)

    def starts(self, before: Fit, score: Score) -> list[dict[str, float]]:
        """Values to begin from: what the straight line says, with and without what the unknowns do; more, or less."""
        candidate = self.subject.candidates[score.direction.effect]
        size, found = candidate.size, []
        for factor, shared in STARTS if abs(score.z) > 10 else STARTS[:2]:
            values = {**before.values, **dict(score.direction.values)}
            for entry, shift in zip(before.problem.unknowns, score.shift, strict=True):
                moved = values[entry.name] + shared * float(shift)
                values[entry.name] = min(max(moved, entry.low), entry.high)
            if score.direction.ways:
                for way, one in zip(score.direction.ways, score.factors, strict=False):
                    values[way] = score.direction.amount * one * factor
                found.append(values)
                continue
            origin = before.values.get(size.name, size.null)
            if score.direction.stated is not None:
                # It has gone already where the data want it, against its prior.
                found.append(dict(before.values))
                break
            amount = score.direction.amount * score.factor
            if origin == size.null == 0.0:
                amount = size.amount(score.direction.amount, score.factor)
            values[size.name] = float(np.clip(origin + amount * factor, size.low, size.high))
            if len(score.factors) == 2:
                a, b = score.factors
                values[size.name] = score.direction.amount * math.hypot(a, b) * factor
                values[candidate.parameters[2].name] = math.atan2(b, a)
            found.append(values)
        return found

    # ---- selection ----------------------------------------------------------------------------------------------
    def forward(self, base: Fit) -> tuple[Fit, list[Step]]:
        """Add the effect that pays best until none pays; then see whether one of them can go or be replaced."""
        here, steps = base, []
        for _ in range(ROUNDS):
            scores = self.screened(here)
            done = len(here.effects) == MOST or self.negligible(base, here)
            chosen = [] if done else self.promising(here, scores)
            rivals = self.rivals(here, chosen) if chosen else ()
            steps.append(Step(here, scores, rivals))
            if not rivals or rivals[0].log_bayes < max(PAYS, PART * self.excess(here)):
                couple = None if done else self.coupled(base, here, steps[0].screen)
                if couple is None:
                    break
                here = self.revised(couple)
                continue
            best = rivals[0]
            self.places[id(best.fit), best.effect] = (best.fit, here, rivals[1:])
            if (
                here.mean_cost > LOST > best.fit.mean_cost
                and min(one.fit.mean_cost for one in rivals[1:] or rivals) > LOST
            ):
                self.beyond[best.effect] = rivals[1:]
            here = self.revised(best.fit) if here.effects else best.fit
        return here, steps

    def coupled(self, base: Fit, here: Fit, scores: Screen) -> Fit | None:
        """Two effects that pay together where one at a time does not, as where each takes back what the other does.

        Sought where one effect at most leaves structure; None where none pays.
        """
        if len(here.effects) > 1 or base.mean_cost > LOST or not self._leaves_structure(here):
            return None
        table = self.subject.candidates
        signed = {name for name, one in table.items() if one.signed}
        pairs = couples.promising(scores, signed, 2 * (PAYS + OCCAM))
        self.fits += len(pairs)
        fits = self._each(lambda pair: self._together(base, pair), pairs)
        ways = [(log_bayes(table, base, fit, [here]), fit) for fit in fits if fit is not None]
        gain, best = max(ways, key=lambda one: one[0], default=(0.0, None))
        own = log_bayes(table, base, here, [best]) if best is not None else 0.0
        return best if gain > own + PAYS and gain > 2 * PAYS else None

    def _leaves_structure(self, fit: Fit) -> bool:
        """Whether the residuals are no noise, or a force of any form would take up more than chance gives."""
        form = None
        if isinstance(self.subject, Flexible):
            form = flexible.test(fit, self.subject.families(fit), self.rng, self.false_alarm)
        return not residuals.test(fit, self.rng, self.false_alarm).passed or not (form is None or form.passed)

    def _together(self, base: Fit, pair: tuple[Score, Score]) -> Fit | None:
        """Fit with two candidates, from what the straight line asks for of both."""
        values, names = dict(base.values), tuple(one.direction.effect for one in pair)
        for name, score in zip(names, pair, strict=True):
            sizes = {size.name for size in self.subject.candidates[name].parameters}
            values |= {key: value for key, value in self.starts(base, score)[0].items() if key in sizes}
        return self.subject.fit((*base.effects, *names), [values])

    def negligible(self, base: Fit, fit: Fit) -> bool:
        """Whether what an extension leaves, even if it is real, is nothing beside what it took."""
        if not fit.effects:
            return False
        if isinstance(self.subject, Coarse) and fit.chi_squared < self.subject.enough * fit.count:
            return True
        if not isinstance(self.subject, Flexible):
            return False
        stated = sum(entry.u is not None for entry in fit.problem.unknowns)
        kept = self.screens.get(id(fit))
        promised = kept[1].promise if kept else 0.0
        # What a test finds, and neither a force nor a candidate, is as much as one standard deviation at least.
        left = max(1.0, 2 * self.excess(fit), fit.penalty - stated, promised)
        return left < REST * fit.count and left < SPECK * (base.cost - fit.cost)

    def excess(self, fit: Fit) -> float:
        """Half of χ² that a force or reading of any form would take up beyond chance; 0 where that is not known."""
        if not isinstance(self.subject, Flexible):
            return 0.0
        found = flexible.forms(fit, self.subject.families(fit))
        return max((0.5 * (one.chi_squared - one.dof) for one in found), default=0.0)

    def promising(self, fit: Fit, scores: Screen) -> list[Score]:
        """Shapes worth a fit: those beyond chance; more of them where much is amiss, as the line may mislead there."""
        best = scores.found
        if not best or best[0].p_value > scores.limit:
            return []
        top = max(abs(score.z) for score in best)
        if fit.mean_cost > LOST and isinstance(self.subject, Slow):
            return [score for score in best if score.share > 0 and score.d > 0]
        chosen = [score for score in best if score.z > max(0.4 * top, 2.5)][:MANY]
        if top > 15:
            extra = [score for score in best if score not in chosen and score.share > 0 and score.z > 0.05 * top]
            chosen += extra[: MANY - len(chosen)]
        shaped = []
        for score in chosen:
            shaped += _peaks(scores, score.direction.effect)[: PEAKS if top > 8 else 1]
        return shaped

    def revised(self, fit: Fit) -> Fit:
        """Leave out or replace effects of several, one after the other, as long as the evidence says so."""
        for _ in range(ROUNDS):
            better = self._revised_once(fit)
            if better is fit:
                break
            fit = better
        return fit

    def _revised_once(self, fit: Fit) -> Fit:
        for name in fit.effects:
            place = self.place(fit, name)
            if place is None:
                continue
            without, rivals = place
            own = log_bayes(self.subject.candidates, without, fit, [rival.fit for rival in rivals[:1]])
            if own < PAYS and (not rivals or rivals[0].log_bayes < PAYS):
                return without
            if rivals and rivals[0].log_bayes > own + PAYS:
                return rivals[0].fit
        return fit

    def place(self, fit: Fit, name: str) -> tuple[Fit, tuple[Rival, ...]] | None:
        """Return the model without one of its effects, and what else could stand in its place; None without such a fit.

        Not sought anew for an effect beside which every other lost the motion.
        Found once for each fit, which is kept so that its identity stays its own.
        """
        if (id(fit), name) not in self.places:
            rest = tuple(one for one in fit.effects if one != name)
            without = self.subject.fit(rest, [fit.values])
            if without is None:
                return None
            if name in self.beyond and without.mean_cost > LOST:
                self.places[id(fit), name] = (fit, without, ())
                return without, ()
            chosen = [one for one in self.promising(without, self.screened(without)) if one.direction.effect != name][
                :6
            ]
            found = [one.fit for one in self.rivals(without, chosen)] if chosen else []
            others = [one for one in self._with_twins(found, [(fit, name)]) if one.effects[-1] != name]
            self.places[id(fit), name] = (fit, without, self.ranked(without, others))
        _, without, rivals = self.places[id(fit), name]
        return without, rivals

    def without(self, fit: Fit) -> dict[str, Fit]:
        """Models without each of the effects, as far as they were needed."""
        return {name: self.places[id(fit), name][1] for name in fit.effects if (id(fit), name) in self.places}


def _owes(before: Fit, first: Fit | None, promise: float, lead: float) -> bool:
    """Whether a second start may bring something: more was promised than the leader gave, and not kept."""
    given = 0.0 if first is None else before.cost - first.cost
    return promise > NEAR * lead and given < KEPT * promise


def _leads(before: Fit, first: Fit | None, lead: float) -> bool:
    """Whether a candidate took nearly as much as the best of all."""
    return first is not None and before.cost - first.cost > NEAR * lead


def _promise(effect: str, scores: Sequence[Score]) -> float:
    """Fall of χ² that the straight line promises of a candidate."""
    return max(float(score.z) ** 2 for score in scores if score.direction.effect == effect)


def _peaks(scores: Screen, effect: str) -> list[Score]:
    """Shapes of an effect that ask for a place more than their neighbours do, the best first."""
    own = [one for one in scores.scores if one.direction.effect == effect]
    z = [-math.inf, *(one.z for one in own), -math.inf]
    peaks = [one for at, one in enumerate(own) if z[at + 1] >= max(z[at], z[at + 2])]
    return sorted(peaks, key=lambda one: -one.z)
