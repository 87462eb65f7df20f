"""What a linear viscoelastic specimen answers to an input that is linear between its nodes, as means over blocks."""

from __future__ import annotations

import numpy as np

from metrology.relaxation.blocks import Array, Blocks

SLOW, FAST = 0.2, 0.4
"""Spans of a block over τ up to which the mean over it is by Simpson's rule, and from which on by the equation of the
branch; between them by both, so that it has no step in τ, at which a search would not settle."""


class Answer:
    """Answers to the input of one record; it begins at rest.

    With r(t) the relaxation function the answer is ∫ r(t − s)·u′(s) ds (Boltzmann's superposition; Ferry, Viscoelastic
    Properties of Polymers, 3rd edition, 1980, ch. 1). Between the corners tⱼ of the input u′ is constant, and the
    integral over each piece has a closed form; `gone` is the part of a piece that is over, `since` the time since.

    Parameters
    ----------
    of : Blocks
        Over which means are taken; `of.u` those of the input.
    time, u : ndarray, shape (k,)
        Corners of the input: s since the first reading, and the value there.
    """

    def __init__(self, of: Blocks, time: Array, u: Array) -> None:
        self.of, self.first = of, float(u[0])
        long = np.diff(time)
        moves = np.flatnonzero(np.diff(u))
        begin, self.slopes = time[moves], np.diff(u)[moves] / long[moves]
        points = np.stack([of.time - of.span / 2, of.time, of.time + of.span / 2])
        self.gone = np.clip(points[..., None] - begin, 0.0, long[moves])
        self.since = np.maximum(points[..., None] - begin - long[moves], 0.0)
        self.input = np.asarray(self.gone @ self.slopes)
        self._known: dict[float, Array] = {}

    @staticmethod
    def _simpson(values: Array) -> Array:
        return np.asarray((values[0] + 4 * values[1] + values[2]) / 6)

    def branch(self, tau: float) -> Array:
        """Means of ∫ (1 − exp(−(t − s)/τ))·u′(s) ds, shape (n,).

        h = u − g follows h′ = u′ − h/τ, and ∫ h dt = τ·(Δu − Δh) over a block, whatever its length. A search asks for
        most of them again: they are kept.
        """
        if tau not in self._known:
            self._known[tau] = self._branch(tau)
        return self._known[tau]

    def _branch(self, tau: float) -> Array:
        # Piece by piece: no difference of large numbers, whatever was imposed before.
        followed = -tau * (np.exp(-self.since / tau) * np.expm1(-self.gone / tau)) @ self.slopes
        slow = self._simpson(self.input - followed)
        span = np.where(self.of.span > 0, self.of.span, 1.0)
        lost = tau * ((self.input[2] - self.input[0]) - (followed[2] - followed[0])) / span
        share = np.clip((self.of.span / tau - SLOW) / (FAST - SLOW), 0.0, 1.0)
        return share * (self.of.u - self.first - lost) + (1 - share) * slow

    def power(self, exponent: float, unit: float) -> Array:
        """Means of ∫ ((t − s)/unit)^exponent·u′(s) ds, exponent > −1, shape (n,).

        What differs from the input itself is interpolated; the input is that of the blocks.
        """
        above = (self.since + self.gone) ** (1 + exponent) - self.since ** (1 + exponent)
        grown = above @ self.slopes / (unit**exponent * (1 + exponent))
        if exponent >= 0:
            return self._simpson(grown)
        return np.asarray(self.of.u - self.first + self._simpson(grown - self.input))
