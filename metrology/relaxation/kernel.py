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
    Properties of Polymers, 3rd edition, 1980, ch. 1). Between nodes the input is linear, and the integral has a closed
    form: Σ Δu′ⱼ·ρ(t − tⱼ), ρ the answer to a ramp of unit slope and Δu′ⱼ what the slope changes by at node j.
    """

    def __init__(self, of: Blocks) -> None:
        self.of = of
        slopes = np.diff(of.u) / np.diff(of.time)
        self.bends = np.diff(slopes, prepend=0.0)
        nodes = of.time[:-1]
        points = np.stack([of.time - of.span / 2, of.time, of.time + of.span / 2])
        self.since = np.maximum(points[..., None] - nodes, 0.0)
        self.input = np.asarray(self.since @ self.bends)
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
        followed = -tau * np.expm1(-self.since / tau) @ self.bends
        slow = self._simpson(self.input - followed)
        span = np.where(self.of.span > 0, self.of.span, 1.0)
        lost = tau * ((self.input[2] - self.input[0]) - (followed[2] - followed[0])) / span
        share = np.clip((self.of.span / tau - SLOW) / (FAST - SLOW), 0.0, 1.0)
        return share * (self.of.u - self.of.u[0] - lost) + (1 - share) * slow

    def power(self, exponent: float, unit: float) -> Array:
        """Means of ∫ ((t − s)/unit)^exponent·u′(s) ds, exponent > −1, shape (n,).

        What differs from the input itself is interpolated; the input is that of the blocks.
        """
        grown = self.since ** (1 + exponent) @ self.bends / (unit**exponent * (1 + exponent))
        if exponent >= 0:
            return self._simpson(grown)
        return np.asarray(self.of.u - self.of.u[0] + self._simpson(grown - self.input))
