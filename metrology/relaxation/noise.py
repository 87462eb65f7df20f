"""Colours that the noise of a record may have, at the means over its blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metrology.relaxation.blocks import Array, Blocks

MEMORIES = 9
"""Correlation times that are weighed, from two readings to the whole record."""
EXCESS, TIMES, ALONE = 2.0, 8.0, 100.0
"""Power at low frequencies of noise with a memory over that of the white noise on top of it: the least that is weighed,
from one to the next, and the variance from which on it stands alone."""
SHARE = 0.41
"""ν = 0.41·n^(2/3) lowest cosines give the level of the noise (Lazarus, Lewis, Stock & Watson, J. Bus. Econ. Stat. 36
(2018) 541, eq. 4)."""


@dataclass(frozen=True)
class Colours:
    """Colours with what makes each white.

    Parameters
    ----------
    whitening : ndarray, shape (g, n, n)
        Lower triangular: whitening·noise is white, of the level of the noise.
    log_det : ndarray, shape (g,)
        ln det of the covariance for unit variance.
    prior : ndarray, shape (g,)
        Probability beforehand.
    memory : ndarray, shape (g,)
        Correlation time / s; 0 of white noise.
    part : ndarray, shape (g,)
        Share of what has a memory in the variance of a reading.
    """

    whitening: Array
    log_det: Array
    prior: Array
    memory: Array
    part: Array

    def at(self, of: Blocks) -> Array:
        """Covariance of each colour at other blocks of the record, shape (g, m, m): of what is read, input apart."""
        white = np.diag(1.0 / of.count)
        slow = {memory: covariance(of, memory) if memory else white for memory in set(self.memory.tolist())}
        return np.array([part * slow[memory] + (1 - part) * white
                         for memory, part in zip(self.memory.tolist(), self.part.tolist(), strict=True)])  # fmt: skip


def colours(of: Blocks, imposed: Array) -> Colours:
    """Every colour that is weighed, at the blocks of a record.

    White noise, and white noise on top of an Ornstein–Uhlenbeck process, whose correlation over a time t is
    exp(−t/T): T from two readings to the duration of the record, evenly in its logarithm, so that a wander as slow as
    the record itself competes with what the specimen does.

    Parameters
    ----------
    of : Blocks
        The record.
    imposed : ndarray, shape (n, n)
        Covariance of what the noise of the input makes of the answer, over the variance of the white noise of one
        reading of that.
    """
    from scipy.linalg.lapack import dtrtri

    step, duration = float(np.median(of.step)), float(of.time[-1] - of.time[0])
    least = min(of.step.min() * 2, duration / 4)
    memories = np.geomspace(least, duration, MEMORIES)
    # White noise is as probable as all of one memory.
    found, known, parts, prior = [np.diag(1.0 / of.count) + imposed], [0.0], [0.0], [1.0]
    for memory in memories.tolist():
        correlated = covariance(of, memory)
        ratio = step / (2 * memory)
        steps = np.arange(0.0, np.log(ALONE / ratio / EXCESS), np.log(TIMES))
        for excess in (EXCESS * np.exp(steps)).tolist():
            part = excess * ratio / (1 + excess * ratio)
            found.append(part * correlated + (1 - part) * found[0])
            known.append(memory)
            parts.append(part)
            prior.append(1.0 / len(steps))
    roots = np.linalg.cholesky(np.array(found))
    log_det = 2 * np.log(np.diagonal(roots, axis1=1, axis2=2)).sum(axis=1)
    whitening = np.array([dtrtri(root, lower=1)[0] for root in roots])
    return Colours(whitening, log_det, np.array(prior) / sum(prior), np.array(known), np.array(parts))


def covariance(of: Blocks, memory: float) -> Array:
    """Covariance of the means over blocks of noise of unit variance with a memory / s, shape (n, n).

    Within a block readings are taken as even: var = (n·(1 − φ²) − 2φ·(1 − φⁿ))/(n·(1 − φ))², φ = exp(−Δt/T); between
    blocks the memory runs from the last reading of one to the first of the other.
    """
    n, phi = of.count.astype(float), np.exp(-of.step / memory)
    gap = np.maximum(of.begin[None, :] - of.end[:, None], 0.0)
    inside = -np.expm1(-n * of.step / memory) / (-np.expm1(-of.step / memory) * n)
    upper = np.triu(np.exp(-gap / memory) * inside[:, None] * inside[None, :], 1)
    away = -np.expm1(-of.step / memory)
    own = (n * (1 - phi**2) - 2 * phi * (-np.expm1(-n * of.step / memory))) / (n * away) ** 2
    return np.asarray(upper + upper.T + np.diag(np.where(of.count > 1, own, 1.0)))


def cosines(n: int, terms: int) -> int:
    """How many of the lowest cosines tell the level of the noise where `terms` are fitted to n means."""
    return int(min(max(round(SHARE * n ** (2 / 3)), 3), n - terms))


def level(rest: Array, columns: Array, inverse: Array, count: int) -> Array:
    """Variance of white residuals by their lowest cosines, over what the fit leaves of them there, shape (g,).

    Parameters
    ----------
    rest : ndarray, shape (g, n)
        White residuals.
    columns : ndarray, shape (g, n, q)
        White columns of the fit.
    inverse : ndarray, shape (g, q, q)
        (columnsᵀ·columns)⁻¹.
    count : int
        Cosines.
    """
    from scipy.fft import dct

    terms = columns.shape[2]
    low = slice(0, count + terms)
    rows = np.asarray(dct(columns, type=2, norm="ortho", axis=1))[:, low]
    left = np.asarray(dct(rest, type=2, norm="ortho", axis=1))[:, low]
    taken = np.einsum("gni,gij,gnj->gn", rows, inverse, rows)
    return np.asarray((left**2).sum(axis=1) / np.maximum((1 - taken).sum(axis=1), 1.0))
