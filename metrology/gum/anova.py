"""Type A evaluation of readings in groups: analysis of variance with random effects (JCGM 100:2008, 4.2.8, H.5).

Readings of one day, by one operator, on one mounting share what that day, operator or mounting did to them. The mean of
all is then known by the scatter between the groups, not by that of all readings as if they were independent.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.inputs import Floats
from metrology.gum.readings import mean

WITHIN = "within"


@dataclass(frozen=True)
class Stratum:
    """A source of scatter.

    Parameters
    ----------
    name : str
        Factor, ``a_b`` for the interaction of two, ``within`` for what is left between readings of one group.
    mean_square, dof : float
        Its mean square, and the degrees of freedom of that.
    below : str
        Source whose mean square it is compared with: it has the same expectation where this source does nothing.
    count : int
        Readings that share one value of it: mean square − that of `below` is `count` times its variance.
    """

    name: str
    mean_square: float
    dof: int
    below: str = ""
    count: int = 1


@dataclass(frozen=True)
class Anova:
    """Mean of balanced readings in groups with u and ν, and where the scatter comes from.

    `dof` is exact for groups within groups, and that of Satterthwaite for crossed factors.
    """

    mean: float
    u: float
    dof: float
    strata: tuple[Stratum, ...]

    def __getitem__(self, name: str) -> Stratum:
        """Source by its name."""
        return next(one for one in self.strata if one.name == name)

    def s(self, name: str) -> float:
        """Standard deviation by one source; 0 where its mean square is below that of what it is compared with."""
        own = self[name]
        rest = self[own.below].mean_square if own.below else 0.0
        return sqrt(max(own.mean_square - rest, 0.0) / own.count)

    def test(self, name: str) -> tuple[float, float]:
        """F of a source, and the probability of a greater one where the source does nothing."""
        from scipy.special import fdtrc

        own = self[name]
        below = self[own.below]
        if below.mean_square == 0:
            return float("inf"), 0.0
        ratio = own.mean_square / below.mean_square
        return ratio, float(fdtrc(own.dof, below.dof, ratio))


def nested(readings: Floats, groups: Sequence[Sequence[str]], names: Sequence[str]) -> Anova:
    """Groups within groups: u²(mean) = MS/N of the outermost, with its J − 1 degrees of freedom.

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
        For fewer than two groups, for groups of different size, and for factors that leave no scatter within.

    Notes
    -----
    JCGM 100:2008 H.5.2.
    """
    keys = [list(zip(*groups[: level + 1], strict=True)) for level in range(len(groups))]
    sizes = [_size(key, name) for key, name in zip(keys, names, strict=True)]
    centre, strata, before = mean(readings), list[Stratum](), 1
    parted: Floats = readings - centre
    above: Floats = np.zeros_like(parted)
    for name, key, size, below in zip(names, keys, sizes, (*names[1:], WITHIN), strict=True):
        effect, number = _means(parted, key), len(readings) // size
        strata.append(Stratum(name, _square(effect - above, number - before, name), number - before, below, size))
        above, before = effect, number
    strata.append(_within(parted - above, len(readings) - before, names))
    top = strata[0]
    return Anova(centre, sqrt(top.mean_square / len(readings)), float(top.dof), tuple(strata))


def crossed(readings: Floats, groups: Sequence[Sequence[str]], names: Sequence[str]) -> Anova:
    """Two factors, each level of one met by each of the other: u²(mean) = (MS_a + MS_b − MS_ab)/N.

    The degrees of freedom are those of Satterthwaite; where neither factor adds to the interaction it is MS_ab/N.
    Without repeated readings the interaction is what is within.

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
        Other than two factors, a combination without readings, or numbers of readings that differ.

    Notes
    -----
    Searle, Casella & McCulloch, Variance Components (1992), 4.3, 5.7; ISO 5725-3:2023.
    """
    if len(groups) != 2:
        raise MetrologyError(Fault("crossed", f"{len(groups)} factors", "two factors"))
    cells = list(zip(*groups, strict=True))
    a, b = (len(set(group)) for group in groups)
    repeats = _size(cells, "_".join(names))
    if len(set(cells)) != a * b:
        got = f"{len(set(cells))} of the {a * b} combinations of {names[0]} and {names[1]}"
        raise MetrologyError(Fault("crossed", got, "readings of all of them", "or state the factors as 'nested'"))
    centre = mean(readings)
    parted = readings - centre
    by_a, by_b, by_cell = _means(parted, groups[0]), _means(parted, groups[1]), _means(parted, cells)
    both = (a - 1) * (b - 1)
    middle = "_".join(names) if repeats > 1 else WITHIN
    strata = [
        Stratum(names[0], _square(by_a, a - 1, names[0]), a - 1, middle, b * repeats),
        Stratum(names[1], _square(by_b, b - 1, names[1]), b - 1, middle, a * repeats),
        Stratum(
            middle, _square(by_cell - by_a - by_b, both, middle), both, WITHIN if repeats > 1 else "", repeats
        ),
    ]  # fmt: skip
    if repeats > 1:
        strata.append(_within(parted - by_cell, len(readings) - a * b, names))
    first, second, joint = strata[:3]
    variance = first.mean_square + second.mean_square - joint.mean_square
    if variance <= joint.mean_square:
        return Anova(centre, sqrt(joint.mean_square / len(readings)), float(both), tuple(strata))
    dof = variance**2 / sum(one.mean_square**2 / one.dof for one in (first, second, joint))
    return Anova(centre, sqrt(variance / len(readings)), dof, tuple(strata))


def _size(keys: Sequence[object], name: str) -> int:
    """Readings of each group, which has to be one number."""
    counts = Counter(keys)
    if len(set(counts.values())) != 1:
        got = f"groups of {min(counts.values())} to {max(counts.values())} readings"
        fix = "leave out readings with a reason, or give the means of the groups as readings"
        raise MetrologyError(Fault(name, got, "as many readings in each group", fix))
    return next(iter(counts.values()))


def _means(readings: Floats, keys: Sequence[object]) -> Floats:
    """Mean of its group for each reading."""
    order = {key: index for index, key in enumerate(dict.fromkeys(keys))}
    index = np.array([order[key] for key in keys])
    return np.asarray((np.bincount(index, readings) / np.bincount(index))[index])


def _square(effect: Floats, dof: int, name: str) -> float:
    if dof < 1:
        raise MetrologyError(Fault(name, "one group", "two groups or more, which can differ"))
    return float(effect @ effect) / dof


def _within(left: Floats, dof: int, names: Sequence[str]) -> Stratum:
    if dof < 1:
        fix = f"leave '{names[-1]}' out: the readings themselves are its groups"
        raise MetrologyError(Fault(names[-1], "one reading in each group", "two or more, which scatter", fix))
    return Stratum(WITHIN, float(left @ left) / dof, dof)
