"""One specimen as evaluated, which the checks look at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metrology.relaxation.blocks import Array
from metrology.relaxation.evidence import Said
from metrology.relaxation.fit import Fitted
from metrology.relaxation.forms import Scene
from metrology.relaxation.levels import Levels
from metrology.relaxation.noise import Colours
from metrology.relaxation.test import Mounting


@dataclass(frozen=True)
class Done:
    """One specimen as evaluated: its record, blocks and levels, the fit of the most probable form, what is said.

    `noise` holds the colours that its noise may have; `whole` is whether the course of its input was taken with all of
    its corners.
    """

    mounting: Mounting
    scene: Scene
    levels: Levels
    best: Fitted
    noise: Colours
    names: tuple[str, ...]
    said: Said
    whole: bool

    @property
    def times(self) -> Array:
        """Times of the branches with the ends of their 95 % intervals / s (low, time, high), in order, shape (m, 3)."""
        from scipy.special import stdtrit

        m = 0 if self.best.form.power else self.best.form.branches
        if not m:
            return np.empty((0, 3))
        # Student's distribution in ln τ.
        wide = float(stdtrit(self.said.dof, 0.975)) * np.sqrt(np.diag(self.best.covariance)[-m:])
        logs = self.best.values[-m:, None] + wide[:, None] * np.array([-1.0, 0.0, 1.0])
        return np.asarray(np.exp(np.clip(logs[np.argsort(logs[:, 1])], -600, 600)))
