"""Families of unlisted laws: columns of smooth forms and of powers, and how smooth they are."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from metrology.diagnostics.direction import Direction
from metrology.diagnostics.line import Line
from metrology.diagnostics.span import orthonormal, pieces
from metrology.diagnostics.subject import Array, Blocks, Marks

SMOOTH = (0.25, 0.5, 1.0)
"""Lengths over which such a law changes, over half of the range, equally probable: the listed laws are as smooth."""


@dataclass(frozen=True)
class Family:
    """Columns of one family of laws in the metric of a line, beside its base."""

    direction: Direction
    rows: Array
    roots: tuple[Array, ...]
    """Roots of the covariance of the amounts for a law of unit size, one for each length, or each two neighbours."""

    @property
    def is_simple(self) -> bool:
        """Whether the law is of one quantity; a force of position and velocity describes any motion without a cause."""
        return self.direction.places is None or self.direction.places.shape[1] == 1

    @property
    def of_one_size(self) -> Family:
        """The same laws, all of whose values are of one size."""
        return replace(self, direction=replace(self.direction, rough=False))


def hats(by: Array, knots: Array) -> Array:
    """Straight pieces that are one at a place and none at the others, a column for each, shape (n, h)."""
    return np.column_stack([np.interp(by, knots, hat) for hat in np.eye(len(knots))])


def splines(by: Array, knots: Array) -> Array:
    """Cardinal cubic splines, shape (n, h): a cubic is such a sum, which straight pieces meet to 1e-2 only."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(knots, np.eye(len(knots)))(by))


@dataclass(frozen=True)
class Powers:
    """Sums over p of a(p)·|q|^p·sign q, or even ones of a(p)·|q|^p, a(p) a smooth function of p.

    A listed power follows one of another exponent far better than a law of any form is cheap; such a sum needs hardly
    more ways than the listed one. Not one power alone: between two of them it would be as wrong, and as sure.

    Parameters
    ----------
    most : float
        Largest size of the quantity q, at which each power is one.
    odd, even : sequence of float
        Exponents.
    """

    most: float
    odd: Sequence[float]
    even: Sequence[float]

    def columns(self, q: Array) -> Array:
        """Every power of a quantity, shape (…,) → (…, p)."""
        size, sign = np.abs(q[..., None] / self.most), np.sign(q[..., None])
        return np.concatenate([sign * size ** np.array(self.odd), size ** np.array(self.even)], axis=-1)

    def direction(self, family: str, unit: float, rows: Blocks, count: int, straight: Mapping[str, float]) -> Direction:
        """As the search takes it, stated at so many places from zero on."""
        name = family.partition(" of ")[2]
        values = {f"{name}@{power:g}": float(power) for power in self.odd}
        values |= {f"even {name}@{power:g}": float(power) for power in self.even}
        places = np.linspace(0.0, self.most, count)
        return Direction(family, values, unit, rows, ways=tuple(values), sums=(places, np.abs(self.columns(places))),
                         neighbours=True, straight=straight)  # fmt: skip


def families(line: Line, directions: Sequence[Direction], used: Sequence[Marks]) -> list[Family]:
    """Families in the metric of a line.

    A sum of powers may also be of two neighbours alone, of any sizes: that is one power between them, to the square of
    their distance. In a smooth sum that is no power, the first power is fitted to what differs: c, for the readings
    alike.
    """
    found = []
    weight = 1.0 / math.sqrt(line.noise.misfit)
    for one in directions:
        data = weight * line.noise.whitened(line.fit, one.rows, used)
        rows = np.vstack([data, np.zeros((len(line.residual) - len(data), data.shape[1]))])
        roots = [_root(one, length) for length in SMOOTH]
        if one.neighbours:
            each, names = np.eye(len(one.values)), [name.split("@")[0] for name in one.values]
            # Odd powers alone are such a law, too, and so are two neighbours of either.
            odd = np.array([name == names[0] for name in names])
            roots += [root * odd[:, None] for root in roots if not odd.all()]
            roots += [each[:, at : at + 2] for at in range(len(each) - 1) if names[at] == names[at + 1]]
        found.append(Family(one, rows, tuple(roots)))
    return found


def compressed(line: Line, found: Sequence[Family]) -> tuple[Line, list[Family]]:
    """Return a line and families turned so that no row is without a column: all that is asked of them is the same."""
    own = [one for one in line.columns if one.direction is None]
    parts = [line.base, *(one.rows for one in own), *(one.rows for one in found), line.residual[:, None]]
    whole = np.zeros((0, sum(part.shape[1] for part in parts)))
    for piece in pieces(parts):
        whole = np.asarray(np.linalg.qr(np.vstack([whole, np.hstack(piece)]), mode="r"))
    base, *rows, residual = np.split(whole, np.cumsum([part.shape[1] for part in parts])[:-1], axis=1)
    columns = tuple(replace(one, rows=part) for one, part in zip(own, rows[: len(own)], strict=True))
    turned = [replace(one, rows=part) for one, part in zip(found, rows[len(own) :], strict=True)]
    return replace(line, base=base, residual=residual[:, 0], columns=columns), turned


def _root(one: Direction, length: float) -> Array:
    """Root of a squared-exponential covariance over the places; of each name before the '@' by itself."""
    names = np.array([name.split("@")[0] for name in one.values])
    places = one.places if one.places is not None else np.array(list(one.values.values()))[:, None]
    found = np.zeros((len(places), len(places)))
    for name in dict.fromkeys(names.tolist()):
        own = np.flatnonzero(names == name)
        found[np.ix_(own, own)] = _smooth(places[own], length)
    if one.listed:
        if 0 not in one.listed:
            found -= np.array([np.interp(0.0, places[:, 0], column) for column in found.T])
        for name in dict.fromkeys(names.tolist()):
            own = names == name
            known = orthonormal(np.column_stack([places[own, 0] ** power for power in one.listed]))
            found[own] -= known @ (known.T @ found[own])
    return found


def _smooth(at: Array, length: float) -> Array:
    """Root of the covariance of one smooth law, shape (h, h)."""
    half = 0.5 * np.ptp(at, axis=0)
    scaled = at / (length * np.where(half > 0, half, 1.0))
    distance = scaled[:, None] - scaled[None, :]
    covariance = np.exp(-0.5 * np.sum(distance**2, axis=2)) + 1e-9 * np.eye(len(at))
    return np.asarray(np.linalg.cholesky(covariance))
