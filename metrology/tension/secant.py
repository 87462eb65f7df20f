"""Secant between two points of a record, and tangent at one of them."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.tension.passage import Passage, passage
from metrology.tension.slope import Array, averaged, ramp, weighed
from metrology.tension.test import Mounting, Range

TERMS, MORE = 4, 6
"""Terms of the polynomial of the force through the readings, and of one with two more: what both differ by is what the
form is off by."""
STEPS = 20
"""Steps of Newton's method at most, to the force at which a polynomial has a stated reading."""


@dataclass(frozen=True)
class Local:
    """Slope of a record at a point, or between two.

    Parameters
    ----------
    value, u, dof : float
        Slope in the unit of the reading by newton, its standard uncertainty by the scatter, degrees of freedom.
    form : float
        How far it is off where the curve is no cubic.
    count : int
        Readings.
    """

    value: float
    u: float
    dof: float
    form: float
    count: int


@dataclass(frozen=True)
class _Cubic:
    """Polynomial of (F − middle)/span through readings, in the metric of their noise."""

    values: Array
    covariance: Array
    dof: float
    middle: float
    span: float

    def row(self, force: float, order: int = 0) -> Array:
        """What the reading, or its derivative by force, is by the coefficients."""
        powers, t = np.arange(len(self.values)), (force - self.middle) / self.span
        if order == 0:
            return np.asarray(t**powers)
        return np.asarray(powers * t ** np.maximum(powers - 1.0, 0.0) / self.span)

    def reached(self, reading: float, force: float) -> float:
        """Force at which a reading is reached, from one nearby."""
        for _ in range(STEPS):
            step = float(self.row(force) @ self.values - reading) / float(self.row(force, 1) @ self.values)
            force -= step
            if abs(step) < 1e-12 * self.span:
                break
        return force


def _through(force: Array, y: Array, terms: int) -> _Cubic:
    F, Y = averaged(force, y)
    span, middle = float(np.ptp(F)) or 1.0, float(F.mean())
    dof, (values, covariance), _ = weighed((ramp(F) - middle) / span, (F - middle) / span, Y, terms)
    return _Cubic(values, covariance, dof, middle, span)


def secant(test: str, one: Mounting, chosen: Range, reading: Array) -> Local:
    """Slope between two stated points of a record.

    Parameters
    ----------
    test : str
        Id of the test, for a refusal.
    one : Mounting
        With its record.
    chosen : Range
        The two points.
    reading : ndarray, shape (n,)
        Strain, or displacement of the crosshead.

    Raises
    ------
    MetrologyError
        Where the record does not pass both points.
    """
    found = passage(f"{test}.secant", one, chosen, 0.0)
    scale = _nominal(one)

    def between(cubic: _Cubic) -> tuple[float, float]:
        ends = np.array([chosen.low, chosen.high])
        if chosen.by == "strain":
            ends = np.array([cubic.reached(end * scale, at) for end, at in zip(ends, found.force, strict=True)])
        rows = np.array([cubic.row(end) for end in ends])
        value = float((rows[1] - rows[0]) @ cubic.values) / float(ends[1] - ends[0])
        # Points in strain move along the curve where it is uncertain.
        along = [value / float(cubic.row(end, 1) @ cubic.values) if chosen.by == "strain" else 1.0 for end in ends]
        moved = (along[1] * rows[1] - along[0] * rows[0]) / float(ends[1] - ends[0])
        return value, sqrt(float(moved @ cubic.covariance @ moved))

    return _local(found, one, reading, between)


def tangent(test: str, one: Mounting, chosen: Range, reading: Array, line: Passage) -> Local:
    """Slope at a stated point of a record, of the curve through the range of its line.

    Parameters
    ----------
    test : str
        Id of the test, for a refusal.
    one : Mounting
        With its record.
    chosen : Range
        The point, as both of its ends.
    reading : ndarray, shape (n,)
        Strain, or displacement of the crosshead.
    line : Passage
        Range of the line.

    Raises
    ------
    MetrologyError
        Where the point is outside of the range.
    """
    ends = line.strain if chosen.by == "strain" else line.force
    if not ends[0] <= chosen.low <= ends[1]:
        unit = " N" if chosen.by == "force" else ""
        got = f"{chosen.low:.4g}{unit}, where the range of '{one.name}' is {ends[0]:.4g}{unit} to {ends[1]:.4g}{unit}"
        fix = "state a 'range' that holds the point"
        raise MetrologyError(Fault(f"{test}.tangent", got, "a point within the range of the line", fix))
    scale = _nominal(one)

    def at(cubic: _Cubic) -> tuple[float, float]:
        force = chosen.low
        if chosen.by == "strain":
            force = cubic.reached(force * scale, float(np.mean(line.force)))
        row = cubic.row(force, 1)
        return float(row @ cubic.values), sqrt(float(row @ cubic.covariance @ row))

    return _local(line, one, reading, at)


def _nominal(one: Mounting) -> float:
    """Reading by nominal strain: 1 of an extensometer, the free length of a crosshead."""
    return 1.0 if one.strains or one.length is None else one.length.value


def _local(found: Passage, one: Mounting, reading: Array, slope) -> Local:  # type: ignore[no-untyped-def]
    rows = found.rows
    force, y = one.force[rows], reading[rows]
    cubic = _through(force, y, TERMS)
    value, u = slope(cubic)
    return Local(value, u, cubic.dof, abs(slope(_through(force, y, MORE))[0] - value), rows.stop - rows.start)
