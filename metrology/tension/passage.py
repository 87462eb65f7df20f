"""Which readings of a record the line is drawn through."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, nan, sqrt

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.tension.slope import LEAST, MOST, Array, averaged, scatter, slope
from metrology.tension.test import Mounting, Range

SMOOTH = 50
"""A range begins and ends where the mean over a fiftieth of the loading passes its ends, not where its noise does."""
PLACES = 40
"""Forces at which a range that is looked for may begin and end, evenly up to the largest one."""
SHORTEST = 0.2
"""Part of the largest force that such a range spans at least: over a shorter one every curve is straight."""
UNSURE = 0.05
"""Bow, over the range of the readings, that has to be known within twice its uncertainty: yield over which a line is
drawn leaves residuals that look like noise, and says nothing of a bow."""
EXCUSED, LEAST_EXCUSED = 0.5, 5e-3
"""Bow beyond what the classes allow that noise with a memory excuses: half of that, or a part of the range of the
readings. The line of a curve leaves the curve, which is taken for noise with a long memory: u of a bow grows so."""
OF_SCATTER = sqrt(180.0) / 4
"""u of the bow of n readings, evenly over their range, by what each scatters by itself, over that scatter by √n."""
FINE, COARSE = 4 * MOST, 100
"""Means of the whole loading, and of one range of it, by which it is looked for."""


@dataclass(frozen=True)
class Passage:
    """Readings of one mounting that count: a slice of its record, and what the range is in strain and force."""

    rows: slice
    force: tuple[float, float]
    strain: tuple[float, float]


def passage(test: str, one: Mounting, chosen: Range, tolerance: float) -> Passage:
    """Find the readings of a range.

    Raises
    ------
    MetrologyError
        Where the record does not pass the range, or has fewer than `LEAST` readings in it.
    """
    rows = _longest(one, tolerance) if chosen.by == "longest" else _stated(test, one, chosen)
    if rows.stop - rows.start < LEAST:
        got = f"{rows.stop - rows.start} readings of '{one.name}' in the range"
        raise MetrologyError(Fault(f"{test}.range", got, f"at least {LEAST}", "widen the range, or record faster"))
    strain = one.nominal
    part = one.force[rows]
    ends = (nan, nan) if strain is None else (float(strain[rows][0]), float(strain[rows][-1]))
    return Passage(rows, (float(part[0]), float(part[-1])), ends)


def excused(force: Array, reading: Array, tolerance: float) -> float:
    """Bow over the range of the readings that noise excuses at most, beyond `tolerance`.

    What neighbouring readings scatter by is no curve, however large it is; noise with a memory may be one.
    """
    size = max(float(np.ptp(reading)), 1e-300)
    apart = scatter(reading - force * (size / (float(np.ptp(force)) or 1.0))) / size
    by_scatter = min(2 * OF_SCATTER * apart / sqrt(len(reading)), UNSURE)
    return max(EXCUSED * tolerance, LEAST_EXCUSED, by_scatter)


def _stated(test: str, one: Mounting, chosen: Range) -> slice:
    """Readings from where the quantity last was below the lower end to where it first reaches the upper one."""
    by = one.nominal if chosen.by == "strain" else one.force
    assert by is not None
    low, high = chosen.low, chosen.high
    if chosen.by == "share":
        low, high = (end * float(one.force.max()) for end in (low, high))
    smooth = _smooth(by, int(np.argmax(one.force)) + 1)
    found, start = slice(0, 0), 0
    for number in range(1, chosen.passage + 1):
        above = np.flatnonzero(smooth[start:] >= high)
        if not len(above):
            unit = "N" if chosen.by != "strain" else "of strain"
            got = f"'{one.name}' with {number - 1} loadings up to {high:.4g} {unit}"
            expected = f"loading {chosen.passage} through the range {low:.4g} to {high:.4g}"
            mend = "lower the upper end, or leave the specimen out by 'exclusions' with a reason"
            raise MetrologyError(Fault(f"{test}.range", got, expected, mend))
        stop = start + int(above[0])
        below = np.flatnonzero(smooth[start:stop] < low)
        found = slice(start + int(below[-1]) + 1 if len(below) else start, stop + 1)
        again = np.flatnonzero(smooth[stop:] < low)
        start = stop + int(again[0]) if len(again) else len(smooth)
    return found


def _smooth(by: Array, rising: int) -> Array:
    """Running mean over a fiftieth of the loading; gaps hold the value before."""
    held = np.where(np.isfinite(by), by, np.interp(np.arange(len(by)), np.flatnonzero(np.isfinite(by)),
                                                   by[np.isfinite(by)]))  # fmt: skip
    width = 2 * (rising // (2 * SMOOTH)) + 1
    padded = np.concatenate([np.full(width // 2, held[0]), held, np.full(width // 2, held[-1])])
    sums = np.concatenate([[0.0], np.cumsum(padded - held[0])])
    return np.asarray(held[0] + (sums[width:] - sums[:-width]) / width)


def _longest(one: Mounting, tolerance: float) -> slice:
    """The longest range of force over which the readings are straight within noise and tolerance.

    A range is straight where the bow of a parabola through it is within `tolerance` of the range of the readings and
    what noise excuses (twice its uncertainty, `excused` at most), and known within `UNSURE` of it, and where neither
    half bows by more than `tolerance` of its own range beyond its noise: a toe below and yield above make an S, which
    no parabola sees. The widest one is taken, of several the first; the straightest where none is straight.
    """
    y = one.nominal if one.nominal is not None else one.crosshead
    assert y is not None
    rising = int(np.argmax(one.force)) + 1
    each = -(-rising // FINE)
    force, reading = averaged(one.force[:rising], y[:rising], most=FINE)
    highest = np.maximum.accumulate(_smooth(force, len(force)))
    ends = np.searchsorted(highest, np.linspace(highest[0], highest[-1], PLACES + 1)).clip(0, len(force) - 1)
    best, found = inf, slice(0, 0)
    for width in range(PLACES, int(SHORTEST * PLACES) - 1, -1):
        for first, last in zip(ends[: PLACES + 1 - width], ends[width:], strict=True):
            part = slice(int(first), int(last) + 1)
            if part.stop - part.start < LEAST or not np.isfinite(reading[part]).all():
                continue
            excess = _excess(force[part], reading[part], tolerance)
            if excess <= 0:
                halves = (_excess(force[half], reading[half], tolerance, inf) for half in _halves(force, part))
                excess = max([excess, *halves])
            if excess < best:
                best, found = excess, slice(part.start * each, part.stop * each)
            if excess <= 0:
                return found
    return found


def _excess(force: Array, reading: Array, tolerance: float, unsure: float = UNSURE) -> float:
    """What a bow is beyond `tolerance` and what noise excuses, or less known than `unsure`, over the range.

    Infinite where the force stays the same: no line is drawn through that.
    """
    means = averaged(force, reading, most=COARSE)
    if np.ptp(means[0]) == 0:
        return inf
    line = slope(*means)
    size = max(float(np.ptp(reading)), 1e-300)
    bow, known = abs(line.bow) / size, 2 * line.bow_u / size
    return max(bow - min(known, excused(force, reading, tolerance)), known - unsure) - tolerance


def _halves(force: Array, part: slice) -> Iterator[slice]:
    """Lower and upper half of the force of a range, where it has readings enough."""
    middle = (force[part.start] + force[part.stop - 1]) / 2
    at = part.start + int(np.searchsorted(np.maximum.accumulate(force[part]), middle))
    yield from (half for half in (slice(part.start, at + 1), slice(at, part.stop)) if half.stop - half.start >= LEAST)
