"""Laws of a free decay that nobody lists: smooth forces along the motion, and a gain that changes with time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from metrology.coordinate import QUANTITIES
from metrology.diagnostics.direction import STRAIGHT, Direction
from metrology.diagnostics.families import Powers, hats, splines
from metrology.diagnostics.plain import GAIN
from metrology.diagnostics.release import MOTION, Path, Record
from metrology.diagnostics.subject import Array
from metrology.rig import Rig

KNOTS = 9
"""Places at which an unlisted law has a size of its own."""
FEWER = 7
"""Such places each way for a force of position and velocity."""
POWERS = {
    "x": (0.0, 0.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 7.0),
    "v": (0.5, 0.75, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0),
}
"""Exponents of |q|^p·sign q of which a law between the listed ones is a sum; the first power is k, or c."""
EVEN = {"x": (1.0, 1.5, 2.5, 3.0, 4.0), "v": (0.5, 1.0, 1.5, 2.0, 3.0)}
"""Exponents of |q|^p beside them: what acts on one side, or one way, is half of it odd and half even."""
GAIN_SEEN = 1e-3
"""Unit of an unlisted change of the gain."""


@dataclass(frozen=True)
class _Axis:
    """Places of one quantity up to its largest value, closer together about zero, where most of a decay goes on."""

    count: int
    most: float

    @property
    def places(self) -> Array:
        g = np.linspace(-1.0, 1.0, self.count)
        return np.asarray(1.02 * self.most * np.sign(g) * np.abs(g) ** 1.5)

    def splines(self, by: Array) -> Array:
        """Cardinal cubic splines at the places, shape (n, count)."""
        return splines(by, self.places)


def _products(one: Array, other: Array) -> Array:
    """Products of all columns of two, shape (n, p·q)."""
    return np.asarray((one[:, :, None] * other[:, None, :]).reshape(len(one), -1))


def unlisted(
    rig: Rig, records: Sequence[Record], values: Sequence[tuple[float, ...]], *, unit: float
) -> list[Direction]:
    """Families of unlisted laws along a fitted motion.

    Parameters
    ----------
    rig : Rig
        Mass on a line that holds both ways.
    records : sequence of Record
        Releases.
    values : sequence of tuple of float
        What the motion of each depends on (`release.MOTION`).
    unit : float
        A small force / N, or torque / (N·m), that the columns are of.
    """
    paths = [one.path(rig, own) for one, own in zip(records, values, strict=True)]
    forces = [*_forces(rig, records, paths, unit), *_powers(rig, records, paths, unit)]
    return [*forces, _gain(rig, records, values)]


def _powers(rig: Rig, records: Sequence[Record], paths: Sequence[Path], unit: float) -> Iterator[Direction]:
    """Sums of powers of position or of velocity."""
    words = QUANTITIES[rig.coordinate]
    for quantity, exponents in POWERS.items():
        along = [getattr(path, quantity) for path in paths]
        powers = Powers(max(float(np.abs(one).max()) for one in along), exponents, EVEN[quantity])
        rows = tuple(-one.pushed(path, unit * powers.columns(q)) / one.u[:, None]
                     for one, path, q in zip(records, paths, along, strict=True))  # fmt: skip
        family = f"{words['F'].word} of powers of {words[quantity].word}"
        yield powers.direction(family, unit, rows, KNOTS, {})


def _forces(rig: Rig, records: Sequence[Record], paths: Sequence[Path], unit: float) -> list[Direction]:
    """Smooth forces of position, of velocity and of both, a spline a column."""
    words = QUANTITIES[rig.coordinate]
    x, v = (_Axis(KNOTS, max(float(np.abs(getattr(path, name)).max()) for path in paths)) for name in "xv")
    coarse = [_Axis(FEWER, axis.most) for axis in (x, v)]
    grid = np.array([(a, b) for a in coarse[0].places for b in coarse[1].places])
    found = []
    for name, places, columns in (
        (words["x"].word, x.places[:, None], [x.splines(path.x) for path in paths]),
        (words["v"].word, v.places[:, None], [v.splines(path.v) for path in paths]),
        (
            f"{words['x'].word} and {words['v'].word}", grid,
            [_products(coarse[0].splines(path.x), coarse[1].splines(path.v)) for path in paths],
        ),
    ):  # fmt: skip
        rows = tuple(-one.pushed(path, unit * hats) / one.u[:, None]
                     for one, path, hats in zip(records, paths, columns, strict=True))  # fmt: skip
        names = {f"{name}@{at}": float(place) for at, place in enumerate(places[:, 0])}
        family = f"{words['F'].word} of {name}"
        found.append(Direction(family, names, unit, rows, ways=tuple(names), places=places))
    return found


def _gain(rig: Rig, records: Sequence[Record], values: Sequence[tuple[float, ...]]) -> Direction:
    """Factor of the reading that changes with time, in each record by itself: a hat over the record a column.

    No more hats than periods, over the time in which the motion is more than noise: a factor that changes faster is a
    line beside the decay, which is listed. A steady one is the amplitude, one that falls steadily the damping. Of one
    release, any gain of time is a damping that depends on the amplitude, which falls with time.
    """
    columns: list[Array] = []
    names: dict[str, float] = {}
    for number, (one, own) in enumerate(zip(records, values, strict=True)):
        moved = one.follow(rig, [own])[0] / one.u
        seen = float(one.t[np.abs(moved) > 1.0].max(initial=one.t[-1] / 2)) - float(one.t[0])
        count = int(np.clip(one.omega * seen / (2 * np.pi), len(STRAIGHT) + 1, KNOTS))
        knots = one.t[0] + np.linspace(0.0, seen, count)
        columns.append(moved[:, None] * hats(one.t, knots))
        names |= {f"{GAIN} of time {number}@{at}": float(knot) for at, knot in enumerate(knots)}
    ends = np.cumsum([len(one.t) for one in records])[:-1]
    rows = np.split(-GAIN_SEEN * block_diag(*columns), ends)
    words = QUANTITIES[rig.coordinate]
    # A factor 1 + b·t is a damping less by 2m·b, at the same frequency: k = m·ω² + c²/(4m) falls with it.
    c = float(np.mean([own[MOTION.index("c")] for own in values]))
    straight = {"c": 2 * rig.m, "k": c}
    return Direction(f"{GAIN} of time", names, GAIN_SEEN, tuple(rows), ways=tuple(names), listed=STRAIGHT,
                     straight=straight, mimics=f"{words['F'].word} of {words['v'].word}")  # fmt: skip
