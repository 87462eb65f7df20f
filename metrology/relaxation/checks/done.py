"""One specimen as evaluated, which the checks look at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.relaxation.blocks import Array
from metrology.relaxation.evidence import Said
from metrology.relaxation.fit import Fitted
from metrology.relaxation.forms import Scene
from metrology.relaxation.levels import Levels
from metrology.relaxation.noise import Colours
from metrology.relaxation.ramps import Bend
from metrology.relaxation.test import Mounting

FINAL = ("k_inf", "E_inf", "relaxed")
"""Results of the equilibrium."""
LATER = ("k_t", "E_t", "alpha")
"""Results at the time that was asked for."""
AT_ONCE = ("k_0", "E_0")
"""Results at once after a step."""


@dataclass(frozen=True)
class Done:
    """One specimen as evaluated: its record, blocks and levels, the fit of the most probable form, what is said.

    `noise` holds the colours that its noise may have. `branches` is what all forms with as many branches as the most
    probable one say of them: ln τ of each, its part of r₀, and of what faster ones leave of the stiffness. `whole` is
    whether the course of its input was taken with all of its corners, `unread` the time / s within which a step lies
    between two readings, or on a ramp that is left out, `rounding` half a division of what answered as force by
    stretch, `instants` half widths of the numbers by the instant of a step, which nothing read.
    """

    mounting: Mounting
    scene: Scene
    levels: Levels
    best: Fitted
    noise: Colours
    names: tuple[str, ...]
    said: Said
    branches: Said
    whole: bool
    unread: float
    rounding: float
    instants: Mapping[str, float]

    @property
    def times(self) -> Array:
        """Times of the branches with the ends of their 95 % intervals / s (low, time, high), in order, shape (m, 3)."""
        from scipy.special import stdtrit

        m = len(self.branches.values) // 3
        # Student's distribution in ln τ.
        wide = float(stdtrit(self.branches.dof, 0.975)) * self.branches.u[:m]
        logs = self.branches.values[:m, None] + wide[:, None] * np.array([-1.0, 0.0, 1.0])
        return np.asarray(np.exp(np.clip(logs, -600, 600)))


@dataclass(frozen=True)
class Bends:
    """Ramps of the specimens, None where one is not judged; those whose answer is not proportional, and the least p."""

    each: tuple[Bend | None, ...]
    names: frozenset[str]
    p: float


@dataclass(frozen=True)
class Seen:
    """The specimens with their whole records, and as they are evaluated: without a ramp that is not proportional."""

    whole: Sequence[Done]
    done: Sequence[Done]
    bends: Bends
