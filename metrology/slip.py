"""Slips by which a stiffness comes out far off another of the same sample: named by the ratio of the two."""

from __future__ import annotations

from math import log, sqrt

OFF = 2.83
"""Ratio of two stiffnesses of one sample beyond which a slip is certain: midway between two, by which moduli of one
class of material and of one sample at other rates differ, and the four that a sampling rate off by two makes."""
DYNAMIC = (
    (4.0, "a sampling rate off by two"),
    (1e3, "g for kg, or a length in mm read as m"),
    (1e6, "ms for s"),
)
"""Ratio of stiffnesses, or its inverse, that a slip makes where one of them follows from a frequency."""
STATIC = (
    (2.0, "half of a section or of a length"),
    (4.0, "a diameter for a radius"),
    (9.81, "a mass for its weight (kgf for N)"),
    (1e3, "g for kg, or a length in mm read as m"),
    (1e6, "two units off by 1000"),
)
"""The same where both follow from forces and lengths."""
NEAR = sqrt(2.0)
"""Ratio within which the two still point at one slip, midway between two slips: two tests of one sample may differ."""


def likely(ratio: float, *, dynamic: bool = True) -> str:
    """What a ratio of two stiffnesses points at, the ratio of natural frequencies squared.

    `dynamic`: whether one of them follows from a frequency.

    Examples
    --------
    >>> likely(1.02e-6), likely(3.99, dynamic=False)
    ('ms for s', 'a diameter for a radius')
    >>> likely(0.04)
    'units of time, mass and length; a record thinned without a filter (aliasing)'
    """
    size = abs(log(ratio))
    for factor, words in DYNAMIC if dynamic else STATIC:
        if abs(size - log(factor)) < log(NEAR):
            return words
    return OTHERS[dynamic]


OTHERS = {
    True: "units of time, mass and length; a record thinned without a filter (aliasing)",
    False: "units of force and length; the section; what the reading spans",
}
"""Where no slip is near."""
