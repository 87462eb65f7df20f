"""The clock that stamps a record, as a number that a test takes as exact where nothing is stated of it."""

from __future__ import annotations

from collections.abc import Mapping

from metrology.message import said
from metrology.method.model import HeldParameter

REACH = 1e-3
"""A camera of 29.97 frames a second whose stamps are made for 30 (NTSC: 30/1.001) is off by as much."""
RATE = said("relative error of the rate of the clock")


def held(test: str, slopes: Mapping[str, float], advice: str = "") -> HeldParameter:
    """The rate of a clock of which no uncertainty is stated.

    Parameters
    ----------
    test : str
        Name of the test.
    slopes : mapping of str to float
        By result: its derivative by what a second of the clock lasts beyond a second, relative.
    advice : str
        Where the uncertainty is stated, a sentence; nothing where that is with the inputs of the rig.

    Returns
    -------
    HeldParameter
        With a reach of `REACH`.
    """
    return HeldParameter(test, "clock rate", RATE, "1", 0.0, REACH, slopes, advice)
