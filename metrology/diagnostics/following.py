"""Runs as a fitted model follows them: what is measured beside what is simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.diagnostics.subject import Array, Fit, Marks
from metrology.estimation import Layout, MeasuredRun
from metrology.estimation.response import motion, values_of
from metrology.rig import Motion, Rig


@dataclass(frozen=True)
class Followed:
    """One run as one model follows it: the rig with the values of the run, the motion, and the readings used."""

    run: MeasuredRun
    rig: Rig
    motion: Motion
    used: Mapping[str, Marks]

    def residual(self, channel: str) -> Array:
        """Measured less simulated, in the unit of the channel; NaN where a reading is not used."""
        found: Array = self.run.readings(channel) - np.asarray(getattr(self.motion, channel))
        return np.where(self.used[channel], found, np.nan)


def followed(rig: Rig, layout: Layout, runs: Sequence[MeasuredRun], fit: Fit) -> tuple[Followed, ...]:
    """Every run as a fitted model follows it; none where one cannot be followed."""
    found = []
    for at, (run, block, used) in enumerate(zip(runs, fit.problem.blocks, fit.used, strict=True)):
        values = values_of(layout, at, fit.theta)
        moved = motion(rig, run.run, values)
        if moved is None:
            return ()
        marks = {one.name: used[one.first : one.last] for one in block.segments}
        found.append(Followed(run, rig.with_values(values), moved, marks))
    return tuple(found)
