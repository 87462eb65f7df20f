"""What a record has to show of a cause by itself before it may be named: a step its jump, a shape where it lies.

In the evidence alone, a step with more slope after it is one more degree of freedom of a curve, and so is a knee that
may lie anywhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from metrology.diagnosis import Cause, Diagnosis
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.subject import Array
from metrology.diagnostics.tension_records import Record
from metrology.message import said

BESIDE = 6
"""Part of a record, on either side of a place, from whose readings a jump is estimated: a sixth."""
FEWEST = 8
"""Readings on either side of a place, without which the slope there is not known, and so no jump."""
TRIED = 96
"""Places of a record at which jumps are compared at most."""
OTHERS = 12
"""Places elsewhere of which the scatter of jumps is known."""
SEEN = 3.5
"""Jump over the scatter of those at other places from which on it is seen: its place was picked among a dozen."""
TINY = 1e-150
"""In the place of a scatter of nothing: its square is a number, and so is the square of its reciprocal."""
AT_END = 0.01
"""Part of the range of a shape by which it has to lie off the ends."""
MEDIAN = 0.6744897501960817
"""Median of the absolute value of a standard normal variable."""


def unseen(
    found: Diagnosis, records: Sequence[Record], candidates: Mapping[str, Candidate], halves: int
) -> dict[str, str]:
    """Causes that were named, or stand in a group with others, and that the records do not show; why not.

    Parameters
    ----------
    found : Diagnosis
        Of these records.
    records : sequence of Record
        Of the specimens, each in so many `halves`.
    candidates : mapping of str to Candidate
        The table.
    halves : int
        Records of each mounting.
    """
    grouped = {name for group in found.groups if len(group) > 1 for name in group}
    reasons: dict[str, str] = {}
    for cause in found.causes:
        if not (cause.verdict == "supported" or cause.effect in grouped):
            continue
        one = candidates[cause.effect]
        held = next((size.name for size in one.parameters if size.held and size.high - size.low > OTHERS), "")
        if held and not _shows(one, found.extended_model.get(held), records, halves):
            reasons[cause.effect] = said("no step stands out of the scatter of the neighbouring readings")
        elif vague := _vague(cause, one):
            reasons[cause.effect] = said("the readings do not determine {name}", name=vague)
    return reasons


def _vague(cause: Cause, one: Candidate) -> str:
    """Size of a cause that is not known from none, or shape that may lie anywhere in its range or at an end; or empty.

    At an end of its range a shape is no place in the record any more: a knee from which on all was read bends nothing.
    """
    sizes = {size.name: size for size in one.parameters if not (size.held or size.own)}
    for value in cause.parameters:
        size = sizes.get(value.name)
        if size is None:
            continue
        within = min(value.value - size.low, size.high - value.value) if size.shape else abs(value.value - size.null)
        most = size.high - size.low if size.shape else within
        if value.u >= most or (size.shape and within < AT_END * most):
            return value.name
    return ""


def _shows(one: Candidate, place: float | None, records: Sequence[Record], halves: int) -> bool:
    """Whether a jump of a cause is seen at its place, or at any where the model does not have it."""
    found = jumps(one, records, halves)
    if place is None:
        return any(found.over(row) >= SEEN for row in range(len(found.size)))
    number, part = divmod(round(place), records[0].seen.steps)
    time = records[number].seen.time
    instant = float(time.min() + (part + 0.5) / records[number].seen.steps * np.ptp(time))
    rows = np.flatnonzero((found.mounting == number // halves) & (np.abs(found.time - instant) <= found.apart))
    return any(found.over(int(row)) >= SEEN for row in rows)


@dataclass(frozen=True)
class Jumps:
    """Jumps of the readings at places of all mountings, in units of what their own readings let them scatter by.

    Parameters
    ----------
    mounting, time, size : ndarray, shape (p,)
        Where each place lies, and its jump, positive the way the cause goes.
    reach : float
        Time over which neighbouring places share readings / s.
    apart : float
        Time between two places / s.
    """

    mounting: NDArray[np.intp]
    time: Array
    size: Array
    reach: float
    apart: float

    def over(self, row: int) -> float:
        """Jump at a place over the scatter of those that share no reading with it; 0 where too few do not."""
        others = (self.mounting != self.mounting[row]) | (np.abs(self.time - self.time[row]) > self.reach)
        if np.count_nonzero(others) < OTHERS:
            return 0.0
        return float(self.size[row] / max(_scatter(self.size[others]), TINY))


def jumps(one: Candidate, records: Sequence[Record], halves: int) -> Jumps:
    """Jumps between the lines over the force through the readings before and after each place.

    Of a cause that acts in both readings they are means over both, by the scatter of each.

    Parameters
    ----------
    one : Candidate
        The cause: in which readings it acts, and whether either way.
    records : sequence of Record
        Of the specimens, each in so many `halves`.
    halves : int
        Records of each mounting.
    """
    assert one.cause.reading is not None
    first = records[0].seen
    column = np.asarray(one.cause.reading(first, 0.0))
    kinds = [kind for kind in np.unique(first.crosshead) if column[first.crosshead == kind].any()]
    mountings = [records[at : at + halves] for at in range(0, len(records), halves)]
    found = [_of_mounting(number, parts, kinds) for number, parts in enumerate(mountings)]
    mounting, time, reach, apart = (np.concatenate([each[at] for each in found]) for at in (0, 1, 3, 4))
    sizes = np.concatenate([each[2] for each in found])
    weight = 1.0 / np.maximum([_scatter(own) for own in sizes.T], TINY) ** 2
    size = sizes @ weight / weight.sum()
    size = np.abs(size) if one.signed else size
    return Jumps(mounting.astype(int), time, size, float(reach.max(initial=0.0)), float(apart.max(initial=0.0)))


def _of_mounting(number: int, parts: Sequence[Record], kinds: Sequence[float]) -> tuple[Array, ...]:
    """Number, times and jumps of the places of one mounting, shape (p, channels); reach and distance of them / s."""
    rows = [[one.seen.crosshead == kind for one in parts] for kind in kinds]
    force = np.concatenate([one.seen.force[row] for one, row in zip(parts, rows[0], strict=True)])
    time = np.concatenate([one.seen.time[row] for one, row in zip(parts, rows[0], strict=True)])
    own = [np.concatenate([one.y[row] for one, row in zip(parts, each, strict=True)]) for each in rows]
    read = np.column_stack(own)
    count, beside = len(force), max(len(force) // BESIDE, FEWEST)
    places = np.unique(np.linspace(FEWEST, count - FEWEST, TRIED if count > 2 * FEWEST else 0).astype(int))
    found = []
    for place in places:
        part = slice(max(place - beside, 0), min(place + beside, count))
        late = np.arange(part.start, part.stop) >= place
        off = force[part] - force[place]
        scale = float(np.abs(off).max()) or 1.0
        X = np.column_stack([late, np.ones(len(off)), off / scale, late * off / scale]).astype(float)
        inverse = np.linalg.pinv(X.T @ X)
        found.append((inverse @ (X.T @ read[part]))[0] / np.sqrt(max(float(inverse[0, 0]), TINY)))
    each = np.ones(len(places))
    spacing = float(np.ptp(time)) / max(count - 1, 1)
    apart = spacing * max(count / max(len(places), 1), 1.0)
    sizes = np.reshape(found, (len(places), len(kinds)))
    return each * number, time[places], sizes, each * beside * spacing, each * apart


def _scatter(values: Array) -> float:
    """Standard deviation of most of some values about zero, whatever a few of them are."""
    return float(np.median(np.abs(values))) / MEDIAN if len(values) else 0.0
