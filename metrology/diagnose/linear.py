"""The fitted model as a straight line around its optimum: scores of candidates, and what chance alone makes of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from metrology.diagnose.subject import Array, Direction, Fit
from metrology.gum.matrix import root
from metrology.identify.covariance import inverse

DRAWS = 4000
"""Draws of the scores under the null, for their limit."""
INVISIBLE = 2e-3
"""Share of a direction that known and sought inputs leave of it, below which nothing of it can be seen."""

UNSTATED = 0.01
"""Part of a direction, squared, that inputs without a prior may take over where stated ones take over the rest."""


@dataclass(frozen=True)
class Score:
    """How much the data ask for a candidate at the optimum of a model without it.

    Parameters
    ----------
    direction : Direction
        One shape of the candidate.
    d : float
        Distance in standard deviations by which the trial amount moves the data, all known inputs marginalised.
    z : float
        Amount that the data ask for, in standard deviations; where it may act in q ways, the equivalent of χ²(q).
    factor : float
        Amount that the data ask for over the trial amount; negative where it would act the wrong way.
    share : float
        Part of the direction that the other unknowns cannot take over, from 0 to 1.
    p_value : float
        Chance of a score as large, for this direction alone with the looks among which it was picked.
    factors : tuple of float
        `factor` of every way in which it may act.
    shift : ndarray, shape (p,)
        By how much the unknowns of the model change when the candidate is there with that amount.
    """

    direction: Direction
    d: float
    z: float
    factor: float
    share: float
    p_value: float
    factors: tuple[float, ...] = ()
    shift: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Screen:
    """Scores of all directions, the limit of the largest, and the cosines between them after projection.

    `limit`: the p-value below which a score is one that chance gives in `false_alarm` of all campaigns only.
    """

    scores: tuple[Score, ...]
    limit: float
    false_alarm: float
    cosines: Array

    def best(self, effect: str) -> Score | None:
        """Score of the shape that the data like best."""
        own = [score for score in self.scores if score.direction.effect == effect]
        # Beyond z = 38 no p-value is left to tell them by.
        return min(own, key=lambda score: (score.p_value, -score.z), default=None)

    @property
    def found(self) -> tuple[Score, ...]:
        """Best score of each candidate, the most significant first."""
        effects = dict.fromkeys(score.direction.effect for score in self.scores)
        best = [score for effect in effects if (score := self.best(effect)) is not None]
        return tuple(sorted(best, key=lambda score: (score.p_value, -score.z)))

    @property
    def promise(self) -> float:
        """Fall of χ² that the most significant candidate promises on the straight line; 0 where it is within chance."""
        return max((float(one.z) ** 2 for one in self.found[:1] if one.p_value <= self.limit), default=0.0)


def gathered(fit: Fit, rows: Sequence[Array]) -> Array:
    """JᵀG over all blocks, shape (p, …)."""
    total = np.zeros((len(fit.theta), *rows[0].shape[1:]))
    for block, slope, part in zip(fit.problem.blocks, fit.slopes, rows, strict=True):
        total[np.array(block.uses)] += slope.T @ part
    return total


def screen(
    fit: Fit, directions: Sequence[Direction], signed: Sequence[bool], rng: np.random.Generator, false_alarm: float
) -> Screen:
    """Score test of every direction: z = −Gᵀr / √D, D = GᵀG − (JᵀG)ᵀ·H⁻¹·JᵀG.

    Rao, Proc. Camb. Phil. Soc. 44 (1948) 50. Known inputs count with their priors in H, so that what they can take
    over does not count as evidence; what a search left of the gradient is taken out by one Newton step. The limit is
    found by drawing all scores together under the null.

    Parameters
    ----------
    fit : Fit
        Model without the candidates.
    directions : sequence of Direction
        What a little of each would do.
    signed : sequence of bool
        Whether each may act either way.
    rng : Generator
        For the draws under the null.
    false_alarm : float
        Share of campaigns with nothing missing in which the largest score may pass the limit.
    """
    columns = [np.concatenate([part.reshape(len(part), -1) for part in one.rows]) for one in directions]
    widths = [column.shape[1] for column in columns]
    if not columns:
        return Screen((), 0.0, false_alarm, np.zeros((0, 0)))
    G = np.hstack(columns)
    bounds = np.cumsum([0, *(len(part) for part in fit.residuals)])
    blocks = [G[first:last] for first, last in pairwise(bounds)]
    JG, bread = gathered(fit, blocks), inverse(fit.information)
    plain = G.T @ G
    D = plain - JG.T @ bread @ JG
    b = JG.T @ bread @ fit.gradient - G.T @ np.concatenate(fit.residuals)
    _stated(fit, directions, (JG, D, b))
    sides = [bool(one) for one in signed]
    scores, starts = [], np.cumsum([0, *widths])
    for at, direction in enumerate(directions):
        own = slice(int(starts[at]), int(starts[at + 1]))
        lent = widths[at] == 1 and _lent(fit, direction, int(starts[at]), plain, (JG, D, b))
        score = _score(direction, b[own], D[own, own], plain[own, own], sides[at], lent=lent)
        taken = JG[:, own] @ score.factors if score.factors else np.zeros(len(bread))
        scores.append(replace(score, shift=-bread @ (fit.gradient + taken)))
    size = np.sqrt(np.maximum(np.diag(D), 1e-30))
    correlation = np.clip(D / np.outer(size, size), -1.0, 1.0)
    limit = _limit(correlation, starts, sides, [one.looks for one in directions], rng, false_alarm)
    first = starts[:-1]
    return Screen(tuple(scores), limit, false_alarm, correlation[np.ix_(first, first)])


def _stated(fit: Fit, directions: Sequence[Direction], sums: tuple[Array, Array, Array]) -> None:
    """Put in the sums of inputs that have a prior: differences of large numbers otherwise.

    With G = J·eᵢ·a and Jᵀr = −P·(θ − μ) at the optimum: D = a²·(Pᵢ − Pᵢ²·(H⁻¹)ᵢᵢ), b = a·Pᵢ·(θᵢ − μᵢ), and with other
    directions a·Pᵢ·(H⁻¹·JᵀG)ᵢ.
    """
    JG, D, b = sums
    bread, precision = inverse(fit.information), fit.problem.precision
    theta = fit.theta - bread @ fit.gradient
    widths = [1 if one.rows[0].ndim == 1 else one.rows[0].shape[1] for one in directions]
    taken = bread @ JG
    for column, one in zip(np.cumsum([0, *widths[:-1]]), directions, strict=True):
        at = one.stated
        if at is None:
            continue
        D[column] = D[:, column] = one.amount * precision[at] * taken[at]
        D[column, column] = one.amount**2 * (precision[at] - precision[at] ** 2 * bread[at, at])
        b[column] = one.amount * precision[at] * (theta[at] - fit.problem.mean[at])


def _lent(fit: Fit, direction: Direction, column: int, plain: Array, sums: tuple[Array, Array, Array]) -> bool:
    """Put in the sums of a direction that stated inputs take over, so that nothing but their priors speaks against it.

    Such is the compliance of a set-up beside a stated stiffness: to the data it is a softer line. As in `_stated`, with
    G = J·a: D = aᵀ·P·a − aᵀ·P·H⁻¹·P·a, b = aᵀ·P·(θ − μ). Not where an input without a prior takes part of it over: then
    nothing of it can be seen.
    """
    JG, D, b = sums
    if direction.stated is not None or D[column, column] > INVISIBLE**2 * plain[column, column]:
        return False
    bread, precision = inverse(fit.information), fit.problem.precision
    a = bread @ JG[:, column]
    free = np.where(precision == 0, a, 0.0)
    if float(free @ fit.information @ free) > UNSTATED * plain[column, column]:
        return False
    pulled = precision * a
    D[column] = D[:, column] = pulled @ bread @ JG
    D[column, column] = float(pulled @ a - pulled @ bread @ pulled)
    b[column] = float(pulled @ (fit.theta - bread @ fit.gradient - fit.problem.mean))
    return True


def _score(direction: Direction, b: Array, D: Array, plain: Array, signed: bool, *, lent: bool = False) -> Score:
    share = math.sqrt(max(float(np.trace(D)), 0.0) / max(float(np.trace(plain)), 1e-300))
    share = max(share, INVISIBLE) if lent else share
    d = math.sqrt(max(float(D[0, 0]), 0.0))
    if (share < INVISIBLE and direction.stated is None) or d < 1e-9:
        return Score(direction, 0.0, 0.0, 0.0, share, 1.0)
    amounts = np.linalg.lstsq(D, b, rcond=1e-9)[0]
    gain = max(float(amounts @ b), 0.0)
    # The wrong way only where one way is wrong: what may act either way tells its sign by its factor.
    z = math.sqrt(gain) * (1.0 if signed or len(b) > 1 or amounts[0] >= 0 else -1.0)
    p = float(chance(np.array([z]), len(b), signed)[0])
    return Score(direction, d, z, float(amounts[0]), share, _among(p, direction.looks), tuple(amounts.tolist()))


def _among(p: float, looks: float) -> float:
    """Chance that the best of many looks has a p-value as small."""
    return -math.expm1(looks * math.log1p(-min(p, 1 - 1e-15))) if looks > 1 else p


def chance(z: Array, ways: int, signed: bool) -> Array:
    """Chance of a score as large: two-sided, one-sided, or of χ² where it may act in several ways."""
    from scipy.special import erfc, gammaincc

    if ways > 1:
        found: Array = np.asarray(gammaincc(ways / 2, z**2 / 2), dtype=float)
    elif signed:
        found = np.asarray(erfc(np.abs(z) / math.sqrt(2)), dtype=float)
    else:
        found = np.asarray(0.5 * erfc(z / math.sqrt(2)), dtype=float)
    return found


def _limit(
    correlation: Array, starts: Array, signed: Sequence[bool], looks: Sequence[float], rng: np.random.Generator,
    false_alarm: float,
) -> float:  # fmt: skip
    """p-value that the most significant of all scores undercuts in `false_alarm` of all campaigns."""
    z = rng.standard_normal((DRAWS, len(correlation))) @ root(correlation)
    smallest = np.ones(DRAWS)
    for at, side in enumerate(signed):
        own = z[:, int(starts[at]) : int(starts[at + 1])]
        ways = own.shape[1]
        p = chance(own[:, 0] if ways == 1 else np.sqrt((own**2).sum(axis=1)), ways, side)
        smallest = np.minimum(smallest, np.minimum(1.0, p * looks[at]))
    return tail(np.sort(smallest), false_alarm)


def tail(smallest: Array, false_alarm: float) -> float:
    """Quantile of the smallest p-value; beyond the draws by its slope there, which is straight for small p."""
    share = max(false_alarm, 0.02)
    at = float(np.quantile(smallest, share))
    return at * false_alarm / share
