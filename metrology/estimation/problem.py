"""A least-squares problem with priors, whatever the model: unknowns, and blocks of weighted residuals."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Marks = NDArray[np.bool_]


@dataclass(frozen=True)
class Unknown:
    """One number that is sought.

    Parameters
    ----------
    name : str
        Unique in the problem.
    start : float
        Where the search begins.
    scale : float
        A change of this size is neither tiny nor huge.
    low, high : float
        Closed bounds; the start lies within.
    mean, u : float or None
        What is known beforehand: a normal distribution, which enters as one pseudo-observation. None: nothing.
    unit : str
        SI unit, written out.
    """

    name: str
    start: float
    scale: float = 1.0
    low: float = -math.inf
    high: float = math.inf
    mean: float | None = None
    u: float | None = None
    unit: str = "1"


@dataclass(frozen=True)
class Segment:
    """Rows ``first:last`` of a block that belong to one channel."""

    name: str
    first: int
    last: int


@dataclass(frozen=True)
class Block:
    """Data that depend on some of the unknowns only: one run, one record.

    Parameters
    ----------
    name : str
        Of the run or record.
    uses : tuple of int
        Indices of the unknowns that the block depends on.
    residuals : callable
        Takes the values of `uses`, shape (len(uses),); returns weighted residuals (reading − model) / u, shape (n,),
        zero for readings without weight; None where the model has no answer.
    derivatives : callable
        Takes the same; returns the derivative of the residuals, shape (n, len(uses)), or None.
    segments : tuple of Segment
        The channels within the rows.
    count : int
        Readings that carry weight.
    log_u : float
        Σ ln(u·√(2π)) over those readings, which the evidence needs.
    """

    name: str
    uses: tuple[int, ...]
    residuals: Callable[[Array], Array | None]
    derivatives: Callable[[Array], Array | None]
    segments: tuple[Segment, ...]
    count: int
    log_u: float = 0.0


@dataclass(frozen=True)
class Problem:
    """Minimise Σ r² over all blocks plus Σ ((θ − mean)/u)² over the priors."""

    unknowns: tuple[Unknown, ...]
    blocks: tuple[Block, ...]

    @property
    def start(self) -> Array:
        """Start of every unknown, shape (p,)."""
        return np.array([entry.start for entry in self.unknowns])

    @property
    def low(self) -> Array:
        """Lower bounds, shape (p,)."""
        return np.array([entry.low for entry in self.unknowns])

    @property
    def high(self) -> Array:
        """Upper bounds, shape (p,)."""
        return np.array([entry.high for entry in self.unknowns])

    @property
    def precision(self) -> Array:
        """1/u² of every prior, 0 without one, shape (p,)."""
        return np.array([0.0 if entry.u is None else entry.u**-2 for entry in self.unknowns])

    @property
    def mean(self) -> Array:
        """Mean of every prior, 0 without one, shape (p,)."""
        return np.array([0.0 if entry.mean is None else entry.mean for entry in self.unknowns])

    @property
    def count(self) -> int:
        """Readings that carry weight, all blocks together."""
        return sum(block.count for block in self.blocks)


@dataclass(frozen=True)
class Point:
    """The problem at one set of values: weighted residuals block by block, and the sum that is minimised."""

    theta: Array
    residuals: tuple[Array, ...]
    chi_squared: float
    penalty: float

    @property
    def cost(self) -> float:
        """Return χ² of the readings plus that of the priors."""
        return self.chi_squared + self.penalty


def evaluate(problem: Problem, theta: Array) -> Point | None:
    """Residuals and cost at `theta`, None where the model has no answer.

    Parameters
    ----------
    problem : Problem
        Blocks of residuals with priors.
    theta : ndarray, shape (p,)
        Values of the unknowns, in their units.

    Returns
    -------
    Point or None
        Whitened residuals by block, χ² and the part of the priors.
    """
    parts, squares = [], 0.0
    for block in problem.blocks:
        part = block.residuals(theta[list(block.uses)])
        if part is None:
            return None
        parts.append(part)
        with np.errstate(over="ignore"):  # Beyond the largest number: no answer, as said below.
            squares += float(np.square(part).sum())
    if not math.isfinite(squares):
        return None
    penalty = float(problem.precision @ (theta - problem.mean) ** 2)
    return Point(theta, tuple(parts), squares, penalty)


@dataclass(frozen=True)
class Slope:
    """Derivatives at a point: block by block, and gathered to gradient JᵀR + P(θ − μ) and Gram matrix JᵀJ + P."""

    blocks: tuple[Array, ...]
    gradient: Array
    information: Array


def gram(part: Array) -> Array:
    """JᵀJ, without BLAS: a search takes the same way on every processor, also where kinks make it stall."""
    columns = np.ascontiguousarray(part.T)
    found: Array = np.einsum("pn,qn->pq", columns, columns)
    return found


def slope(problem: Problem, point: Point) -> Slope | None:
    """Gradient and information at `point`, None where the model has no answer.

    Parameters
    ----------
    problem : Problem
        Blocks of residuals with priors.
    point : Point
        Where, with its residuals.

    Returns
    -------
    Slope or None
        Gradient, shape (p,), and information H = JᵀJ + P, shape (p, p).
    """
    parts = []
    gradient = problem.precision * (point.theta - problem.mean)
    information = np.diag(problem.precision)
    with np.errstate(over="ignore", invalid="ignore"):  # A motion that ran away: no answer, as said below.
        for block, residual in zip(problem.blocks, point.residuals, strict=True):
            part = block.derivatives(point.theta[list(block.uses)])
            if part is None:
                return None
            parts.append(part)
            rows = np.array(block.uses)
            np.add.at(gradient, rows, np.einsum("np,n->p", part, residual))
            np.add.at(information, (rows[:, None], rows[None, :]), gram(part))
    if not (np.isfinite(information).all() and np.isfinite(gradient).all()):
        return None
    return Slope(tuple(parts), gradient, information)
