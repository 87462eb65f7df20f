"""Laws that stand in nobody's table: a smooth force, or a curved reading, of any form, as one more candidate."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import logsumexp

from metrology.diagnostics.families import Family
from metrology.diagnostics.line import Line
from metrology.diagnostics.sets import NEGLIGIBLE, Scarce, Set, log_likelihood
from metrology.diagnostics.span import RESOLVED, orthonormal
from metrology.diagnostics.subject import Array
from metrology.estimation.covariance import spread

SIZES = np.logspace(0.0, 6.0, 13)
"""Its size, over what can just be seen of it: every decade is equally probable, to a million times that."""


@dataclass(frozen=True)
class Kind:
    """A law of one length, as normal sums of the columns of its family with one noise as standard deviation.

    `weight`: its part in the evidence of the family. `noise`: with the law over that of the metric, where few readings
    leave the noise to be estimated with the rest.
    """

    weight: float
    root: Array = field(repr=False)
    noise: float = 1.0


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
    rows: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    """What the amounts do to the residuals."""
    kinds: tuple[Kind, ...] = ()
    """Every length that the readings do not rule out."""
    gone: float = 0.0
    """χ² that the law takes away."""
    straight: Mapping[str, float] = field(default_factory=dict)
    """Unknowns that the straight part of the law is, which is no part of it, and what each is for a slope of one."""
    mimics: str = ""
    """Family that does the same to the readings as far as these show one frequency."""

    @property
    def off(self) -> dict[str, float]:
        """By how much unknowns may be off: the slope of a straight law of the same size, for each in its unit."""
        if not self.straight:
            return {}
        slope = self.size / float(np.sqrt(np.mean(self.at**2)))
        return {name: abs(factor) * slope for name, factor in self.straight.items()}

    @property
    def size(self) -> float:
        """Root mean square of the law over the places where it is stated."""
        return float(np.sqrt(np.mean(self.amounts**2))) if len(self.amounts) else 0.0

    @property
    def bent(self) -> float:
        """Root mean square of the law less its straight part, which is no part of it: k has that, or c."""
        squares = float(self.at @ self.at)
        straight = self.at * (float(self.at @ self.amounts) / squares if squares else 0.0)
        return replace(self, amounts=self.amounts - straight).size


def together(laws: Sequence[Law]) -> Law:
    """Law with the most evidence for all of them: the mean over the families, which are equally probable before."""
    log_bayes = float(logsumexp([one.log_bayes for one in laws])) - math.log(len(laws))
    return replace(max(laws, key=lambda one: one.log_bayes), log_bayes=log_bayes)


@dataclass(frozen=True)
class Few:
    """What is known of the noise of few readings; parameters of effects beside, and cost that rounding leaves."""

    scarce: Scarce
    ways: float = 0.0
    rounding: float = 0.0


def of_families(line: Line, found: Sequence[Family], kept: Set, few: Few | None = None) -> tuple[list[Law], float]:
    """Law of each family together with some effects of the fit of a line, and χ² without any.

    The other effects of the fit are at their null, by the straight line: a law that has their form can take their place
    without a change of the motion, however large they are.

    Parameters
    ----------
    line : Line
        At the fit.
    found : sequence of Family
        Tried.
    kept : set of str
        Effects of the fit that stay.
    few : Few, optional
        Where the noise is estimated with the rest.
    """
    carried = [one.rows for one in line.columns if one.direction is None and one.effect in kept]
    taken = orthonormal(np.hstack([line.base, *carried]))
    residual = line.residual - taken @ (taken.T @ line.residual)
    laws = [_law(one, one.rows - taken @ (taken.T @ one.rows), residual, (few, line.count)) for one in found]
    return laws, float(residual @ residual)


def _law(one: Family, rows: Array, residual: Array, known: tuple[Few | None, int]) -> Law:
    """Evidence of a family: averaged over its size and length; the amounts are normal (GP on a straight line).

    `known`: of the noise, where it is estimated with the rest, and number of readings.
    """
    few, _ = known
    free = few.scarce.free if few else None
    at = np.array(list(one.direction.values.values()))
    whole = float(residual @ residual) + (few.rounding if few else 0.0)
    if np.linalg.norm(rows) <= RESOLVED * np.linalg.norm(one.rows):
        # The rest of the model can do the same: the readings say nothing of a size.
        return Law(one.direction.effect, -math.inf, at, np.zeros(len(at)), np.zeros(len(at)))
    # Not by products of the rows, which keep half of their digits: the largest sizes see ways of 1e-11 of the largest.
    triangle: Array = np.asarray(np.linalg.qr(np.column_stack([rows, residual]), mode="r"))
    tried = [_sized(root, triangle[:, :-1] @ root, -triangle[:, -1], whole, free) for root in one.roots]
    roots = one.roots
    if one.direction.rough:
        roots = (*roots, np.eye(rows.shape[1]))
        tried.append(_rough(triangle[:, :-1], -triangle[:, -1], whole, known))
    logs = np.concatenate([each.logs for each in tried])
    if not np.isfinite(logs).any():
        return Law(one.direction.effect, -math.inf, at, np.zeros(len(at)), np.zeros(len(at)))
    log_bayes = float(logs.max() + math.log(np.exp(logs - logs.max()).mean()))
    log_bayes -= math.log(max(one.direction.looks, 1.0))
    chosen, amount = max(tried, key=lambda each: float(each.logs.max())), one.direction.amount
    at, ways = one.direction.sums or (at, np.eye(len(at)))
    u = chosen.noise * np.sqrt(np.maximum(np.einsum("hp,pq,hq->h", ways, chosen.spread, ways), 0.0))
    kinds = [_kind(root, each, float(logsumexp(logs))) for root, each in zip(roots, tried, strict=True)]
    return Law(
        one.direction.effect, log_bayes, at, ways @ chosen.mean * amount, u * amount, one.rows,
        tuple(kind for kind in kinds if kind.weight > NEGLIGIBLE), chosen.gone, one.direction.straight,
        one.direction.mimics,
    )  # fmt: skip


def _kind(root: Array, law: _Sized, whole: float) -> Kind:
    """Law of one length with the evidence of all its sizes, in the best of them.

    Larger ones are hardly less probable where little of a law is seen, while what the unknowns can do in its place
    grows with the size: a mean over them would say how large a size was tried.
    """
    best_ = int(np.argmax(law.logs))
    return Kind(math.exp(float(logsumexp(law.logs)) - whole), math.sqrt(law.squares[best_]) * root, law.noise)


@dataclass(frozen=True)
class _Sized:
    """Law of one length: for every size ln evidence, variance beforehand, noise; of the best amounts and covariance.

    Covariance and variance are those over that of the noise. `gone`: χ² that the best explains.
    """

    logs: Array
    squares: Array
    noises: Array
    mean: Array
    spread: Array
    gone: float

    @property
    def noise(self) -> float:
        """Noise with the best."""
        return float(self.noises[int(np.argmax(self.logs))])


def _sized(root: Array, rows: Array, sought: Array, whole: float, free: float | None) -> _Sized:
    """Law of one length in every size: its rows, and what they are to add up to.

    Where the noise is estimated with the rest, the size of the law is in units of it (normal-inverse-gamma prior:
    Bernardo & Smith, Bayesian Theory, 1994, 5.4), and it is what remains with the law.
    """
    left, singular, right = np.linalg.svd(rows)
    values, pull, vectors = np.zeros(root.shape[1]), np.zeros(root.shape[1]), right.T
    values[: len(singular)] = singular**2
    pull[: len(singular)] = singular * (left.T @ sought)[: len(singular)]
    top = float(values.max(initial=0.0))
    if top <= 0:
        none = np.zeros(len(SIZES))
        return _Sized(none - math.inf, none, none + 1.0, np.zeros(len(root)), np.zeros_like(root), 0.0)
    squares = SIZES**2 / top
    gone = np.array([float(np.sum(s * pull**2 / (1 + s * values))) for s in squares])
    gain, noises = 0.5 * gone, np.ones(len(squares))
    if free is not None:
        gain = -0.5 * free * np.log(np.maximum(1.0 - gone / max(whole, 1e-300), 1e-12))
        noises = np.sqrt(np.maximum(whole - gone, 0.0) / max(free, 1))
    logs = gain - np.array([0.5 * float(np.sum(np.log1p(s * values))) for s in squares])
    best_ = int(np.argmax(logs))
    s = float(squares[best_])
    spread = vectors / (1.0 / s + values) @ vectors.T
    mean = root @ (vectors @ (pull * s / (1 + s * values)))
    return _Sized(logs, squares, noises, np.asarray(mean), np.asarray(root @ spread @ root.T), float(gone[best_]))


def _rough(rows: Array, sought: Array, whole: float, known: tuple[Few | None, int]) -> _Sized:
    """Law with any values at its places: as many listed sizes, each as wide as one reading determines it.

    A smooth law pays for its size, listed ones do not (`sets.price`): several of these that together follow any values
    at few places whatever say nothing but that. Its values are as large as those of one size that do best.
    """
    few, count = known
    normal = _sized(np.eye(rows.shape[1]), rows, sought, whole, few.scarce.free if few else None)
    left, singular, _ = np.linalg.svd(rows, full_matrices=False)
    seen = singular > RESOLVED * singular.max()
    gone, many = float(np.sum((left.T @ sought)[seen] ** 2)), float(seen.sum())
    scarce, beside = (few.scarce, few.ways) if few else (None, 0.0)
    gain = log_likelihood(whole - gone, scarce, many + beside) - log_likelihood(whole, scarce, beside)
    best_, same = int(np.argmax(normal.logs)), np.ones(len(SIZES))
    logs = same * (gain - 0.5 * many * math.log(max(count, 2)))
    return replace(normal, logs=logs, squares=normal.squares[best_] * same, noises=normal.noises[best_] * same)


def estimates(line: Line, kept: Set, law: Law) -> tuple[Array, Array]:
    """Change of the unknowns of the base, and their standard uncertainties, with some effects and a law.

    Mean over the lengths of the law by their evidence; u holds what they differ by (Hoeting et al., Statist.
    Sci. 14 (1999) 382, eq. 3 and 4).
    """
    carried = [one.rows for one in line.columns if one.direction is None and one.effect in kept]
    known = np.hstack([line.base, *carried])
    count = line.base.shape[1]
    found = [_estimated(known, law.rows @ kind.root, line.residual) for kind in law.kinds]
    weights = np.array([kind.weight for kind in law.kinds])[:, None] / sum(kind.weight for kind in law.kinds)
    shift = np.array([one[:count] for one, _ in found])
    u = np.array([kind.noise * one[:count] for kind, (_, one) in zip(law.kinds, found, strict=True)])
    mean = np.sum(weights * shift, axis=0)
    return mean, np.sqrt(np.sum(weights * (u**2 + (shift - mean) ** 2), axis=0))


def _estimated(known: Array, law: Array, residual: Array) -> tuple[Array, Array]:
    """Least-squares coefficients, and their standard uncertainties, where those of a law are normal beforehand."""
    ways = law.shape[1]
    rows = np.vstack([np.hstack([known, law]), np.eye(known.shape[1] + ways)[-ways:]])
    size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
    # Not by normal equations, which square what separates a law from the unknowns.
    right = np.concatenate([-residual, np.zeros(ways)])
    return np.linalg.lstsq(rows / size, right, rcond=1e-12)[0] / size, np.sqrt(np.diag(spread(rows)))
