"""Checks of readings of one quantity that are taken as independent (JCGM 100, 4.2.1).

s/√n holds for independent readings alone. Copies, held readings, a range that ends and a drift make it too small, or
nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import lgamma, log, sqrt
from typing import Any

import numpy as np
from scipy.special import betainc, chdtr, gammaln, ndtr

from metrology.gum.printed_probability import probability
from metrology.message import said
from metrology.raw import CHANCE, JUMP, SAME, again, divisor, updated
from metrology.timeseries import Floats

RARE = 1e-6
"""Probability below which equal readings are no chance: fewer than one sound record of a million, as of raw records."""
BLOCK = 3
"""Readings of the shortest stretch, and of the fewest at one level, that are taken for copies."""
FEWEST = 7
"""Readings, or points and one less for each further parameter, from which on their order can tell: 1/7! < `CHANCE`."""
MOST = 200
"""Readings up to which the ratio of von Neumann is compared with draws; beyond it is normal."""
DRAWS = 20_000
"""Draws of the ratio: twenty below `CHANCE`."""


def faults(values: Any, *, resolved: float = 0.0) -> Iterator[str]:
    """What forbids that readings are taken as independent ones of one quantity, in words.

    `resolved`: standard uncertainty that is stated beside their scatter.
    """
    value = np.asarray(values, dtype=float)
    yield from _each(value, resolved)
    if not np.ptp(value):
        return
    count, p = apart(value)
    if p < CHANCE:
        text = (
            "{count} of {whole} readings are apart from the others ({p:figures}), as of another range, unit or "
            "specimen: their mean is of neither"
        )
        yield said(text, count=count, whole=len(value), p=shown(p))
    p = ordered(value - value.mean(), np.ones((len(value), 1)))
    if p < CHANCE:
        text = (
            "neighbouring readings are alike ({p:figures}), as of a drift, a step or an order by size: s/√n is too "
            "small for them"
        )
        yield said(text, p=shown(p))


def grouped(values: Any, cells: Any, *, resolved: float = 0.0) -> Iterator[str]:
    """What forbids that readings in groups are taken as independent ones within each, in words.

    `cells`: group of each reading, shape (n,); `resolved` as of `faults`.
    """
    value = np.asarray(values, dtype=float)
    yield from _each(value, resolved)
    if not np.ptp(value):
        return
    of = np.unique(np.asarray(cells), return_inverse=True)[1]
    p = ordered(about_means(value, of), of[:, None] == np.arange(of.max() + 1))
    if p < CHANCE:
        text = (
            "readings that follow each other differ alike from the means of their groups ({p:figures}), as of a drift "
            "or a step: the scatter of the groups says too little of it"
        )
        yield said(text, p=shown(p))


def about_means(values: Floats, of: Any) -> Floats:
    """Values less the mean of their group; `of`: number of the group of each, shape (n,)."""
    means = np.bincount(of, values) / np.bincount(of)
    return np.asarray(values - means[of])


def _each(value: Floats, resolved: float) -> Iterator[str]:
    """Say of readings, whatever their order, that they stand for others, or that rounding is not in their scatter."""
    if np.ptp(value):
        yield from copied(value)
        yield from _coarse(value, resolved)
    elif not resolved:
        yield said("all {count} readings are alike, and no resolution of them is stated", count=len(value))


def _coarse(value: Floats, resolved: float) -> Iterator[str]:
    """Say of readings in steps twice as large as their scatter, or larger, that rounding is no part of s/√n.

    Of errors of half a step and more the mean of rounded readings is that of the readings to 0.3 % of the step, and
    their variance larger by step²/12 (B. Widrow, I. Kollár, Quantization Noise (2008), 4.3); of smaller errors it is as
    wrong as a single one may be.
    """
    step = divisor(np.diff(np.unique(value)))
    before = float(value.var(ddof=1)) - step**2 / 12
    if before < (1 - SAME) * step**2 / 4 and resolved < 0.99 * step / sqrt(12):
        text = (
            "the readings scatter by less than half of their step, {step:.3g} in SI: rounding does not average out, "
            "state the resolution"
        )
        yield said(text, step=step)


def copied(values: Any) -> Iterator[str]:
    """Readings that stand for others: held, at the end of a range, or once more; in words."""
    value = np.asarray(values, dtype=float)
    held = updated(value)
    if held > 1:
        yield said("each of the readings stands {count} times in a row", count=held)
        return
    if count := alike(np.sort(value)):
        text = "{count} of {whole} readings are the same: held, or at the end of the range"
        yield said(text, count=count, whole=len(value))
        return
    if length := twice(value):
        yield said("a stretch of {count} readings is among them more than once", count=length)
    elif _evenly(value):
        levels = len(np.unique(value))
        yield said("all {whole} readings are copies of {count}, in another order", whole=len(value), count=levels)


def shown(p: float) -> str:
    """A probability in words that follow a statement."""
    chance = probability(p)
    return f"p {chance}" if chance.startswith("<") else f"p = {chance}"


def ordered(residuals: Floats, design: Any) -> float:
    """Probability of so small a ratio of von Neumann, Σ(r_i − r_(i−1))²/Σ r², by chance.

    Of residuals of a fit to n points with independent normal errors: by draws of these, from which what the fit takes
    up is removed. Sources: J. von Neumann, Ann. Math. Stat. 12 (1941) 367; J. Durbin, G. S. Watson, Biometrika 37
    (1950) 409.
    """
    n, p = design.shape
    square = float(residuals @ residuals)
    if n < FEWEST + p - 1 or not square > 0.0:
        return 1.0
    ratio = float(np.square(np.diff(residuals)).sum()) / square
    if n > MOST:
        return float(ndtr((ratio - 2.0) * sqrt(n) / 2.0))
    basis = np.linalg.qr(design.astype(float))[0]
    drawn = np.random.default_rng(0).standard_normal((DRAWS, n))
    drawn -= (drawn @ basis) @ basis.T
    ratios = np.square(np.diff(drawn, axis=1)).sum(axis=1) / np.square(drawn).sum(axis=1)
    return float((np.count_nonzero(ratios <= ratio) + 1) / (DRAWS + 1))


def apart(values: Floats) -> tuple[int, float]:
    """Number of readings that stand apart from the others, and an upper limit of the probability of that by chance.

    The density of readings of one quantity has one peak and falls on either side of it, however heavy its tails are. On
    the side of a gap that has no peak, of m readings within a width w none lies in the gap L before them: with a
    density that does not rise towards them, that has the probability (w/(w + L))^(m - 1) at most, the nearest one
    given. The peak may be on either side; all gaps are looked at, each with all readings beyond it, half of them, and
    so on.
    """
    value = np.sort(values)
    n, step = len(value), _step(value)
    if not step > 0.0:
        return 0, 1.0
    rare = np.maximum(_beyond(value, step), _beyond(-value[::-1], step)[::-1])
    at = int(rare.argmin())
    return min(at + 1, n - at - 1), float(min(1.0, np.exp(rare[at]) * n * np.log2(n)))


def _beyond(value: Floats, step: float) -> Floats:
    """Logarithm of the least of these probabilities, for the readings above each gap of sorted readings."""
    # What is rounded fills its step.
    gaps = np.maximum(np.diff(value) - step, 0.0)
    first, count = np.arange(1, len(value)), np.arange(len(value) - 1, 0, -1)
    least = np.zeros(len(gaps))
    while count.max() > 1:
        width = value[first + count - 1] - value[first] + step
        least = np.minimum(least, (count - 1) * np.log(width / (width + gaps)))
        count = np.maximum(count // 2, 1)
    return least


def _step(value: Floats) -> float:
    """Step of which all readings are multiples; without any, what rounding of their file cannot distinguish."""
    steps = np.diff(np.unique(value))
    least = SAME * float(steps.max(initial=0.0))
    return divisor(steps[steps > least]) or least


def alike(value: Floats) -> int:
    """Sorted readings at the level that most of them have, where so many are no chance; else none.

    In one step of the readings lies at most the share step/(width of the densest half of all others); where that is a
    third or more, noise does not exceed the last digit. No level may have nearly as many, as where the readings have
    few values by nature; of the two ends of a range that are cut off only one is compared.
    """
    levels, counts = np.unique(value, return_counts=True)
    count, level = int(counts.max()), float(levels[counts.argmax()])
    others = value[value != level]
    half = len(others) // 2 + 1
    if count < BLOCK or half > len(others):
        return 0
    step = _step(others)
    width = float((others[half - 1 :] - others[: len(others) - half + 1]).min())
    if width <= JUMP * step:
        return 0
    ends = {levels[0], levels[-1]} if level in (levels[0], levels[-1]) else {level}
    second = int(counts[~np.isin(levels, list(ends))].max(initial=0))
    choices = lgamma(len(value) + 1) - lgamma(count + 1) - lgamma(len(value) - count + 1)
    rare = choices + (count - 1) * log(step / width) < log(RARE)
    # Where no two of the others are equal, two readings are equal with less than one over their pairs.
    alone = second == 1 and choices - (count - 1) * log(len(others) * (len(others) - 1) / 2) < log(CHANCE)
    return count if rare and (alone or len(levels) * float(betainc(count, second + 1, 0.5)) < CHANCE) else 0


def _evenly(value: Floats) -> bool:
    """Whether each reading is there as often as any other, as of copies in another order, where that is no chance.

    Numbers of independent readings at D levels are nowhere more even than of levels that are equally probable: by
    their multinomial probability, and by χ² where a copy or two are lacking.
    """
    counts = np.unique(value, return_counts=True)[1].astype(float)
    if counts.min() < 2:
        return False
    n, levels = len(value), len(counts)
    mean = n / levels
    even = np.floor((n + np.arange(levels)) / levels)
    most = lgamma(n + 1) - float(gammaln(even + 1).sum()) - n * log(levels)
    spread = float(np.square(counts - mean).sum()) / mean
    return max(most, log(max(float(chdtr(levels - 1, spread)), 1e-300))) < log(RARE)


def twice(value: Floats) -> int:
    """Length of the longest stretch that is among the readings twice, where it is no chance; else 0.

    Two readings are equal with a probability p that all pairs of them tell, but for those of the stretch itself; among
    n²/2 pairs of places n²/2·p^L agree in L readings in a row.
    """
    n, counts = len(value), np.unique(value, return_counts=True)[1].astype(float)
    pairs, whole = float((counts * (counts - 1)).sum()) / 2, n * (n - 1) / 2
    for length in range(BLOCK, n // 2 + 1):
        share = (max(pairs - length, 0.0) + 1.0) / whole
        if share >= 1.0 or length > MOST:
            return 0
        if log(whole) + length * log(share) < log(RARE):
            return again(value, length)
    return 0
