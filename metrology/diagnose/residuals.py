"""Is anything left? Residuals summed over blocks of several lengths, against what chance gives on the same inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from metrology.diagnose.subject import Array, Fit
from metrology.diagnosis import Test
from metrology.gum.matrix import root
from metrology.identify.covariance import inverse

SHORTEST = 8
"""Readings in the shortest block; each further length is four times the one before."""
LENGTHS = 4
DRAWS = 400
FEW = 6
"""Blocks of a length that a channel must give for that length to be tested."""


@dataclass(frozen=True)
class Blocked:
    """Residuals and derivatives of one channel of one run, summed over the shortest blocks."""

    name: str
    channel: str
    sums: Array
    slopes: Array
    uses: tuple[int, ...]


def test(fit: Fit, rng: np.random.Generator, false_alarm: float) -> Test:
    """Residual test: the largest standardised sum of squared block sums over channels, runs and block lengths.

    A block sum of n weighted residuals over √n is standard normal under the null, but for what the fit took out of it.
    That, and how the sums hang together, is found by drawing noise and known inputs anew and fitting again on the
    straight line (parametric bootstrap). The level of the noise is taken from within the blocks, so that a wrongly
    stated noise is no structure.

    Parameters
    ----------
    fit : Fit
        The model with the effects that it carries.
    rng : Generator
        For the draws.
    false_alarm : float
        Share of campaigns with nothing missing in which the test may fail.
    """
    if fit.structure is not None:
        return fit.structure(fit, false_alarm)
    parts = _blocked(fit)
    if not parts:
        return _whole(fit, false_alarm)
    names = _names(parts)
    null = _null(fit, parts, rng)
    mean, spread = null.mean(axis=0), np.maximum(null.std(axis=0, ddof=1), 1e-12)
    seen = (_statistics(parts, [part.sums[None] for part in parts])[0] - mean) / spread
    largest = ((null - mean) / spread).max(axis=1)
    worst = int(np.argmax(seen))
    p = _gumbel(largest, float(seen[worst]))
    limit = _gumbel_limit(largest, false_alarm)
    passed = p >= false_alarm
    where = names[worst]
    words = "no structure beyond noise" if passed else "structure that noise and known inputs do not give"
    sentence = (
        f"{words}: the largest departure, in {where}, is {seen[worst]:.1f} standard deviations "
        f"(limit {limit:.1f}, p = {p:.2g})"
    )
    return Test("residual", float(seen[worst]), limit, p, false_alarm, passed, sentence[0].upper() + sentence[1:] + ".")


def _whole(fit: Fit, false_alarm: float) -> Test:
    """χ² of all readings, where they are too few for blocks."""
    from scipy.special import gammaincc, gammainccinv

    free = sum(entry.u is None for entry in fit.problem.unknowns)
    dof = max(fit.count - free, 1)
    p = float(gammaincc(dof / 2, fit.chi_squared / 2))
    limit = 2 * float(gammainccinv(dof / 2, false_alarm))
    words = "no more scatter than stated" if p >= false_alarm else "more scatter than the readings themselves show"
    sentence = (
        f"{words.capitalize()}: χ² = {fit.chi_squared:.1f} with {dof} degrees of freedom "
        f"(limit {limit:.1f}, p = {p:.2g})."
    )
    return Test("residual", fit.chi_squared, limit, p, false_alarm, p >= false_alarm, sentence)


def _blocked(fit: Fit) -> list[Blocked]:
    found = []
    for block, residual, slope, used in zip(fit.problem.blocks, fit.residuals, fit.slopes, fit.used, strict=True):
        for segment in block.segments:
            rows = np.flatnonzero(used[segment.first : segment.last]) + segment.first
            count = len(rows) // SHORTEST
            if count < FEW:
                continue
            cut = rows[: count * SHORTEST].reshape(count, SHORTEST)
            cells = residual[cut]
            level = max(scatter_within(residual[rows]), 1e-6)
            sums = cells.sum(axis=1) / math.sqrt(SHORTEST) / level
            slopes = slope[cut].sum(axis=1) / math.sqrt(SHORTEST)
            found.append(Blocked(block.name, segment.name, sums, slopes, block.uses))
    return found


def scatter_within(residual: Array) -> float:
    """Standard deviation within the shortest blocks, which slow structure does not change; NaN with too few of them."""
    count = len(residual) // SHORTEST
    if count < FEW:
        return math.nan
    cells = residual[: count * SHORTEST].reshape(count, SHORTEST)
    return math.sqrt(float(cells.var(axis=1, ddof=1).mean()))


def _coarser(sums: Array) -> Array:
    """Block sums of four times the length, shape (draws, n // 4)."""
    count = sums.shape[1] // 4
    found: Array = sums[:, : 4 * count].reshape(len(sums), count, 4).sum(axis=2) / 2.0
    return found


def _levels(count: int) -> int:
    return sum(count // 4**level >= FEW for level in range(LENGTHS))


def _names(parts: list[Blocked]) -> list[str]:
    found = []
    for part in parts:
        lengths = [SHORTEST * 4**level for level in range(_levels(len(part.sums)))]
        found += [f"{part.channel} of {part.name}, blocks of {length} readings" for length in lengths]
    channels = dict.fromkeys(part.channel for part in parts)
    found += [
        f"{channel} of all runs, {SHORTEST * 4**level} readings" for channel in channels for level in range(LENGTHS)
    ]
    return found


def _statistics(parts: list[Blocked], sums: list[Array]) -> Array:
    """Mean squares by part and length, then by channel and length, shape (draws, ·)."""
    columns, pooled = [], {(part.channel, level): 0.0 for part in parts for level in range(LENGTHS)}
    for part, own in zip(parts, sums, strict=True):
        here = own
        for level in range(_levels(len(part.sums))):
            squares = (here**2).sum(axis=1)
            columns.append(squares)
            pooled[part.channel, level] = pooled[part.channel, level] + squares
            here = _coarser(here)
    draws = len(sums[0])
    channels = dict.fromkeys(part.channel for part in parts)
    for channel in channels:
        columns += [np.broadcast_to(pooled[channel, level], (draws,)) for level in range(LENGTHS)]
    return np.column_stack(columns)


def _null(fit: Fit, parts: list[Blocked], rng: np.random.Generator) -> Array:
    """Statistics of draws under the null."""
    bread, size = inverse(fit.information), len(fit.theta)
    taken = np.zeros((size, size))
    noises, pulls = [], np.zeros((DRAWS, size))
    for part in parts:
        rows = np.array(part.uses)
        noise = rng.standard_normal((DRAWS, len(part.sums)), dtype=np.float32).astype(float)
        noises.append(noise)
        pulls[:, rows] += noise @ part.slopes
        np.add.at(taken, (rows[:, None], rows[None, :]), part.slopes.T @ part.slopes)
    # Jᵀε has a part that block sums do not see, and the priors add theirs: together they have the covariance H − taken.
    rest = root(_scaled(fit.information - taken, fit.information)) * np.sqrt(np.diag(fit.information))
    pulls += rng.standard_normal((DRAWS, size)) @ rest
    moved = pulls @ bread
    sums = [noise - moved[:, np.array(part.uses)] @ part.slopes.T for noise, part in zip(noises, parts, strict=True)]
    return _statistics(parts, sums)


def _scaled(matrix: Array, by: Array) -> Array:
    size = np.sqrt(np.maximum(np.diag(by), 1e-300))
    scaled: Array = matrix / np.outer(size, size)
    return scaled


def _gumbel(draws: Array, value: float) -> float:
    """Chance of a largest value as large, by a Gumbel distribution with the moments of the draws."""
    scale = float(draws.std(ddof=1)) * math.sqrt(6) / math.pi
    place = float(draws.mean()) - 0.5772156649 * scale
    return -math.expm1(-math.exp(-min(max((value - place) / scale, -30.0), 700.0)))


def _gumbel_limit(draws: Array, false_alarm: float) -> float:
    scale = float(draws.std(ddof=1)) * math.sqrt(6) / math.pi
    place = float(draws.mean()) - 0.5772156649 * scale
    return place - scale * math.log(-math.log1p(-false_alarm))
