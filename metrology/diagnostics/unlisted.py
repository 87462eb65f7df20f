"""Unlisted laws beside the model: their probability, and what they do to k and c."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from metrology.diagnostics.column_gain import INVISIBLE
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.families import Family, families
from metrology.diagnostics.fits import COARSE
from metrology.diagnostics.judged import FAR, WithLaw
from metrology.diagnostics.laws import Few, Law, estimates, of_families, together
from metrology.diagnostics.likelihood import Noise, weighted
from metrology.diagnostics.line import Line, base_places, effect_places, line
from metrology.diagnostics.misfit import misfit, narrow
from metrology.diagnostics.probability import probabilities
from metrology.diagnostics.search import Search
from metrology.diagnostics.sets import NEGLIGIBLE, Scarce, Set, is_whole, log_likelihood, log_prior
from metrology.diagnostics.span import orthonormal
from metrology.diagnostics.view import View
from metrology.noise import Colour


def sharpened(search: Search, view: View, forms: Sequence[Direction]) -> tuple[Line, float]:
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


def law_beside(
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
    instead_of = probabilities(over, others)
    instead = {name: math.fsum(w for one, w in instead_of.items() if name not in one) for name in own}
    laws[own] = every
    everywhere = {**over, own: beside + math.log(listed)}
    unlisted = math.fsum(probabilities(everywhere, others).values())
    # Of few readings, the unknowns are those of the models that can be given, not of all sets like one of them.
    over = everywhere if free is None else {**over, own: beside}
    weights = probabilities(over, others)
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
    """Part that each family has in the evidence of all; a law that mimics another gives half of its part to that one.

    The unknowns are as uncertain then as beside the other: small harmonics choose between the two, in which the form
    of neither is exact.
    """
    from scipy.special import softmax

    shares = [float(share) for share in softmax([law.log_bayes for law in laws])]
    places = {law.family: at for at, law in enumerate(laws) if law.kinds}
    for at, law in enumerate(laws):
        if law.mimics in places:
            shares[at] /= 2
            shares[places[law.mimics]] += shares[at]
    return shares


def _refuted(sharper: Line, left: float) -> bool:
    """Whether a law leaves of the readings what is no noise: χ² in the metric of a line, over that of the noise."""
    return bool(left * sharper.noise.misfit > COARSE * (sharper.count - sharper.base.shape[1]))


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
