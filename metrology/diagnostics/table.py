"""Effects among which sets are formed, and the evidence of every set along a straight line, in closed form."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.column_gain import carried_by, gain_of, orthonormal_of, tried_beside
from metrology.diagnostics.likelihood import RANK
from metrology.diagnostics.line import Column, Line
from metrology.diagnostics.sets import Scarce, Set, is_whole, log_likelihood, log_prior, price, ways
from metrology.diagnostics.subject import Array

ALIKE = 1e-9
"""Relative difference below which two shapes of an effect do the same to the readings: the first one tried stands."""
MOST = 12
"""Effects among which sets are looked at. The others are so weak that no set needs them."""
LARGEST = 4
"""Effects of a set at most: what needs more of them at once, such as a sensor that hopped, is explained by none."""


@dataclass(frozen=True)
class Member:
    """One effect of the table in the shape that the data like best: its columns beside the base, and their price.

    `open`: part of the price for shapes that were tried in a few places only, and not sought yet. `ways`: how many
    parameters it has.
    """

    column: Column
    rows: Array
    price: float
    open: float = 0.0
    ways: int = 1


@dataclass(frozen=True)
class Score:
    """A candidate alone beside a fit: standard deviations that the readings ask for; what its trial amount moves.

    `whole`: whether the readings can show it in each of its shapes.
    """

    z: float
    d: float
    amount: float
    whole: bool = True


@dataclass(frozen=True)
class Table:
    """Effects among which sets are formed, and everything that their evidence needs.

    Parameters
    ----------
    members : mapping of str to Member
        The effects, those of the fit first.
    gram, pull : ndarray, shapes (q, q) and (q,)
        GᵀG and −Gᵀr beside the base.
    squares : float
        Cost of the base alone.
    among : int
        Candidates of the whole list, which the prior counts.
    count : int
        Readings.
    laws, beside : mapping of str to str
        What each effect is one law of; the effect without which it is not tried.
    free : float or None
        Degrees of freedom of the model without effects, where the noise is estimated with the rest.
    rounding : float
        Cost that rounding of the readings leaves of any model, where the noise is estimated.
    """

    members: Mapping[str, Member]
    gram: Array
    pull: Array
    squares: float
    among: int
    count: int
    laws: Mapping[str, str]
    beside: Mapping[str, str]
    free: float | None = None
    rounding: float = 0.0

    def places(self, effects: Set) -> list[int]:
        """Columns of a set."""
        found: list[int] = []
        first = 0
        for name, member in self.members.items():
            width = member.rows.shape[1]
            if name in effects:
                found += range(first, first + width)
            first += width
        return found

    def amounts(self, effects: Set) -> tuple[Array, Array, float] | None:
        """Coefficients of a set with their standard uncertainties, and the fall of the cost; None where some are one.

        Columns that the others of the set contain cannot be told apart from them.
        """
        every = self.places(effects)
        amounts, u = np.zeros(len(every)), np.full(len(every), math.inf)
        # A shape that moves no reading here, such as a step between two loads, stays where it is.
        moves = np.array([self.gram[place, place] > 0.0 for place in every], dtype=bool)
        at = [place for place, one in zip(every, moves, strict=True) if one]
        if not at:
            return amounts, u, 0.0
        D, b = self.gram[np.ix_(at, at)], self.pull[at]
        size = np.sqrt(np.maximum(np.diag(D), 1e-300))
        scaled = D / np.outer(size, size)
        try:
            root = np.linalg.cholesky(scaled)
        except np.linalg.LinAlgError:
            return None
        if (np.diag(root) ** 2 < RANK).any():
            return None
        half = np.linalg.inv(root)
        inverse = half.T @ half
        found = inverse @ (b / size) / size
        amounts[moves], u[moves] = found, np.sqrt(np.diag(inverse)) / size
        return amounts, u, float(found @ b)

    def log_evidence(self, effects: Set) -> float:
        """Ln evidence of a set times its prior; −∞ where a size comes out with a sign that it cannot have."""
        found = self.amounts(effects)
        if found is None:
            return -math.inf
        amounts, u, gain = found
        total = self.log_likelihood(self.squares - gain + self.rounding, effects)
        total -= math.fsum(self.members[name].price for name in effects)
        first = 0
        for name, member in self.members.items():
            if name not in effects:
                continue
            if not member.column.signed:
                total += _one_sided(float(amounts[first]), float(u[first]))
            first += member.rows.shape[1]
        return total + log_prior(len(effects), self.among)

    def log_likelihood(self, cost: float, effects: Set) -> float:
        """Ln likelihood of the residual cost of a set."""
        scarce = None if self.free is None else Scarce(self.free, self.free)
        return log_likelihood(cost, scarce, sum(self.members[name].ways for name in effects))

    def sets(self) -> Iterator[Set]:
        """Every set of some effects with one law of a thing at most, each beside what it needs."""
        for count in range(min(len(self.members), LARGEST) + 1):
            for names in combinations(self.members, count):
                laws = [self.laws[name] for name in names if self.laws.get(name)]
                if len(laws) == len(set(laws)) and is_whole(frozenset(names), self.beside):
                    yield frozenset(names)

    def all(self) -> dict[Set, float]:
        """Ln evidence of every set."""
        return {one: self.log_evidence(one) for one in self.sets()}


def _one_sided(amount: float, u: float) -> float:
    """Ln of twice the probability that a size is not negative: the prior is on one side only."""
    from scipy.special import log_ndtr

    return float(math.log(2.0) + log_ndtr(amount / u)) if 0 < u < math.inf else 0.0


def table(line: Line, candidates: Mapping[str, Candidate], most: int = MOST, free: float | None = None) -> Table:
    """Effects of a fit and the strongest candidates beside them, each in its best shape.

    Parameters
    ----------
    line : Line
        Straight line at the fit.
    candidates : mapping of str to Candidate
        The whole list.
    most : int
        Effects at most.
    free : int, optional
        Degrees of freedom of the fit, where the noise is estimated with the rest.
    """
    blocks = len(line.fit.problem.blocks)
    prices = {one.effect: price(candidates[one.effect], line.count, blocks) for one in line.columns}
    residual = line.beside(line.residual)
    wide = {name: ways(candidates[name], blocks) for name in prices}
    members = {one.effect: Member(one, rows, prices[one.effect], ways=wide[one.effect])
               for one, rows in zip(line.columns, line.left, strict=True) if one.direction is None}  # fmt: skip
    span = orthonormal_of([member.rows for member in members.values()], len(residual))
    best: dict[str, tuple[float, Member]] = {}
    left = residual - span @ (span.T @ residual)
    for column, rows in tried_beside(line):
        gain = gain_of(column, rows - span @ (span.T @ rows), left, len(line.fit.theta))
        cost = prices[column.effect]
        if gain is not None and (column.effect not in best or gain - cost > best[column.effect][0] + ALIKE * gain):
            width = column.rows.shape[1]
            open_ = price(replace(candidates[column.effect], parameters=candidates[column.effect].sought[width:]),
                          line.count, blocks)  # fmt: skip
            best[column.effect] = (gain - cost, Member(column, rows, cost, open_, wide[column.effect]))
    ranked = sorted(best, key=lambda name: -best[name][0])
    for name in [*ranked[: max(most - len(members), 0)], *_masked(best, span, residual)]:
        if len(members) < most + 2:
            members[name] = best[name][1]
    G = np.hstack([one.rows for one in members.values()]) if members else np.zeros((len(residual), 0))
    laws, beside = ({name: getattr(candidates[name].cause, of) for name in members} for of in ("law", "beside"))
    among = max(len(prices), 1)
    return Table(members, G.T @ G, -G.T @ residual, float(residual @ residual), among, line.count, laws, beside, free)


def scores(line: Line) -> dict[str, Score]:
    """Score of every candidate in the shape that the readings like best, alone beside the fit."""
    span = orthonormal_of(list(carried_by(line).values()), len(line.residual))
    residual = line.beside(line.residual)
    residual = residual - span @ (span.T @ residual)
    found: dict[str, Score] = {}
    hidden: set[str] = set()
    for column, rows in tried_beside(line):
        rows = rows - span @ (span.T @ rows)
        gain = gain_of(column, rows, residual, len(line.fit.theta))
        if gain is None:
            hidden.add(column.effect)
            continue
        assert column.direction is not None
        one = Score(math.sqrt(2 * max(gain, 0.0)), float(np.linalg.norm(rows[:, 0])), column.direction.amount)
        if column.effect not in found or one.z > found[column.effect].z * (1 + ALIKE):
            found[column.effect] = one
    return {name: replace(one, whole=name not in hidden) for name, one in found.items()}


def instead(line: Line, candidates: Mapping[str, Candidate], name: str) -> dict[str, float]:
    """Ln evidence of candidates in the place of an effect of the fit, over that of the effect, by the straight line.

    Of those that are tried in several shapes and sought between them, each in the shape that suits it there: the one
    that is best beside the effect has nothing to do with it.
    """
    blocks, priors = len(line.fit.problem.blocks), len(line.fit.theta)
    carried = carried_by(line)
    own = carried.pop(name)
    span, residual = orthonormal_of(list(carried.values()), len(line.residual)), line.beside(line.residual)
    residual = residual - span @ (span.T @ residual)

    def worth(column: Column, rows: Array) -> float:
        gain = gain_of(column, rows - span @ (span.T @ rows), residual, priors)
        return -math.inf if gain is None else gain - price(candidates[column.effect], line.count, blocks)

    (effect,) = (one for one in line.columns if one.direction is None and one.effect == name)
    found: dict[str, float] = {}
    least = worth(effect, own)
    for column, rows in tried_beside(line):
        if any(size.shape and not size.held for size in candidates[column.effect].parameters):
            found[column.effect] = max(found.get(column.effect, -math.inf), worth(column, rows) - least)
    return found


def _masked(best: Mapping[str, tuple[float, Member]], span: Array, residual: Array) -> tuple[str, ...]:
    """Pair of candidates that gains most together: each alone may be hidden by the other."""
    single = [name for name, (_, member) in best.items() if member.rows.shape[1] == 1]
    if len(single) < 2:
        return ()
    G = np.hstack([best[name][1].rows for name in single])
    G = G - span @ (span.T @ G)
    size = np.linalg.norm(G, axis=0)
    seen = size > 0
    b = np.where(seen, -(G.T @ residual) / np.where(seen, size, 1.0), 0.0)
    C = (G.T @ G) / np.maximum(np.outer(size, size), 1e-300)
    det = np.maximum(1.0 - C**2, 1e-6)
    gain = 0.5 * (b[:, None] ** 2 + b[None, :] ** 2 - 2 * C * np.outer(b, b)) / det
    alone = 0.5 * np.maximum(b[:, None] ** 2, b[None, :] ** 2)
    np.fill_diagonal(gain, 0.0)
    gain[np.maximum(C**2, 0) > 1 - 1e-4] = 0.0
    one, other = np.unravel_index(int(np.argmax(gain)), gain.shape)
    return (single[one], single[other]) if gain[one, other] > 2 * alone[one, other] else ()
