"""Checks of readings that are taken as independent: those of one quantity, and the points of a fit (JCGM 100, 4.2.1).

s/√n and the covariance of a fit hold for independent readings alone. Copies, held readings, a range that ends and a
drift make them too small, or nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import lgamma, log, sqrt
from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.special import betainc, chdtr, fdtrc, gammaln, ndtr
from scipy.stats import rankdata

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
PLACES = 16
"""Places at most at which another range is looked for: between two of them lies a sixteenth of half of all points."""
LARGE = 3 / 0.6745
"""Three standard deviations over the median of the errors, of normal ones."""
DRAWS = 20_000
"""Draws of the ratio: twenty below `CHANCE`."""


def faults(values: Any) -> Iterator[str]:
    """What forbids that readings are taken as independent ones of one quantity, in words."""
    value = np.asarray(values, dtype=float)
    if not np.ptp(value):
        return
    yield from copied(value)
    count, p = apart(value)
    if p < CHANCE:
        text = (
            "{count} of {whole} readings are apart from the others ({p:figures}), as of another range, unit or "
            "specimen: their mean is of neither"
        )
        yield said(text, count=count, whole=len(value), p=_p(p))
    p = ordered(value - value.mean(), np.ones((len(value), 1)))
    if p < CHANCE:
        text = (
            "neighbouring readings are alike ({p:figures}), as of a drift, a step or an order by size: s/√n is too "
            "small for them"
        )
        yield said(text, p=_p(p))


def copied(values: Any) -> Iterator[str]:
    """Readings that stand for others: held, at the end of a range, or once more; in words."""
    value = np.asarray(values, dtype=float)
    held = updated(value)
    if held > 1:
        yield said("each of the readings stands {count} times in a row", count=held)
        return
    if count := _alike(np.sort(value)):
        text = "{count} of {whole} readings are the same: held, or at the end of the range"
        yield said(text, count=count, whole=len(value))
        return
    if length := _twice(value):
        yield said("a stretch of {count} readings is among them more than once", count=length)
    elif _evenly(value):
        levels = len(np.unique(value))
        yield said("all {whole} readings are copies of {count}, in another order", whole=len(value), count=levels)


def points(x: Any, y: Any, residuals: Any, design: Any, u: Any) -> Iterator[str]:
    """What forbids that the scatter of points about a fit is a measure of its uncertainty, in words.

    Parameters
    ----------
    x, y, residuals : array_like, shape (n,)
        Points, and y less the fit.
    design : array_like, shape (n, p)
        Derivatives of the fit by its parameters.
    u : array_like, shape (n,)
        Standard uncertainty of the points; alike for all where none is stated.
    """
    x, y, u = (np.asarray(data, dtype=float) for data in (x, y, u))
    rest = np.asarray(residuals, dtype=float) / u
    rows = np.unique(np.stack([x, y], axis=1), axis=0, return_inverse=True)[1].ravel().astype(float)
    if length := _twice(rows):
        yield said("a stretch of {count} points is among them more than once", count=length)
        return
    order = np.argsort(x, kind="stable")
    rest, derivatives = rest[order], (np.asarray(design, dtype=float) / u[:, None])[order]
    x, u = x[order], u[order]
    tried = (ordered(rest, derivatives), bent(x, rest, derivatives, u), repeated(x, rest, derivatives))
    p = min(1.0, len(tried) * min(tried))
    if p < CHANCE:
        text = (
            "residuals of neighbouring points are alike ({p:figures}): the points do not follow the model, and their "
            "scatter about it says too little of u"
        )
        yield said(text, p=_p(p))
        return
    p = periodic(rest, len(derivatives.T))
    if p < CHANCE:
        text = (
            "the residuals are a periodic function of x ({p:figures}): the points do not follow the model, or the fit "
            "did not end at its best values; begin from others"
        )
        yield said(text, p=_p(p))


def _p(p: float) -> str:
    chance = probability(p)
    return f"p {chance}" if chance.startswith("<") else f"p = {chance}"


def ordered(residuals: Floats, design: Floats) -> float:
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
    basis = np.linalg.qr(design)[0]
    drawn = np.random.default_rng(0).standard_normal((DRAWS, n))
    drawn -= (drawn @ basis) @ basis.T
    ratios = np.square(np.diff(drawn, axis=1)).sum(axis=1) / np.square(drawn).sum(axis=1)
    return float((np.count_nonzero(ratios <= ratio) + 1) / (DRAWS + 1))


def bent(x: Floats, residuals: Floats, design: Floats, u: Floats) -> float:
    """Upper limit of the probability that residuals follow further terms in x so well by chance.

    Of one or two higher polynomials of its rank, and of other parameters from one of the middle points on, as of another range, the
    least probable by the ratio of variances of independent normal errors (F), times their number (Bonferroni). Of few
    points these tell what their order does not. `x` in order. Sources: N. R. Draper, H. Smith, Applied Regression
    Analysis, 3rd ed. (1998), 6.1; G. C. Chow, Econometrica 28 (1960) 591.
    """
    n, p = design.shape
    # By rank: of x itself a point far out would decide alone.
    away = 2 * (rankdata(x) - 1) / (n - 1) - 1
    higher = np.polynomial.legendre.legvander(away, p + 1)[:, p:] / u[:, None]
    first = max(p + 1, n // 4)
    places = np.flatnonzero(np.diff(x) > 0.0) + 1
    places = places[(places >= first) & (places <= n - first)]
    places = places[np.unique(np.linspace(0, len(places) - 1, PLACES).astype(int))] if len(places) else places
    basis = np.linalg.qr(design)[0]
    found = [_followed(residuals, basis, terms) for terms in (higher[:, :1], higher)]
    # Of a few large errors some place makes another range: they count as three times the usual one.
    usual = LARGE * float(np.median(np.abs(residuals)))
    cut = np.clip(residuals, -usual, usual)
    cut -= basis @ (basis.T @ cut)
    for at in places:
        later = np.where(np.arange(n)[:, None] >= at, design, 0.0)
        found.append(max(_followed(residuals, basis, later), _followed(cut, basis, later)))
    return min(1.0, len(found) * min(found))


def _followed(residuals: Floats, basis: Floats, terms: Floats) -> float:
    """Probability that residuals of a fit with an orthonormal basis follow further terms so well by chance."""
    left = terms - basis @ (basis.T @ terms)
    left -= basis @ (basis.T @ left)
    turned, sizes, _ = qr(left, mode="economic", pivoting=True)
    # What few levels of x leave of a term is rounding.
    new = np.abs(np.diag(sizes)) > SAME * np.linalg.norm(terms)
    count, gone = int(new.sum()), float(np.square(turned.T @ residuals)[new].sum())
    free = len(residuals) - basis.shape[1] - count
    if not count or free < 1:
        return 1.0
    return _ratio(gone, count, max(float(residuals @ residuals) - gone, 0.0), free)


def repeated(x: Floats, residuals: Floats, design: Floats) -> float:
    """Probability that points at one x scatter so little about their mean, for how far the means are off the fit.

    By the ratio of variances of independent normal errors (F). Source: as of `bent`, 2.1.
    """
    levels, of = np.unique(x, return_inverse=True)
    count = np.bincount(of)
    within = float(np.square(residuals - (np.bincount(of, residuals) / count)[of]).sum())
    lacking, free = len(levels) - int(np.linalg.matrix_rank(design)), len(x) - len(levels)
    if lacking < 1 or free < 1:
        return 1.0
    return _ratio(float(residuals @ residuals) - within, lacking, within, free)


def _ratio(gone: float, count: int, left: float, dof: int) -> float:
    """Probability of so large a ratio of two variances, by their sums of squares and degrees of freedom."""
    return float(fdtrc(count, dof, gone / count * dof / left)) if left > 0.0 else float(gone <= 0.0)


def periodic(residuals: Floats, taken: int) -> float:
    """Upper limit of the probability of so strong a line in the spectrum of residuals in the order of x, by chance.

    Of m ordinates of a periodogram of independent normal errors the largest is at least a part g of their sum with the
    probability m·(1 − g)^(m − 1) at most; here of twice as many frequencies, so that one between two is seen, and of m
    less the `taken` parameters of the fit. Source: R. A. Fisher, Proc. R. Soc. A 125 (1929) 54.
    """
    n = len(residuals)
    left, square = (n - 1) // 2 - taken, float(residuals @ residuals)
    if left < 2 or not square > 0.0:
        return 1.0
    power = np.square(np.abs(np.fft.rfft(residuals, 2 * n)[2:n])) * 2 / (n * square)
    return float(min(1.0, len(power) * max(0.0, 1.0 - float(power.max())) ** (left - 1)))


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


def _alike(value: Floats) -> int:
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


def _twice(value: Floats) -> int:
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
