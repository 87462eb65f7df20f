"""Slips by which a stiffness comes out far off another of the same sample: named by the ratio of the two."""

from __future__ import annotations

from math import log

OFF = 2.83
"""Ratio of two stiffnesses of one sample beyond which a slip is certain: midway between two, by which moduli of one
class of material and of one sample at other rates differ, and the four that a sampling rate off by two makes."""
SLIPS = (
    (4.0, "a sampling rate off by two"),
    (1e3, "g for kg, or a length in mm read as m"),
    (1e6, "ms for s"),
)
"""Ratio of stiffnesses that a slip makes, or its inverse."""
NEAR = 1.5
"""Ratio within which the two still point at one slip: what two tests of one sample may differ by honestly."""


def likely(ratio: float) -> str:
    """What a ratio of two stiffnesses points at, the ratio of natural frequencies squared.

    Examples
    --------
    >>> likely(1.02e-6)
    'ms for s'
    >>> likely(0.04)
    'units of time, mass and length; a record thinned without a filter (aliasing)'
    """
    for factor, words in SLIPS:
        if abs(abs(log(ratio)) - log(factor)) < log(NEAR):
            return words
    return "units of time, mass and length; a record thinned without a filter (aliasing)"
