"""One likelihood for a model and all candidate causes: coloured noise, priors, and what even the full list leaves.

readings = model(inputs, effects) + misfit + noise. Around a fit everything is linear: the evidence of every set of
effects is then closed-form (`line`, `table`). The noise is whitened channel by channel (`noise.colour`). What the model
with *all* candidates still leaves, the misfit, is measured where the unknowns act and enters their covariance as one
factor λ (White, Econometrica 50 (1982) 1, with one mean factor in place of a matrix).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.diagnostics.residual_spectra import segments
from metrology.diagnostics.span import RESOLVED, triangle
from metrology.diagnostics.subject import Array, Blocks, Fit, Marks, Slow
from metrology.estimation.covariance import spread
from metrology.noise import WHITE, Colour, colour

RANK = 1e-9
"""Part of a column below which what others leave of it is rounding."""


@dataclass(frozen=True)
class Noise:
    """Colour of every channel, and the factor of the misfit.

    Parameters
    ----------
    channels : mapping of str to Colour
        By name of the channel; white of unit size where one is not named.
    misfit : float
        λ ≥ 1: mean square, over that of the noise, of what the full list leaves where the unknowns act.
    """

    channels: Mapping[str, Colour]
    misfit: float = 1.0
    narrow: tuple[tuple[slice, Array, float], ...] = ()
    """Rows of a record, orthonormal whitened columns about a frequency in them, and its noise there over elsewhere."""

    def whitened(self, fit: Fit, rows: Blocks, used: Sequence[Marks]) -> Array:
        """Rows of all blocks, filtered channel by channel and stacked, shape (n, …); zero where `used` says so."""
        found = []
        for block, part, marks in zip(fit.problem.blocks, rows, used, strict=True):
            kept = part * (marks if part.ndim == 1 else marks[:, None])
            for segment in block.segments:
                one = self.channels.get(segment.name, WHITE)
                found.append(one.whitened(kept[segment.first : segment.last]))
        whole = np.concatenate(found)
        for rows_of, Q, factor in self.narrow:
            whole[rows_of] -= (1.0 - 1.0 / math.sqrt(factor)) * (Q @ (Q.T @ whole[rows_of]))
        return whole


def noise(fit: Fit, residuals: Blocks, floor: float = 0.0, taken: Array | None = None) -> Noise:
    """Colour of every channel from residuals, all blocks together.

    `taken`: orthonormal columns that were taken out of them, shape (n, q), readings stacked.
    """
    parts: dict[str, list[Array]] = {}
    along: dict[str, list[Array]] = {}
    stacked = iter(segments(fit))
    for block, part, used in zip(fit.problem.blocks, residuals, fit.used, strict=True):
        for segment in block.segments:
            rows = slice(segment.first, segment.last)
            parts.setdefault(segment.name, []).append(part[rows] * used[rows])
            here = next(stacked)
            if taken is not None:
                along.setdefault(segment.name, []).append(taken[here])
    return Noise({name: colour(own, floor, along.get(name, ())) for name, own in parts.items()})


def estimated(fit: Fit, by: Noise, used: Sequence[Marks]) -> tuple[Array, Array]:
    """Unknowns of a fit in the metric of the noise, by one step on the straight line, and their covariance."""
    root, precision = 1.0 / math.sqrt(by.misfit), np.sqrt(fit.problem.precision)
    J = np.vstack([root * by.whitened(fit, spread_out(fit), used), np.diag(precision)])
    r = np.concatenate([root * by.whitened(fit, fit.full, used), precision * (fit.theta - fit.problem.mean)])
    covariance = spread(J)
    return fit.theta - covariance @ (J.T @ r), covariance


def slow_motion(fit: Fit, by: Noise, used: Sequence[Marks], every: Sequence[Slow]) -> tuple[Array, list[Array]]:
    """Ln evidence over none for a slow motion of the readings: of a steady drift, and of all that is fitted for it.

    A steady drift has one coefficient in place of four or more; each has the price of unit information (½·ln n). With
    them the slow motion of each block, a value a term.
    """
    theta, spread = estimated(fit, by, used)
    evidence, motions = np.zeros(2), []
    for one in every:
        rows = one.places(fit)
        level, price = theta[rows], 0.5 * math.log(one.count)
        within = spread[np.ix_(rows, rows)] + one.rounding**2 * np.eye(len(rows))
        evidence += (
            0.5 * level[0] ** 2 / within[0, 0] - price,
            0.5 * level @ np.linalg.solve(within, level) - len(rows) * price,
        )
        motions.append(level)
    return evidence, motions


def weighted(fit: Fit, by: Noise, used: Sequence[Marks]) -> float:
    """Least cost of a fit in the metric of the noise: χ² / λ of the readings, and what the priors cost.

    The fit was found without the colour: one step on the straight line leads to the optimum with it. What such a step
    promises without the colour as well is not believed: the search has tried it.
    """
    root = 1.0 / math.sqrt(by.misfit)
    precision = np.sqrt(fit.problem.precision)
    J = np.vstack([root * by.whitened(fit, spread_out(fit), used), np.diag(precision)])
    r = np.concatenate([root * by.whitened(fit, fit.full, used), precision * (fit.theta - fit.problem.mean)])
    free = (fit.theta > fit.problem.low) & (fit.theta < fit.problem.high)
    whole = float(r @ r)
    return min(_left(J[:, free], r) + fit.unfinished, whole)


def _left(columns: Array, r: Array) -> float:
    """Sum of squares that columns leave of r, as `orthonormal` has their span, without forming it."""
    size = np.linalg.norm(columns, axis=0)
    R = triangle([columns[:, size > 0] / size[size > 0], r[:, None]])
    inside = R[:-1, -1]
    ways, seen, _ = np.linalg.svd(R[:-1, :-1])
    return float(R[-1, -1] ** 2) + float(inside @ inside) - float(np.sum((ways[:, seen > RESOLVED].T @ inside) ** 2))


def common(fits: Sequence[Fit]) -> tuple[Marks, ...]:
    """Readings that carry weight in all of them."""
    return tuple(np.logical_and.reduce(marks) for marks in zip(*(one.used for one in fits), strict=True))


def spread_out(fit: Fit) -> Blocks:
    """Derivatives of every block by all unknowns, shape (n, p) each."""
    found = []
    for block, part in zip(fit.problem.blocks, fit.slopes, strict=True):
        wide = np.zeros((len(part), len(fit.theta)))
        wide[:, np.array(block.uses)] = part
        found.append(wide)
    return tuple(found)
