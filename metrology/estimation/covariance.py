"""How well the unknowns are known: covariance by source, for residuals that may be correlated in time; evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from metrology.estimation.problem import Array, Problem, Unknown, gram
from metrology.estimation.solver import Solution

BLIND = 1e-60
"""Stands for the information on an unknown of which the readings say nothing."""


@dataclass(frozen=True)
class Scatter:
    """What the residuals of one channel of one block say about its noise.

    Parameters
    ----------
    block, channel : str
        Where.
    count : int
        Readings with weight.
    chi_squared : float
        Mean square of the weighted residuals: 1 where the noise is as stated and the model holds.
    correlation_length : float
        τ = 1 + 2·Σρ: readings for one independent reading.
    """

    block: str
    channel: str
    count: int
    chi_squared: float
    correlation_length: float

    @property
    def inflation(self) -> float:
        """Factor on the variance that the readings of this channel contribute; never below 1."""
        return max(1.0, self.chi_squared * self.correlation_length)


@dataclass(frozen=True)
class Covariance:
    """Covariance of the unknowns H⁻¹·(M + P)·H⁻¹ with its parts.

    Parameters
    ----------
    bread : ndarray, shape (p, p)
        H⁻¹, H = JᵀJ + P.
    readings : ndarray, shape (p, p)
        H⁻¹·M·H⁻¹, M = Σ inflation·JᵀJ channel by channel: the part that the readings bring.
    priors : mapping of int to ndarray, shape (p,)
        For each unknown with a prior: what its standard uncertainty does to every unknown, H⁻¹[:, j]/u_j.
    scatter : tuple of Scatter
        Channel by channel.
    """

    bread: Array
    readings: Array
    priors: dict[int, Array]
    scatter: tuple[Scatter, ...]

    @property
    def total(self) -> Array:
        """All parts together, shape (p, p)."""
        parts = [np.outer(column, column) for column in self.priors.values()]
        total: Array = self.readings + sum(parts, np.zeros_like(self.readings))
        return total


def correlation_length(residual: Array) -> float:
    """Readings for one independent reading, τ = 1 + 2·Σρ_l, at least 1.

    Sum over lags while ρ of two neighbouring lags together stays above its own noise (Geyer, Statist. Sci. 7 (1992)
    473, initial positive sequence).
    """
    n = len(residual)
    if n < 8 or not residual.any():
        return 1.0
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(residual, size)
    rho = np.fft.irfft(np.abs(spectrum) ** 2, size)[: n // 2]
    rho = rho / rho[0]
    pairs = rho[1:-1:2] + rho[2::2]
    below = np.flatnonzero(pairs < 2.0 * math.sqrt(2.0 / n))
    last = int(below[0]) if below.size else len(pairs)
    return max(1.0, 1.0 + 2.0 * float(pairs[:last].sum()))


def covariance(problem: Problem, solution: Solution) -> Covariance:
    """Covariance of the unknowns at a solution.

    Sandwich estimate: the bread H⁻¹ of the weighted fit, the meat M with each channel's JᵀJ times its mean square
    residual and its correlation length (effective sample size), so that noise that is larger or slower than stated
    widens the interval. The priors enter as Type B components (JCGM 100, 5.1.2).

    Raises
    ------
    ValueError
        For a solution that failed.
    """
    if solution.point is None or solution.slope is None:
        message = "no covariance for a search that failed"
        raise ValueError(message)
    bread = bread_of(problem, solution.slope.blocks)
    readings = np.zeros_like(bread)
    scatter = []
    for block, residual, jacobian in zip(problem.blocks, solution.point.residuals, solution.slope.blocks, strict=True):
        rows = bread[list(block.uses)]
        for segment in block.segments:
            part, slope = residual[segment.first : segment.last], jacobian[segment.first : segment.last]
            used = part != 0.0
            if not used.any():
                continue
            count, mean_square = int(used.sum()), float(np.square(part).sum()) / float(used.sum())
            found = Scatter(block.name, segment.name, count, mean_square, correlation_length(part[used]))
            scatter.append(found)
            # Before it is squared: JᵀJ keeps half of the digits.
            readings += found.inflation * gram(slope @ rows)
    priors = {
        at: bread[:, at] / entry.u for at, entry in enumerate(problem.unknowns) if entry.u is not None and entry.u > 0
    }
    return Covariance(bread, readings, priors, tuple(scatter))


def inverse(information: Array) -> Array:
    """Inverse of an information matrix, scaled to unit diagonal first; without information: a huge variance.

    Parameters
    ----------
    information : ndarray, shape (p, p)
        Symmetric.

    Returns
    -------
    ndarray, shape (p, p)
        Its inverse; directions known 1e14 times worse than the best are cut off there.
    """
    diagonal = np.diag(information)
    size = np.sqrt(np.where(diagonal > 0, diagonal, BLIND))
    values, vectors = np.linalg.eigh(information / np.outer(size, size))
    values = np.maximum(values, 1e-14 * float(values.max(initial=1.0)))
    scaled = (vectors / values) @ vectors.T
    found: Array = scaled / np.outer(size, size)
    return found


def spread(rows: Array) -> Array:
    """Inverse of JᵀJ from J itself, by QR and singular values; without information: a huge variance, as `inverse`.

    The product JᵀJ keeps half of the digits only: where one unknown is known 1e6 times as well as another that moves
    the same readings, no digit of the second is left in it.

    Parameters
    ----------
    rows : ndarray, shape (n, p)
        J.

    Returns
    -------
    ndarray, shape (p, p)
        (JᵀJ)⁻¹.
    """
    size = np.linalg.norm(rows, axis=0)
    size = np.where(size > 0, size, math.sqrt(BLIND))
    _, values, vectors = np.linalg.svd(np.linalg.qr(rows / size, mode="r"))
    values = np.maximum(values, 1e-7 * float(values.max(initial=1.0)))
    scaled = vectors.T / values
    found: Array = scaled @ scaled.T / np.outer(size, size)
    return found


def bread_of(problem: Problem, slopes: Sequence[Array]) -> Array:
    """H⁻¹ of a problem with these derivatives of its blocks, H = JᵀJ + P.

    Parameters
    ----------
    problem : Problem
        With the precisions P of its priors.
    slopes : sequence of ndarray, shape (n, p)
        Derivatives J of the whitened residuals, block by block.

    Returns
    -------
    ndarray, shape (p, p)
        H⁻¹, in the units of the unknowns.
    """
    rows = [np.diag(np.sqrt(problem.precision))]
    for block, part in zip(problem.blocks, slopes, strict=True):
        reduced = np.linalg.qr(part, mode="r")
        wide = np.zeros((len(reduced), len(problem.unknowns)))
        wide[:, list(block.uses)] = reduced
        rows.append(wide)
    return spread(np.vstack(rows))


def log_evidence(problem: Problem, solution: Solution) -> float:
    """Logarithm of the evidence ∫ p(data|θ)·p(θ) dθ by Laplace's approximation.

    ln Z = −½·cost − Σ ln(u·√(2π)) − Σ ln(prior widths) + ½·p·ln(2π) − ½·ln det H (MacKay, Information Theory, Inference
    and Learning Algorithms (2003), 27). An unknown without a prior counts as uniform between its bounds where both are
    finite, else over a width of its start value (at least its scale).
    """
    if solution.point is None or solution.slope is None:
        return -math.inf
    sign, determinant = np.linalg.slogdet(solution.slope.information)
    if sign <= 0:
        return -math.inf
    data = -0.5 * solution.cost - sum(block.log_u for block in problem.blocks)
    widths = sum(math.log(_width(entry)) for entry in problem.unknowns)
    return float(data - widths + 0.5 * len(problem.unknowns) * math.log(2 * math.pi) - 0.5 * determinant)


def _width(entry: Unknown) -> float:
    if entry.u is not None:
        return entry.u * math.sqrt(2 * math.pi)
    if math.isfinite(entry.high - entry.low):
        return entry.high - entry.low
    return max(abs(entry.start), entry.scale)
