"""Laws that stand in nobody's table: a smooth force, or a curved reading, of any form, as one more candidate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import logsumexp

from metrology.diagnostics.likelihood import RESOLVED, Line, orthonormal
from metrology.diagnostics.sets import Set
from metrology.diagnostics.subject import Array, Direction, Marks
from metrology.estimation.covariance import spread

SMOOTH = (0.25, 0.5, 1.0)
"""Lengths over which such a law changes, over half of the range, equally probable: the listed laws are as smooth."""
SIZES = np.logspace(-0.5, 5.5, 13)
"""Its size, over what can just be seen of it: every decade is equally probable, to a million times that."""


@dataclass(frozen=True)
class Law:
    """An unlisted law beside a set of effects.

    Parameters
    ----------
    family : str
        What it is, and of what: 'force of velocity', 'curve of tension'.
    log_bayes : float
        Ln evidence with the law over that without.
    at, amounts, u : ndarray, shape (h,)
        Where its size is stated, the size there in SI, and its standard uncertainty.
    """

    family: str
    log_bayes: float
    at: Array
    amounts: Array
    u: Array
    columns: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    """What the law does to the residuals, in ways whose sizes are normal with a standard deviation of one noise."""
    gone: float = 0.0
    """χ² that the law takes away."""
    noise: float = 1.0
    """Noise with the law over that of the metric, where few readings leave the noise to be estimated with the rest."""
    straight: str = ""
    """Unknown that the straight part of the law is, which is no part of it; nothing where it has none."""

    @property
    def slope(self) -> float:
        """Slope of a straight law of the same size: by as much that unknown may be off, in its unit."""
        return self.size / float(np.sqrt(np.mean(self.at**2))) if self.straight else 0.0

    @property
    def size(self) -> float:
        """Root mean square of the law over the places where it is stated."""
        return float(np.sqrt(np.mean(self.amounts**2))) if len(self.amounts) else 0.0


@dataclass(frozen=True)
class Family:
    """Columns of one family of laws in the metric of a line, beside its base."""

    direction: Direction
    rows: Array
    roots: tuple[Array, ...]
    """Roots of the covariance of the amounts for a law of unit size, one for each length."""

    @property
    def is_simple(self) -> bool:
        """Whether the law is of one quantity; a force of position and velocity describes any motion without a cause."""
        return self.direction.places is None or self.direction.places.shape[1] == 1


def families(line: Line, directions: Sequence[Direction], used: Sequence[Marks]) -> list[Family]:
    """Families in the metric of a line."""
    found = []
    weight = 1.0 / math.sqrt(line.noise.misfit)
    for one in directions:
        data = weight * line.noise.whitened(line.fit, one.rows, used)
        rows = np.vstack([data, np.zeros((len(line.residual) - len(data), data.shape[1]))])
        found.append(Family(one, rows, tuple(_root(one, length) for length in SMOOTH)))
    return found


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


def best(line: Line, found: Sequence[Family], kept: Set, free: float | None = None) -> tuple[Law | None, float]:
    """Law that explains most together with some effects of the fit of a line, by its evidence, and χ² without it.

    The other effects of the fit are at their null, by the straight line: a law that has their form can take their place
    without a change of the motion, however large they are. None without families.

    Parameters
    ----------
    line : Line
        At the fit.
    found : sequence of Family
        Tried.
    kept : set of str
        Effects of the fit that stay.
    free : float, optional
        Degrees of freedom of the fit, where the noise is estimated with the rest.
    """
    laws, squares = of_families(line, found, kept, free)
    if not laws:
        return None, squares
    # One law of any family is one alternative: its evidence is the mean over the families, equally probable before.
    log_bayes = float(logsumexp([one.log_bayes for one in laws])) - math.log(len(laws))
    return replace(max(laws, key=lambda one: one.log_bayes), log_bayes=log_bayes), squares


def of_families(line: Line, found: Sequence[Family], kept: Set, free: float | None = None) -> tuple[list[Law], float]:
    """Law of each family together with some effects of the fit of a line, and χ² without any; as for `best`."""
    carried = [one.rows for one in line.columns if one.direction is None and one.effect in kept]
    taken = orthonormal(np.hstack([line.base, *carried]))
    residual = line.residual - taken @ (taken.T @ line.residual)
    laws = [_law(one, one.rows - taken @ (taken.T @ one.rows), residual, free) for one in found]
    return laws, float(residual @ residual)


def _law(one: Family, rows: Array, residual: Array, free: float | None) -> Law:
    """Evidence of a family: averaged over its size and length; the amounts are normal (GP on a straight line)."""
    at = np.array(list(one.direction.values.values()))
    whole = float(residual @ residual)
    if np.linalg.norm(rows) <= RESOLVED * np.linalg.norm(one.rows):
        # The rest of the model can do the same: the readings say nothing of a size.
        return Law(one.direction.effect, -math.inf, at, np.zeros(len(at)), np.zeros(len(at)))
    # Not by products of the rows, which keep half of their digits: the largest sizes see ways of 1e-11 of the largest.
    triangle: Array = np.asarray(np.linalg.qr(np.column_stack([rows, residual]), mode="r"))
    tried = [_sized(root, triangle[:, :-1] @ root, -triangle[:, -1], whole, free) for root in one.roots]
    logs = np.concatenate([each.logs for each in tried])
    if not np.isfinite(logs).any():
        return Law(one.direction.effect, -math.inf, at, np.zeros(len(at)), np.zeros(len(at)))
    log_bayes = float(logs.max() + math.log(np.exp(logs - logs.max()).mean()))
    log_bayes -= math.log(max(one.direction.looks, 1.0))
    chosen, amount = max(tried, key=lambda each: float(each.logs.max())), one.direction.amount
    at, ways = one.direction.sums or (at, np.eye(len(at)))
    u = chosen.noise * np.sqrt(np.maximum(np.einsum("hp,pq,hq->h", ways, chosen.spread, ways), 0.0))
    columns = one.rows @ chosen.root
    return Law(
        one.direction.effect, log_bayes, at, ways @ chosen.mean * amount, u * amount, columns, chosen.gone,
        chosen.noise, one.direction.straight,
    )  # fmt: skip


@dataclass(frozen=True)
class _Sized:
    """Law of one length: ln evidence for every size; at the best its amounts, their covariance, a root of that before.

    Covariance and root are those over the variance of the noise. `gone`: χ² that it explains.
    """

    logs: Array
    mean: Array
    spread: Array
    root: Array
    gone: float
    noise: float


def _sized(root: Array, rows: Array, sought: Array, whole: float, free: float | None) -> _Sized:
    """Law of one length in every size: its rows, and what they are to add up to.

    Where the noise is estimated with the rest, the size of the law is in units of it (normal-inverse-gamma prior:
    Bernardo & Smith, Bayesian Theory, 1994, 5.4), and it is what remains with the law.
    """
    left, singular, right = np.linalg.svd(rows)
    values, pull, vectors = np.zeros(len(root)), np.zeros(len(root)), right.T
    values[: len(singular)] = singular**2
    pull[: len(singular)] = singular * (left.T @ sought)[: len(singular)]
    top = float(values.max(initial=0.0))
    if top <= 0:
        none = np.zeros_like(root)
        return _Sized(np.full(len(SIZES), -math.inf), np.zeros(len(root)), none, none, 0.0, 1.0)
    squares = SIZES**2 / top
    logs = np.empty(len(squares))
    for place, s in enumerate(squares):
        gone = float(np.sum(s * pull**2 / (1 + s * values)))
        gain = 0.5 * gone if free is None else -0.5 * free * math.log(max(1.0 - gone / max(whole, 1e-300), 1e-12))
        logs[place] = gain - 0.5 * float(np.sum(np.log1p(s * values)))
    s = float(squares[int(np.argmax(logs))])
    spread = vectors / (1.0 / s + values) @ vectors.T
    mean = root @ (vectors @ (pull * s / (1 + s * values)))
    gone = float(np.sum(s * pull**2 / (1 + s * values)))
    noise = 1.0 if free is None else math.sqrt(max(whole - gone, 0.0) / max(free, 1))
    return _Sized(logs, np.asarray(mean), np.asarray(root @ spread @ root.T), math.sqrt(s) * root, gone, noise)


def estimates(line: Line, kept: Set, law: Law) -> tuple[Array, Array]:
    """Change of the unknowns of the base, and their standard uncertainties, with some effects and a law."""
    carried = [one.rows for one in line.columns if one.direction is None and one.effect in kept]
    columns = np.hstack([line.base, *carried, law.columns])
    count, ways = line.base.shape[1], law.columns.shape[1]
    rows = np.vstack([columns, np.eye(columns.shape[1])[-ways:]])
    size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
    # Not by normal equations, which square what separates a law from the unknowns.
    right = np.concatenate([-line.residual, np.zeros(ways)])
    shift = np.linalg.lstsq(rows / size, right, rcond=1e-12)[0] / size
    return shift[:count], law.noise * np.sqrt(np.diag(spread(rows)))[:count]
