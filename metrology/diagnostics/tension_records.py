"""Records of a tension test as diagnosis sees them: means over the range of the line, or over all of their cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.typing import NDArray

from metrology.diagnostics.subject import Array
from metrology.effect import Pulled
from metrology.noise import FEW
from metrology.tension.lines import Lines, end
from metrology.tension.slope import averaged, slope
from metrology.tension.test import TensionTest

MOST = 600
"""Means of each record and channel. What the full list takes out of the noise makes tests of nothing 'unexplained':
with 300 means 7 of 102, with 600 none of 102."""
EACH = 35
"""Means to a place at which a step is tried: shapes that outnumber the readings leave no noise to judge by."""
MOST_STEPS = 4
FINER = 64
"""Places within each of these, of which the one is tried where the residuals look most like a step: two or three means
apart. With a quarter as many two slips are named with a lost section in cycles: they make up for its place."""
CURVE, LONGEST = 5, 0.95
"""Degree of the curve about which few readings scatter; longest memory of its residuals."""
Course = tuple[slice, NDArray[np.bool_] | None]
"""Readings from the first to the last, and which of them are within the range of the line; None where all are."""
AGAIN = 0.5
"""Readings within the range in other loadings and unloadings, over those of the line, from which on they count."""


@dataclass(frozen=True)
class Record:
    """One mounting, or a part of the only one, in displacements over the free length."""

    name: str
    seen: Pulled
    y: Array
    u: Array
    scale: float
    count: int

    def polynomial(self, degree: int) -> Array:
        """Coefficients over the force, the highest power first, by the extensometer where there is one."""
        rows = self.seen.crosshead == self.seen.crosshead.min()
        return np.polyfit(self.seen.force[rows], self.y[rows], degree)


@dataclass(frozen=True)
class Read:
    """What counts of all mountings alike.

    `crosshead`, `strain`: whether that reading does. `known`: compliance that is taken from the crosshead / (m/N).
    `area`: mean section / m², 0 where it is not known. `most`, `middle`: largest force and middle of all / N. `many`:
    records, of which there are `halves` of each mounting.
    """

    crosshead: bool
    strain: bool
    known: float
    area: float
    most: float
    middle: float
    many: int
    halves: int


def length(one: Lines) -> float:
    """Free length, over which strains become displacements; 1 where it is not known."""
    return one.mounting.length.value if one.mounting.length is not None else 1.0


def record(at: int, one: Lines, part: Course, read: Read) -> Record:
    """Means of the readings of one mounting, first of the crosshead, then of the strain.

    Parameters
    ----------
    at : int
        Number of the record.
    one : Lines
        Mounting and its lines.
    part : Course
        Its readings.
    read : Read
        What counts of all mountings.
    """
    mounting, free, (rows, inside) = one.mounting, length(one), part
    time = mounting.time if mounting.time is not None else np.arange(len(mounting.force), dtype=float)
    channels: list[tuple[Array, float]] = []
    if read.crosshead and mounting.crosshead is not None:
        channels.append((mounting.crosshead - read.known * mounting.force, 1.0))
    if read.strain and mounting.strain is not None:
        channels.append((free * mounting.strain, 0.0))
    whole = np.ones(len(mounting.force), dtype=bool) if inside is None else inside
    most = -(-MOST * (rows.stop - rows.start) // max(int(whole[rows].sum()), 1))
    force, t, kept = averaged(mounting.force[rows], time[rows], whole[rows].astype(float), most=most)
    used = kept == 1.0
    force, t = force[used], t[used]
    main = one.passage.rows
    thinned = [(averaged(y[rows], most=most)[0][used], kind, slope(mounting.force[main], y[main]))
               for y, kind in channels]  # fmt: skip
    each = max(-(-(rows.stop - rows.start) // most), 1)
    u = [np.full(len(force), max(line.level / each**0.5, 1e-6 * abs(line.value) * read.most)) for _, _, line in thinned]
    many = len(thinned)
    before, at_time = averaged(mounting.force[: rows.stop], time[: rows.stop], most=2 * MOST)
    pulled = Pulled(
        np.tile(force, many), np.tile(t, many), np.repeat([kind for _, kind, _ in thinned], len(force)),
        at, read.many, read.most, read.middle, steps=FINER * min(max(len(force) // EACH, 2), MOST_STEPS),
        halves=read.halves, history=(before, at_time),
    )  # fmt: skip
    scale = free * (read.area / mounting.area_value if read.area else 1.0)
    name = mounting.name if read.halves == 1 else f"{mounting.name} part {at + 1}"
    return Record(name, pulled, np.concatenate([y for y, _, _ in thinned]), np.concatenate(u), scale, len(force))


def few(records: Sequence[Record]) -> bool:
    """Whether the readings of a channel are so few that no colour of their noise is estimated."""
    return sum(one.count for one in records) < FEW


def steady(one: Record) -> Record:
    """Record whose u is that of its noise at the lowest frequencies, where effects live.

    For few readings noise is taken as white. With a memory φ it has √((1 + φ)/(1 − φ)) times its scatter there: φ and
    scatter are those of the residuals of a curve of the force.
    """
    u = one.u.copy()
    for kind in np.unique(one.seen.crosshead):
        rows = one.seen.crosshead == kind
        force, y = one.seen.force[rows], one.y[rows]
        line = np.polynomial.Polynomial.fit(force, y, min(CURVE, len(y) // 4))
        left = y - line(force)
        free = max(len(left) - line.degree() - 1, 1)
        scatter = float(np.sqrt(left @ left / free))
        memory = float(left[1:] @ left[:-1]) / max(float(left @ left), 1e-300)
        # A fitted curve takes from the memory about what it takes from the readings.
        memory = float(np.clip(memory + (1 + 3 * memory) * line.degree() / (2 * len(left)), 0.0, LONGEST))
        u[rows] = np.maximum(scatter * np.sqrt((1 + memory) / (1 - memory)), 1e-3 * u[rows])
    return replace(one, u=u)


def rate(one: Record) -> float:
    """Logarithm of the rate of force / (N/s)."""
    rows = one.seen.crosshead == one.seen.crosshead[0]
    force, time = one.seen.force[rows], one.seen.time[rows]
    return log(float(np.abs(np.diff(force)).sum()) / float(np.ptp(time)))


def course(one: Lines, test: TensionTest) -> Course:
    """Where a record goes up and down: all of it within the range, up to the break; else the range of the line.

    Of a stated later loading, that loading alone: what was before it has been left out on purpose.
    """
    rows, force = one.passage.rows, one.mounting.force
    if test.range.passage > 1:
        return rows, None
    last = end(one.mounting, test.fall)
    stop = last.held if last.reached else len(force)
    low, high = one.passage.force
    inside = (force >= low) & (force <= high)
    inside[stop:] = False
    for strain in one.mounting.strains:
        inside &= np.isfinite(strain)
    others = np.count_nonzero(inside) - np.count_nonzero(inside[rows])
    if others < AGAIN * (rows.stop - rows.start):
        return rows, None
    places = np.flatnonzero(inside)
    return slice(int(places[0]), int(places[-1]) + 1), inside


def parts(rows: slice, *, alone: bool) -> list[slice]:
    """The readings of a record; of a single one in halves, so that one predicts the other."""
    middle = (rows.start + rows.stop) // 2
    return [slice(rows.start, middle), slice(middle, rows.stop)] if alone else [rows]
