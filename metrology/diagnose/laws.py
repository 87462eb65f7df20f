"""Laws that stand in nobody's table: a smooth force, or a curved reading, of any form, as one more candidate."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from metrology.diagnose.likelihood import Line, orthonormal
from metrology.diagnose.subject import Array, Direction, Marks

SMOOTH = 0.5
"""Length over which such a law changes, over half of the range: no finer than the listed laws are themselves."""
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

    @property
    def size(self) -> float:
        """Root mean square of the law over the places where it is stated."""
        return float(np.sqrt(np.mean(self.amounts**2))) if len(self.amounts) else 0.0


@dataclass(frozen=True)
class Family:
    """Columns of one family of laws in the metric of a line, beside its base."""

    direction: Direction
    rows: Array
    root: Array
    """Root of the covariance of the amounts, for a law of unit size."""


def families(line: Line, directions: Sequence[Direction], used: Sequence[Marks]) -> list[Family]:
    """Families in the metric of a line."""
    found = []
    weight = 1.0 / math.sqrt(line.noise.misfit)
    for one in directions:
        data = weight * line.noise.whitened(line.fit, one.rows, used)
        rows = np.vstack([data, np.zeros((len(line.residual) - len(data), data.shape[1]))])
        found.append(Family(one, rows, _root(one.values)))
    return found


def _root(places: Mapping[str, float]) -> Array:
    """Root of a squared-exponential covariance over the places; of each name before the '@' by itself."""
    names = np.array([name.split("@")[0] for name in places])
    at, found = np.array(list(places.values())), np.zeros((len(places), len(places)))
    for name in dict.fromkeys(names.tolist()):
        own = np.flatnonzero(names == name)
        found[np.ix_(own, own)] = _smooth(at[own])
    return found


def _smooth(at: Array) -> Array:
    """Root of the covariance of one smooth law, shape (h, h)."""
    half = 0.5 * float(np.ptp(at)) or 1.0
    distance = (at[:, None] - at[None, :]) / (SMOOTH * half)
    covariance = np.exp(-0.5 * distance**2) + 1e-9 * np.eye(len(at))
    return np.asarray(np.linalg.cholesky(covariance))


def best(line: Line, found: Sequence[Family], free: int | None = None) -> Law | None:
    """Law that explains most beside the fit of a line, by its evidence; None without families.

    `free`: degrees of freedom of the fit, where the noise is estimated with the rest.
    """
    carried = [one.rows for one in line.columns if one.direction is None]
    taken = orthonormal(np.hstack([line.base, *carried]))
    residual = line.residual - taken @ (taken.T @ line.residual)
    count = len(residual)
    laws = [_law(one, rows - taken @ (taken.T @ rows), residual, free) for one in found
            if len(rows := _fitting(one.rows, count)) == count]  # fmt: skip
    return max(laws, key=lambda one: one.log_bayes, default=None)


def _fitting(rows: Array, count: int) -> Array:
    """Rows of a family with as many priors below as a line has: no prior sees a law."""
    return rows[:count] if len(rows) >= count else np.vstack([rows, np.zeros((count - len(rows), rows.shape[1]))])


def _law(one: Family, rows: Array, residual: Array, free: int | None) -> Law:
    """Evidence of a family: the size of its law averaged over, the amounts given it normal (GP on a straight line)."""
    turned = rows @ one.root
    values, vectors = np.linalg.eigh(turned.T @ turned)
    values = np.maximum(values, 0.0)
    pull = -vectors.T @ (turned.T @ residual)
    top = float(values.max(initial=0.0))
    at = np.array(list(one.direction.values.values()))
    if top <= 0:
        return Law(one.direction.effect, -math.inf, at, np.zeros(len(at)), np.zeros(len(at)))
    squares = SIZES**2 / top
    whole = float(residual @ residual)
    logs = np.empty(len(squares))
    for place, s in enumerate(squares):
        gone = float(np.sum(s * pull**2 / (1 + s * values)))
        gain = 0.5 * gone if free is None else -0.5 * free * math.log(max(1.0 - gone / max(whole, 1e-300), 1e-12))
        logs[place] = gain - 0.5 * float(np.sum(np.log1p(s * values)))
    weights = np.exp(logs - logs.max())
    log_bayes = float(logs.max() + math.log(weights.mean())) - math.log(max(one.direction.looks, 1.0))
    s = float(squares[int(np.argmax(logs))])
    spread = vectors / (1.0 / s + values) @ vectors.T
    amounts = one.root @ (vectors @ (pull * s / (1 + s * values))) * one.direction.amount
    u = np.sqrt(np.maximum(np.diag(one.root @ spread @ one.root.T), 0.0)) * one.direction.amount
    return Law(one.direction.effect, log_bayes, at, amounts, u)
