"""The lines through the records of a test, one specimen after the other, and what they reach at their end."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import isfinite, log, nan, sqrt

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.tension.passage import Passage, passage
from metrology.tension.secant import Local, secant, tangent
from metrology.tension.slope import Slope, scatter, slope
from metrology.tension.test import Array, Mounting, TensionTest

BREAK = 0.5
"""Part of the largest force below which a specimen no longer bears: half, as break detectors are usually set."""


@dataclass(frozen=True)
class Lines:
    """One specimen: readings of the range, lines of strain and crosshead over force, and their difference.

    `setup` is the line of what the crosshead moves beyond the stretch of the specimen; `secant` is the slope between
    two stated points, `tangent` that at one. None where one is not known.
    """

    mounting: Mounting
    passage: Passage
    strain: Slope | None
    crosshead: Slope | None
    setup: Slope | None
    secant: Local | None = None
    tangent: Local | None = None

    @property
    def main(self) -> Slope:
        """The line that tells the stiffness."""
        found = self.strain or self.crosshead
        assert found is not None
        return found


def lines(test: TensionTest) -> tuple[Lines, ...]:
    """Draw all lines of a test.

    Raises
    ------
    MetrologyError
        Where a record does not pass the range, or an instrument stood still in it.
    """
    return tuple(_drawn(test, one) for one in test.mountings)


def _drawn(test: TensionTest, one: Mounting) -> Lines:
    found = passage(test.name, one, test.range, test.tolerance)
    force, strain = one.force[found.rows], one.strain
    crosshead = None if one.crosshead is None else one.crosshead[found.rows]
    stretched = None if strain is None else strain[found.rows]
    rest = None
    if crosshead is not None and stretched is not None and one.length is not None:
        rest = slope(force, crosshead - one.length.value * stretched)
    by_strain, by_crosshead = (None if reading is None else slope(force, reading) for reading in (stretched, crosshead))
    for key, line in (("extensometer", by_strain), ("crosshead", by_crosshead)):
        if line is not None and line.value == 0:
            got = f"readings of the {key} of '{one.name}' that stay the same in the range"
            fix = "leave the column out, or the specimen by 'exclusions' with a reason, or choose another range"
            raise MetrologyError(Fault(f"{test.name}.range", got, "readings that rise", fix))
    return Lines(one, found, by_strain, by_crosshead, rest, *_local(test, one, found))


def _local(test: TensionTest, one: Mounting, line: Passage) -> tuple[Local | None, Local | None]:
    """Secant and tangent, where they are asked for, by the reading that tells the stiffness."""
    reading = one.strain if one.strains else one.crosshead
    assert reading is not None
    chosen = None if test.secant is None else secant(test.name, one, test.secant, reading)
    return chosen, None if test.tangent is None else tangent(test.name, one, test.tangent, reading, line)


def rounding(one: Slope, span: float, division: float) -> float:
    """Standard uncertainty of a slope by the rounding of a reading that hardly scatters, in the unit of the slope.

    A ramp over K divisions leaves a saw-tooth of K teeth: whatever its phase, it tilts the line by K⁻² of its rise.
    """
    if not division > 0:
        return 0.0
    steps = max(abs(one.value) * span / division, 1.0)
    return abs(one.value) / steps**2 / sqrt(3)


@dataclass(frozen=True)
class End:
    """What a record reaches.

    Parameters
    ----------
    most, most_u : float
        Largest force / N, and what a reading of the force scatters by.
    reached : bool
        Whether it is the strength.
    broken : bool
        Whether the specimen broke.
    strain, strain_u : float
        Strain at break as it was read, and what a reading of it scatters by; NaN where none tells it.
    force : float
        Force / N of that reading.
    held : int
        Readings before the force falls for good: those of the specimen while it bears.
    """

    most: float
    most_u: float
    reached: bool
    broken: bool
    strain: float
    strain_u: float
    force: float = nan
    held: int = 0


def end(one: Mounting, fall: float) -> End:
    """What a record reaches: its strength, where the force falls by `fall` for good as the grips go on, and its break.

    What the force scatters is no fall: n normal readings lie within √(2·ln n) standard deviations of their mean, the
    largest above it and others below. The break is the last reading before the force falls below half of its largest
    value; a record in which it does not has none. A force that rises again has fallen by unloading.
    """
    force = one.force
    most, peak = float(force.max()), int(np.argmax(force))
    u = scatter(force[: peak + 1])
    held = 1 + int(np.flatnonzero(force >= (1 - fall) * most - 2 * sqrt(2 * log(len(force))) * u)[-1])
    reached = held < len(force) and _goes_on(one, held)
    broken = held + np.flatnonzero(force[held:] < BREAK * most)
    strain = one.nominal
    if strain is None or not reached or not len(broken):
        return End(most, u, reached, reached and bool(len(broken)), nan, nan, held=held)
    last = int(broken[0]) - 1
    known = strain[: last + 1][np.isfinite(strain[: last + 1])]
    return End(most, u, reached, True, float(strain[last]), scatter(known), float(force[last]), held)


def _goes_on(one: Mounting, held: int) -> bool:
    """Whether the grips go on, or stand, while the force falls after so many readings: else it falls by unloading.

    They do where they pass all that they came to before, or where, of a force that fell by half, they came back by less
    than half of what so much force had stretched the set-up and the specimen at least.
    """
    moved = one.crosshead if one.crosshead is not None else one.nominal
    if moved is None:
        return False
    before, after = moved[:held], moved[held:]
    if not np.isfinite(after).any():
        return True
    if float(np.nanmax(after)) >= float(np.nanmax(before)):
        return True
    low = np.flatnonzero((one.force[held:] < BREAK * one.force.max()) & np.isfinite(after))
    if not len(low) or one.crosshead is None:
        return False
    first, here = int(low[0]), float(before[np.isfinite(before)][-1])
    stretch = _least_compliance(one.force, moved) * (float(one.force[held - 1]) - float(one.force[held + first]))
    return here - float(after[first]) < BREAK * stretch


def _least_compliance(force: Array, moved: Array) -> float:
    """Least movement by force / (m/N) over a quarter of the largest force, where the force first came to it."""
    most = float(force.max())
    at = [int(np.argmax(force >= part * most)) for part in (0.25, 0.5, 0.75, 1.0)]
    found = [(moved[b] - moved[a]) / (force[b] - force[a]) for a, b in pairwise(at) if force[b] > force[a]]
    return max(min((float(one) for one in found if isfinite(one)), default=0.0), 0.0)
