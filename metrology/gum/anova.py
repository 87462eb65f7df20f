"""Type A evaluation of readings in groups: analysis of variance with random effects (JCGM 100:2008, 4.2.8, H.5).

Readings of one day, by one operator, on one mounting share what that day, operator or mounting did to them. The mean of
all is then known by the scatter between the groups, not by that of all readings as if they were independent.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from metrology.errors import Fault, MetrologyError
from metrology.gum.inputs import Floats
from metrology.gum.readings import mean

WITHIN = "within"
ROUNDING = 1e-9
"""Part of the largest factor below which one is zero but for rounding."""


@dataclass(frozen=True)
class Stratum:
    """A source of scatter.

    Parameters
    ----------
    name : str
        Factor, ``a_b`` for the interaction of two, ``within`` for what is left between readings of one group.
    mean_square, dof : float
        Its mean square, and the degrees of freedom of that.
    variance : mapping of str to float
        Its variance as a sum of mean squares, by the factors of these: (MS − MS_below)/n of groups of n readings each.
    """

    name: str
    mean_square: float
    dof: int
    variance: Mapping[str, float]

    @property
    def count(self) -> float:
        """Readings that share one value of it; of groups that differ in size an average."""
        return 1 / self.variance[self.name]

    @property
    def rest(self) -> dict[str, float]:
        """What its mean square is compared with: factors of others that have its expectation if it does nothing."""
        return {name: -part * self.count for name, part in self.variance.items() if name != self.name}


@dataclass(frozen=True)
class Anova:
    """Mean of readings in groups with u and ν, and where the scatter comes from."""

    mean: float
    u: float
    dof: float
    strata: tuple[Stratum, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sources."""
        return tuple(one.name for one in self.strata)

    def __getitem__(self, name: str) -> Stratum:
        """Source by its name."""
        return next(one for one in self.strata if one.name == name)

    def sum(self, parts: Mapping[str, float]) -> tuple[float, float]:
        """Sum of mean squares with these factors, and its degrees of freedom by Satterthwaite."""
        terms = [(part * self[name].mean_square, self[name].dof) for name, part in parts.items()]
        total = sum(term for term, _ in terms)
        squares = sum(term**2 / dof for term, dof in terms)
        return total, total**2 / squares if squares else float(min((dof for _, dof in terms), default=0))

    def s(self, name: str) -> float:
        """Standard deviation by one source; 0 where its mean square is below that of what it is compared with."""
        return sqrt(max(self.sum(self[name].variance)[0], 0.0))

    def test(self, name: str) -> tuple[float, float, float]:
        """F of a source, degrees of freedom of what it is over, and the probability of a greater F by chance alone.

        Exact where each group holds as many readings; else what it is over is a sum with Satterthwaite's.
        """
        from scipy.special import fdtrc

        own = self[name]
        below, dof = self.sum(own.rest)
        if below <= 0:
            return inf, dof, 0.0
        ratio = own.mean_square / below
        return ratio, dof, float(fdtrc(own.dof, dof, ratio))


def nested(readings: Floats, groups: Sequence[Sequence[str]], names: Sequence[str]) -> Anova:
    """Groups within groups: the mean of the means of the outermost ones, u² = s²/J of these, ν = J − 1.

    A mean of a group is that of the means of its own groups. Of groups of one size this is u² = MS/N. Else the means
    differ in variance; s²/J has the variance of their mean as its expectation all the same, and Student's interval
    holds the mean at least as often as it says, for 92 % and more.

    No test decides whether the groups are pooled: an interval after such a decision holds less often than it says.

    Parameters
    ----------
    readings : ndarray, shape (N,)
        In SI.
    groups : sequence of sequence of str, each of length N
        Label of each reading for each factor, the outermost first; a label means something within its group only.
    names : sequence of str
        Of the factors.

    Returns
    -------
    Anova
        Mean, its u and degrees of freedom, and the strata with their mean squares.

    Raises
    ------
    MetrologyError
        For fewer than two groups, and for factors that leave no scatter within.

    Notes
    -----
    JCGM 100:2008 H.5.2; Searle, Casella & McCulloch, Variance Components (1992), ch. 5 (sums of squares in turn);
    Bakirov & Székely, J. Math. Sci. 139 (2006) 6497 (Student's t of unequal variances).
    """
    number = len(readings)
    keys = [_numbered(zip(*groups[: level + 1], strict=True)) for level in range(len(groups))]
    keys = [np.zeros(number, dtype=int), *keys, np.arange(number)]
    levels = [int(key.max()) + 1 for key in keys]
    dofs = [inner - outer for outer, inner in pairwise(levels)]
    _check(dofs, (*names, WITHIN))
    parted = [_means(readings - mean(readings), key)[key] for key in keys]
    squares = [float(((inner - outer) ** 2).sum()) for outer, inner in pairwise(parted)]
    # What a unit variance of a source adds to the squares of the means of each level: Σ n²/N of its groups in those.
    sizes = [np.bincount(key)[key] for key in keys]
    added = [[min(float((own / of).sum()), number) for own in sizes[1:]] for of in sizes]
    strata = _strata((*names, WITHIN), squares, dofs, np.diff(added, axis=0))
    for outer, inner in reversed(list(pairwise(keys[1:]))):
        parents = np.empty(int(inner.max()) + 1, dtype=int)
        parents[inner] = outer
        readings = _means(readings, parents)
    return Anova(mean(readings), float(readings.std(ddof=1)) / sqrt(levels[1]), float(dofs[0]), strata)


def crossed(readings: Floats, groups: Sequence[Sequence[str]], names: Sequence[str]) -> Anova:
    """Two factors, levels of one met by levels of the other: the mean over all combinations of both.

    u² is the sum of the variances of the factors, of their interaction and of the readings within, each by what it adds
    to that mean; the degrees of freedom are those of Satterthwaite. Where neither factor adds to the interaction it
    counts alone. Without repeated readings the interaction is what is within. Where each combination has as many
    readings, u² = (MS_a + MS_b − MS_ab)/N; the mean takes a combination without readings as the sum of what its two
    levels do.

    Parameters
    ----------
    readings : ndarray, shape (N,)
        In SI.
    groups : sequence of two sequences of str, each of length N
        Label of each reading for each factor.
    names : sequence of str
        Of the two factors.

    Returns
    -------
    Anova
        Mean, its u and degrees of freedom, and the strata with their mean squares.

    Raises
    ------
    MetrologyError
        Other than two factors, too few combinations with readings, and parts of them that share no level.

    Notes
    -----
    Searle, Casella & McCulloch, Variance Components (1992), 4.3, 5.5 (Henderson's method III), 5.7; ISO 5725-3:2023.
    """
    if len(groups) != 2:
        raise MetrologyError(Fault("crossed", f"{len(groups)} factors", "two factors"))
    a, b, cell = (_numbered(key) for key in (*groups, zip(*groups, strict=True)))
    first, count = np.unique(cell, return_index=True)[1], np.bincount(cell)
    sides = [np.eye(int(key.max()) + 1)[key[first]] for key in (a, b)]
    both, centre = np.hstack(sides), mean(readings)
    means = _means(readings - centre, cell)
    dofs = [*(side.shape[1] - 1 for side in sides), len(count) - both.shape[1] + 1]
    _check(dofs, names)
    _check_cells(both, dofs, names)
    rows = _crossed_squares(means, count, sides)
    # The mean over all combinations, by an additive fit to the means of those that have readings.
    even = np.concatenate([np.full(side.shape[1], 1 / side.shape[1]) for side in sides])
    weights = even @ np.linalg.pinv(both)
    shares = [*(1 / side.shape[1] for side in sides), float(weights @ weights), float(weights @ (weights / count))]
    sources = [*names, "_".join(names), WITHIN]
    if len(readings) > len(count):
        dofs.append(len(readings) - len(count))
        rows = np.vstack([rows, [((readings - centre - means[cell]) ** 2).sum(), 0.0, 0.0, 0.0, dofs[-1]]])
    else:
        rows = np.delete(rows, 3, axis=1)
        del shares[2], sources[2]
    strata = _strata(sources, rows[:, 0].tolist(), dofs, rows[:, 1:])
    return _combined(centre + float(weights @ means), strata, shares)


def _crossed_squares(means: Floats, count: NDArray[np.int64], sides: Sequence[Floats]) -> Floats:
    """Sums of squares of each factor given the other, and of their interaction given both, shape (3, 5).

    Each row has the squares of the means, and those that unit variances of the factors, of the combinations and of the
    readings add to them: yᵀQy and tr(Q·ZZᵀ) of one projection Q, over combinations weighed by their readings.
    """
    root, number = np.sqrt(count)[:, None], float(count.sum())
    seen = root[:, 0] * means

    def explained(side: Floats) -> tuple[Floats, Floats]:
        basis = _basis(root * side)
        traces = [float(((basis.T @ (root * factor)) ** 2).sum()) for factor in sides]
        return basis @ (basis.T @ seen), np.array([*traces, float(((basis * root) ** 2).sum()), basis.shape[1]])

    both = explained(np.hstack(sides))
    pairs = [(both, explained(side)) for side in sides[::-1]]
    pairs.append(((seen, np.array([number, number, number, len(count)])), both))
    # Of differences: what a difference of squares would lose of a small interaction.
    return np.array([[((more - less) ** 2).sum(), *(wide - narrow)] for (more, wide), (less, narrow) in pairs])


def _combined(centre: float, strata: tuple[Stratum, ...], shares: Sequence[float]) -> Anova:
    """Mean with u² = Σ share·variance, without the factors where they add nothing, at least by what is within."""
    found = Anova(centre, 0.0, 0.0, strata)
    pairs = list(zip(strata, shares, strict=True))
    by_factors = sum(share * found.sum(one.variance)[0] for one, share in pairs[:2])
    chosen = [pairs] * (by_factors > 0) + [pairs[2:], pairs[-1:]]
    for each in chosen:
        parts = {name: sum(share * one.variance.get(name, 0.0) for one, share in each) for name in found.names}
        variance, dof = found.sum(_without_rounding(parts))
        if variance > 0:
            break
    return replace(found, u=sqrt(max(variance, 0.0)), dof=dof)


def _strata(names: Sequence[str], squares: Sequence[float], dofs: Sequence[int], traces: Floats) -> tuple[Stratum, ...]:
    """Mean squares with the variances that they tell: their expectations are traces/ν times the variances."""
    inverse = np.linalg.inv(traces / np.array(dofs)[:, None])
    return tuple(
        Stratum(name, square / dof, dof, _without_rounding(dict(zip(names, row, strict=True))))
        for name, square, dof, row in zip(names, squares, dofs, inverse.tolist(), strict=True)
    )


def _without_rounding(parts: Mapping[str, float]) -> dict[str, float]:
    largest = max(map(abs, parts.values()))
    return {name: part for name, part in parts.items() if abs(part) > ROUNDING * largest}


def _numbered(keys: Iterable[object]) -> NDArray[np.int64]:
    """Number of its group for each reading, in the order in which they come."""
    listed = list(keys)
    order = {key: number for number, key in enumerate(dict.fromkeys(listed))}
    return np.array([order[key] for key in listed], dtype=np.int64)


def _means(values: Floats, key: NDArray[np.int64]) -> Floats:
    """Mean of each group."""
    return np.asarray(np.bincount(key, values) / np.bincount(key))


def _basis(columns: Floats) -> Floats:
    """Orthonormal basis of what columns span."""
    left, size, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, size > ROUNDING * size[0]])


def _check(dofs: Sequence[int], names: Sequence[str]) -> None:
    """Refuse sources without degrees of freedom."""
    for dof, name, outer in zip(dofs, names, ("", *names), strict=False):
        if dof < 1 and name == WITHIN:
            fix = f"leave '{outer}' out: the readings themselves are its groups"
            raise MetrologyError(Fault(outer, "one reading in each group", "two or more, which scatter", fix))
        if dof < 1:
            raise MetrologyError(Fault(name, "one group", "two groups or more, which can differ"))


def _check_cells(both: Floats, dofs: Sequence[int], names: Sequence[str]) -> None:
    """Refuse combinations that do not tell the levels of the factors from one another, or leave no scatter."""
    levels = [dof + 1 for dof in dofs[:2]]
    got = f"{len(both)} of the {levels[0] * levels[1]} combinations of {names[0]} and {names[1]}"
    fix = "or state the factors as 'nested'"
    if np.linalg.matrix_rank(both) < sum(levels) - 1:
        expected = "readings such that each level is compared with each other, over levels of the other factor"
        raise MetrologyError(Fault("crossed", got, expected, fix))
    if dofs[2] < 1:
        raise MetrologyError(Fault("crossed", got, f"readings of {sum(levels)} or more", fix))
