"""Motion of a mass on a sample after its release: exact steps of the linear oscillation, small forces between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.diagnose.subject import Array

FORCES = ("friction.force", "drag.quadratic", "cubic.stiffness", "damping.amplitude")
"""Forces beside the linear ones, all zero where the oscillation is exactly known."""


@dataclass(frozen=True)
class Swing:
    """m·x″ + c·x′ + k·x + k₃·x³ + c₁·|x|·x′ + b·|x′|·x′ + F·sign x′ = 0, many motions at once.

    Each step takes half the linear motion exactly, the impulse of the other forces, and the other half: for a motion
    that nearly repeats itself the impulses are a trapezoidal sum over whole periods, and so far better than their
    order (h²). Dry friction acts with the mean of its sign over the step, and holds the mass where it can.

    Parameters
    ----------
    mass : float
        kg.
    step : float
        Time between two readings, s; readings begin at time zero.
    count : int
        Readings.
    """

    mass: float
    step: float
    count: int

    def follow(self, many: Sequence[Mapping[str, float]]) -> Array:
        """Displacement of every motion, shape (motions, count), from ``k, c, x0, v0`` and the forces of each in SI."""
        wanted = ("k", "c", "x0", "v0", *FORCES)
        k, c, x, v, dry, drag, cubic, rise = np.array([[one.get(name, 0.0) for name in wanted] for one in many]).T
        # A trial far off may run away: its motion is then not finite, which says so.
        with np.errstate(over="ignore", invalid="ignore"):
            if not (dry.any() or drag.any() or cubic.any() or rise.any()):
                return self._linear(k, c, x, v)
            return self._stepped(np.array([k, c, x, v]), np.array([dry, drag, cubic, rise]))

    def _stepped(self, linear: Array, forces: Array) -> Array:
        """One step after the other, from the middle of one to the middle of the next."""
        k, c, x, v = linear
        h, m = self.step, self.mass
        dry, drag, cubic, rise = forces * (h / m)
        stiff, damp, limit = k * (0.5 * h / m), c * (0.5 * h / m), forces[0] / k
        e11, e12, e21, e22 = _propagator(k / m, c / m, h)
        r11, r12, r21, r22 = _propagator(k / m, c / m, h / 2)
        frictional, dragged, hardened, raised = (bool(one.any()) for one in forces)
        places, speeds = np.empty((2, self.count, len(x)))
        places[0], speeds[0] = x, v
        held = np.zeros(len(x), dtype=bool)
        x, v = r11 * x + r12 * v, r21 * x + r22 * v
        for at in range(1, self.count):
            if hardened:
                v = v - cubic * (x * x * x)
            if dragged:
                v = v / (1 + drag * np.abs(v))
            if raised:
                slowed = 0.5 * rise * np.abs(x)
                v = v * (1 - slowed) / (1 + slowed)
            if frictional:
                share = v / (np.abs(stiff * x + damp * v) + 1e-300)
                v = v - dry * np.minimum(np.maximum(share, -1.0), 1.0)
                stuck = np.abs(v) <= dry
                if stuck.any():
                    held |= stuck & (np.abs(x) < limit)
                    v = np.where(held, 0.0, v)
            places[at], speeds[at] = x, v
            moved = e11 * x + e12 * v
            v = e21 * x + e22 * v
            x = np.where(held, x, moved) if frictional else moved
        y = r11 * places + r12 * speeds
        y[0] = places[0]
        if held.any():
            y = np.where((speeds == 0) & held, places, y)
        return np.ascontiguousarray(y.T)

    def _linear(self, k: Array, c: Array, x: Array, v: Array) -> Array:
        """Closed form, x = Re[a·e^{st}] with both roots s of m·s² + c·s + k."""
        half = 0.5 * c / self.mass
        root = np.sqrt((half**2 - k / self.mass).astype(complex))
        root = np.where(np.abs(root) < 1e-9 * (1 + half), 1e-9j * (1 + half), root)
        one, other = -half + root, -half - root
        a = (v - other * x) / (one - other)
        t = self.step * np.arange(self.count)
        moved = a[:, None] * np.exp(one[:, None] * t) + (x - a)[:, None] * np.exp(other[:, None] * t)
        return np.asarray(moved.real, dtype=float)


def _propagator(stiffness: Array, damping: Array, h: float) -> tuple[Array, Array, Array, Array]:
    """Entries of exp(A·h) for x″ + 2γ·x′ + ω²·x = 0, from ω² and 2γ."""
    half = 0.5 * damping
    root = np.sqrt((half**2 - stiffness).astype(complex))
    root = np.where(np.abs(root) < 1e-9 * (1 + half), 1e-9j * (1 + half), root)
    fall = np.exp(-half * h)
    even = (fall * np.cosh(root * h)).real
    odd = (fall * np.sinh(root * h) / root).real
    return even + half * odd, odd, -stiffness * odd, even - half * odd
