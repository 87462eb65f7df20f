"""Fits of sets of effects, and the evidence of each beside a view."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from scipy.special import logsumexp

from metrology.diagnostics.likelihood import Noise, common, slow_motion, weighted
from metrology.diagnostics.sets import NEGLIGIBLE, NONE, Scarce, Set, log_likelihood, log_prior, price, ways, without
from metrology.diagnostics.subject import Fit, Marks, Subject
from metrology.diagnostics.view import View
from metrology.effect import Size

PLACES = 3
"""Decimal places of a difference in ln evidence: 0.1 % of a probability, which the parabola does not hold to more."""
COARSE = 2.0
"""λ from which on what no model explains adds more to an uncertainty than the noise does."""
KINDS = 4
"""Kinds of an effect up to which all are compared; more are places, of which the best stands for its neighbours."""
LEAST = math.log(NEGLIGIBLE)
"""Ln of the evidence over the best model's from which on a kind is in a mean."""
FORM = 5e-3
"""Part of what an effect does by which its form may be off: a compliance in series is quasi-static, which is off by
(c·ω/k)², 2.4e-3 for the stiffest tape of the paper; a friction of 7 µN was named for it."""
USUAL = 25
"""Derivatives of a usual fit: half of those of responses take fewer."""


@dataclass
class Fits:
    """Sets of effects that were fitted: which, and how much evidence each has.

    Parameters
    ----------
    subject : Subject
        Model, candidates, data.
    fits : dict
        Every set that was tried, with its fit; one that has no answer, with the fit that was there before.
    """

    subject: Subject
    fits: dict[Set, Fit] = field(default_factory=dict, kw_only=True)

    @cached_property
    def beside(self) -> Mapping[str, str]:
        """For every candidate the one without which it is not tried."""
        return {name: one.cause.beside for name, one in self.subject.candidates.items()}

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
        """Ln evidence that is not sought any more: the forms of the effects in the fit may be off by as much.

        In the metric of the view: of a fit that is far off, what its effects took away is as little as anything.
        """
        gone = (self.defined(here).mean_cost - here.fit.mean_cost) * here.fit.count
        return 0.5 * FORM**2 * max(gone, 0.0) / here.noise.misfit

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

    def smaller(self, wanted: Set) -> Fit | None:
        """Best fit of a smaller set within one; None within the empty set."""
        found = [fit for one, fit in self.fits.items() if one < wanted and self.is_fitted(one)]
        return min(found, key=lambda fit: fit.mean_cost, default=None)

    def kinds(self, here: View, exchanged: Mapping[tuple[str, str], tuple[Fit, float]]) -> list[tuple[str, Fit, float]]:
        """Fits of a view's effects, and of those that do as well, in their other kinds, such as another law of creep.

        Each with the effect of the view that it is, or in whose place it is, and its ln evidence over the view's. The
        readings may prefer a kind by what another effect is off by: far less probable ones count.
        """
        models = [(name, name, here.fit, 0.0) for name in here.fit.effects]
        models += [(name, other, fit, more) for (name, other), (fit, more) in exchanged.items()]
        found = [(name, fit, self._over_kind(here, (model, more), fit, size))
                 for name, other, model, more in models for size, fit in self._of_kinds(model, other)]  # fmt: skip
        found += [one for name, fit, _ in found if name in fit.effects for one in self._fewer(here, name, fit)]
        return [one for one in found if one[2] > LEAST]

    def _fewer(self, here: View, name: str, fit: Fit) -> Iterator[tuple[str, Fit, float]]:
        """Fits with an effect in another kind, without one of those that may have made up for its first kind."""
        for other in fit.effects:
            rest = without(frozenset(fit.effects), other, self.beside)
            if other != name and name in rest:
                fewer = self.subject.fit(tuple(one for one in fit.effects if one in rest), [fit.values])
                if fewer is not None:
                    yield name, fewer, self.over(here, fewer)

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

    def _over_kind(self, here: View, model: tuple[Fit, float], fit: Fit, size: Size) -> float:
        """Ln evidence of another kind: where kinds differ most beyond the readings, alike for all that fit nearly.

        No form is exact, so that many readings choose one by what is hardly seen, and it then says alone what came
        before them. Those count that leave less than COARSE times as much, at which a form is refuted.
        """
        if not size.extrapolated:
            return self.over(here, fit)
        return model[1] if fit.chi_squared < COARSE * model[0].chi_squared else -math.inf

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


def _nearest(off: Sequence[tuple[Set, float]], besides: Set) -> float:
    """Difference by the fit that is most like a set in what it has besides; of several alike the smallest."""
    return min(((len(one ^ besides), value) for one, value in off), default=(0, 0.0))[1]


def cost(fit: Fit | None) -> int:
    """How many usual fits one counts for: along a bent valley, or of dear motions, it takes as long as several."""
    return 1 if fit is None else 1 + int(fit.steps * fit.dear) // USUAL
