"""What a linear viscoelastic specimen answers to an input that is linear between its nodes, as means over blocks."""

from __future__ import annotations

import numpy as np

from metrology.relaxation.blocks import Array, Blocks


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
        self.of, self.first, self.course = of, float(u[0]), (time, u)
        long = np.diff(time)
        moves = np.flatnonzero(np.diff(u))
        begin, self.slopes = time[moves], np.diff(u)[moves] / long[moves]
        points = np.stack([of.begin, (of.begin + of.end) / 2, of.end])
        self.gone = np.clip(points[..., None] - begin, 0.0, long[moves])
        self.since = np.maximum(points[..., None] - begin - long[moves], 0.0)
        self.input = np.asarray(self.gone @ self.slopes)
        # By how much the mean of the stamps is off the middle, over the length.
        self.off = (of.time - points[1]) / np.where(of.half > 0, 2 * of.half, 1.0)
        self._known: dict[float, Array] = {}

    def _mean(self, values: Array) -> Array:
        """Mean over the readings of each block by its first, middle and last: exact of a parabola at even stamps."""
        count = np.maximum(self.of.count, 2)
        uneven = self.off * (values[2] - values[0])
        return np.asarray(
            uneven + values[1] + (values[0] - 2 * values[1] + values[2]) * (count + 1) / (6 * (count - 1))
        )

    def branch(self, tau: float) -> Array:
        """Means of ∫ (1 − exp(−(t − s)/τ))·u′(s) ds, shape (n,).

        h = u − g follows h′ = u′ − h/τ; over a block u′ is constant, and the mean over even stamps is a geometric sum.
        A search asks for most of them again: they are kept.
        """
        if tau not in self._known:
            self._known[tau] = self._branch(tau)
        return self._known[tau]

    def _branch(self, tau: float) -> Array:
        # Piece by piece: no difference of large numbers, whatever was imposed before.
        since, gone = self.since[0] / tau, self.gone[0] / tau
        first = -tau * (np.exp(-since) * np.expm1(-gone)) @ self.slopes
        step = self.of.step / tau
        part = np.expm1(-self.of.count * step) / (self.of.count * np.expm1(-step))
        long = self.of.end - self.of.begin
        slope = (self.input[2] - self.input[0]) / np.where(long > 0, long, 1.0)
        rest = first - slope * tau
        uneven = self.off * rest * np.expm1(-long / tau)
        return np.asarray(self.of.u - self.first - first * part - slope * tau * (1 - part) - uneven)

    def power(self, exponent: float, unit: float) -> Array:
        """Means of ∫ ((t − s)/unit)^exponent·u′(s) ds, exponent > −1, shape (n,).

        What differs from the input itself is interpolated; the input is that of the blocks.
        """
        above = (self.since + self.gone) ** (1 + exponent) - self.since ** (1 + exponent)
        grown = above @ self.slopes / (unit**exponent * (1 + exponent))
        if exponent >= 0:
            return self._mean(grown)
        return np.asarray(self.of.u - self.first + self._mean(grown - self.input))
