"""A probability as it is printed: two digits, and none that is not known."""

from __future__ import annotations

from math import ceil, floor, isfinite, log10

import numpy as np

from metrology.units import raised

FEW = 1e-4
"""Probability below which one digit is given: of a million draws, a hundred and fewer."""
SMALLEST = 1e-6
"""Probability below which no more is stated than that it is smaller: no tail of a measurement is known further out."""


def probability(p: float, resolution: float = 0.0) -> str:
    """A probability as it is printed: two digits, and none that is not known.

    Parameters
    ----------
    p : float
        From 0 to 1.
    resolution : float
        Smallest probability that can be distinguished from 0, such as 3/M by M draws.

    Returns
    -------
    str
        Such as ``0.023`` or ``< 10⁻⁶``.

    Examples
    --------
    >>> probability(0.0228), probability(2.7e-15), probability(0.0, 1e-5), probability(1 - 1e-9)
    ('0.023', '< 10⁻⁶', '< 10⁻⁵', '> 1 − 10⁻⁶')
    >>> probability(7.2e-6), probability(0.0, 3 / 200_000)
    ('7×10⁻⁶', '< 2×10⁻⁵')
    """
    least = max(SMALLEST, resolution if isfinite(resolution) else SMALLEST)
    if least <= p < FEW:
        digit, _, exponent = f"{p:.0e}".partition("e")
        return f"{digit}×10{raised(str(int(exponent)))}"
    if least <= p <= 1 - least or p == 1.0:
        return f"{p:.2g}" if p <= 0.99 or p == 1.0 else f"{p:.{int(np.ceil(-np.log10(1 - p))) + 1}f}".rstrip("0")
    bound = _bound(least)
    return f"< {bound}" if p < least else f"> 1 − {bound}"


def _bound(least: float) -> str:
    """A bound to one digit, which is not less than it is: ``3×10⁻⁵``, ``10⁻⁶``."""
    power = floor(log10(least) + 1e-9)
    digit = ceil(least / 10.0**power - 1e-9)
    digit, power = (1, power + 1) if digit == 10 else (digit, power)
    times = "" if digit == 1 else f"{digit}×"
    return f"{times}10{raised(str(power))}"
