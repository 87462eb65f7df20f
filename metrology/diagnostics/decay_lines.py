"""Lines beside a free decay: where one may lie, which the decay makes itself, and the strongest of some residuals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from metrology.decay.modes import MAINS_WIDTH
from metrology.diagnostics.release import HARMONICS, Record
from metrology.diagnostics.subject import Array

BESIDE = 0.05
"""Part of the decay's frequency about each of its multiples within which a line is one that the decay itself makes."""
OUTLASTS = 1 / 3
"""Part of the decay's rate below which a line outlasts it: where e⁻³ of the decay is left, there is e⁻¹ of the line."""
HIGHEST = 0.9
"""Part of half the sampling rate up to which a line is sought: beyond it, one is as well an alias of another."""
BoolArray = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


@dataclass(frozen=True, eq=False)
class Bands:
    """Frequencies at which a line beside a decay is sought, and those at which it is the decay's own.

    `omega`, `fall`: angular frequency and rate / (1/s) of the decay; `seen`: its frequencies / Hz along the records.
    `longest`: length / s of the longest release; `mains`: frequency / Hz of the mains.
    """

    omega: float
    fall: float
    seen: Array
    longest: float
    mains: float

    def is_own(self, frequency: Array, rate: float, margin: float = 0.0) -> BoolArray:
        """Whether a line at a frequency / Hz is the decay's own: where it moves with the amplitude, or too near to it.

        A second line there would bend the first at will, and explain all that shapes the decay. One that is still
        there when the decay is gone shapes nothing of it, and one that dies sooner is as wide as it dies soon.
        """
        own, fall = self.omega / (2 * math.pi), self.fall
        seen = np.clip([own, *self.seen], 0.8 * own, 1.2 * own)
        aside = max(3 / self.longest, 0.9 * (max(fall, rate) if rate > OUTLASTS * fall else rate)) + margin
        return np.asarray((frequency > seen.min() - aside) & (frequency < seen.max() + aside))

    def makes(self, frequency: Array) -> BoolArray:
        """Whether a line is one that the decay itself makes: within `BESIDE` of a multiple, or not resolved from it.

        A bent restoring force makes such lines, and so does a sensor that is not linear: a swing that is read by its
        horizontal position has the third multiple of its frequency, whatever the force is.
        """
        order = np.round(frequency * 2 * math.pi / self.omega)
        apart = np.abs(frequency - order * self.omega / (2 * math.pi))
        near = apart < BESIDE * self.omega / (2 * math.pi)
        unresolved = (order > 1) & (order <= HARMONICS) & (apart < 1 / self.longest)
        return np.asarray((order > 0) & (near | unresolved))

    def apart_at_mains(self, step: float) -> int:
        """Frequencies about all multiples of the mains that the longest record, of a time step / s, tells apart.

        What an effect costs that picks one of them hangs on it (`sets.price`).
        """
        multiples = int(HIGHEST * 0.5 / step / self.mains)
        return max(multiples, 1) * math.ceil(2 * self.about_mains() * self.longest)

    def about_mains(self) -> float:
        """Half width / Hz of the band about a multiple of the mains in which a line is taken as theirs."""
        return max(MAINS_WIDTH, 1.5 / self.longest)

    def strongest(
        self, records: Sequence[Record], residuals: Sequence[Array], step: float, rate: float, *, hum: bool
    ) -> list[float]:
        """Frequency / Hz of the strongest line of all residuals that decays at a rate, at the mains or elsewhere.

        `step`: of time / s, by which the frequencies are even.
        """
        longest = self.longest
        size = 4 * 2 ** math.ceil(math.log2(longest / step + 1))
        grid, power = np.fft.rfftfreq(size, step), np.zeros(size // 2 + 1)
        for one, residual in zip(records, residuals, strict=True):
            weight = np.exp(-rate * one.t) if rate * one.t[-1] > 1 else np.hanning(len(one.t))
            found = np.abs(np.fft.rfft(one.even(weight * residual), size)) ** 2 / float(weight @ weight)
            power += np.interp(grid, np.fft.rfftfreq(size, one.step), found)
        mains, width = self.mains, max(1 / longest, 0.3 * rate)
        beside = np.abs(grid / mains - np.maximum(np.round(grid / mains), 1)) * mains < self.about_mains()
        every = np.asarray(grid, dtype=float)
        allowed = beside if hum else ~beside & ~self.is_own(every, rate, width) & ~self.makes(every)
        allowed &= (grid > 2 * width) & (grid < HIGHEST * grid[-1])
        return [float(grid[np.flatnonzero(allowed)[np.argmax(power[allowed])]])] if allowed.any() else []
