"""Which of several values is largest, alike on every processor.

Sums in another order differ in their last digits, which would choose between values that are equal by design, such as
the parts of three loads of one class, or residuals of readings on whole divisions. Of those the first is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

DIGITS = 9
"""Significant digits in which values have to differ: results of two processors agree to 1e-9 (docs/limits.md)."""


def level(value: float) -> float:
    """Value to that many digits."""
    return float(f"{value:.{DIGITS - 1}e}")


def largest(values: Sequence[float] | NDArray[Any]) -> int:
    """Place of the largest value, the first of those that are equal to that many digits."""
    return int(np.argmax([level(float(value)) for value in values]))
