"""Frequencies of the releases against each other and against √(k/m), before anything is evaluated by them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import pi, sqrt

import numpy as np

from metrology.decay.start import Unusable
from metrology.decay.test import DecayTest
from metrology.errors import Fault
from metrology.slip import OFF, likely


def faults(test: DecayTest, known: Mapping[str, float]) -> Iterator[Fault]:
    """Releases whose frequency is off by more than a factor of two from what is known of it.

    Parameters
    ----------
    test : DecayTest
        With its releases and what was separated in them.
    known : mapping of str to float
        Stiffness of the sample in N/m by where it is known from, without this test; the first is held against.

    Yields
    ------
    Fault
        One for each release that is off, with the likely slip.
    """
    found = {
        record.name: one.fit.main.frequency
        for record, one in zip(test.records, test.separated, strict=True)
        if not isinstance(one, Unusable)
    }
    if not found:
        return
    due, by = float(np.median(list(found.values()))), "as in the other releases"
    if known:
        source, k = next(iter(known.items()))
        due, by = sqrt(k / test.mass.value) / (2 * pi), f"√(k/m)/2π with k = {k:.4g} N/m by {source}"
    for name, frequency in found.items():
        ratio = (frequency / due) ** 2
        if max(ratio, 1 / ratio) > OFF:
            got = f"an oscillation at {frequency:.4g} Hz"
            yield Fault(name, got, f"about {due:.4g} Hz, {by}", f"look for {likely(ratio)}")
