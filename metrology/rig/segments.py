"""Linear segments of the rig's motion with NumPy alone: many instants at once in place of a compiled loop."""

from __future__ import annotations

from typing import Any

import numpy as np

from metrology.rig import kernel
from metrology.rig.model import Array


def linear_leg(
    A: Array, W: Array, G: Array, rows: Array, n: int, reached: float, omega: float, Y: Array, t: float, stop: float,
    last: bool, grids: Any, spans: Any, shifts: Array, firsts: Array, outs: Any, budget: int,
) -> tuple[float, int, int]:  # fmt: skip
    """Follow a linear regime from `t` to its first event, or to `stop`: `kernel.linear_leg`, vectorised."""
    raise NotImplementedError
