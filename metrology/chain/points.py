"""Checks of the points of a fit: that they are independent, and follow its line or curve (JCGM 100, 4.2.1)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.linalg import qr
from scipy.special import fdtrc
from scipy.stats import rankdata

from metrology.chain.independence import BLOCK, about_means, alike, ordered, shown, twice
from metrology.gum.rounding import readable
from metrology.message import said
from metrology.raw import CHANCE, SAME, divisor
from metrology.timeseries import Floats

ALONE = 1 - 1 / 16
"""Diagonal element h of the hat matrix beyond which an error e of a point that moves the fit there by 4 u, e = 4·s, is
off it by less than its standard deviation: its residual is e·(1 − h), which scatters by s·√(1 − h)."""
LARGE = 3 / 0.6745
"""Three standard deviations over the median of the errors, of normal ones."""
PLACES = 16
"""Places at most at which another range is looked for: between two of them lies a sixteenth of half of all points."""


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
    if length := twice(rows):
        yield said("a stretch of {count} points is among them more than once", count=length)
        return
    derivatives = np.asarray(design, dtype=float) / u[:, None]
    # As they were taken, too: a drift, or a day with an offset of its own, does not go by x.
    tried = [ordered(rest, derivatives)]
    order = np.argsort(x, kind="stable")
    levels = np.split(y[order], np.flatnonzero(np.diff(x[order])) + 1)
    if counts := [(alike(np.sort(level)), len(level)) for level in levels if len(level) > BLOCK]:
        count, whole = max(counts)
        if count:
            text = "{count} of {whole} points at one x are the same: held, or at the end of the range"
            yield said(text, count=count, whole=whole)
            return
    rest, derivatives, x, u = rest[order], derivatives[order], x[order], u[order]
    tried += [ordered(rest, derivatives), bent(x, rest, derivatives, u), repeated(x, rest, derivatives)]
    p = min(1.0, len(tried) * min(tried))
    if p < CHANCE:
        text = (
            "residuals of neighbouring points are alike ({p:figures}): the points do not follow the model, or are not "
            "independent, and u is too small"
        )
        yield said(text, p=shown(p))
        return
    p = periodic(rest, len(derivatives.T))
    if p < CHANCE:
        text = (
            "the residuals are a periodic function of x ({p:figures}): the points do not follow the model, or the fit "
            "did not end at its best values; begin from others"
        )
        yield said(text, p=shown(p))


def scattered(x: Any, y: Any, residuals: Any, design: Any, units: tuple[str, str]) -> Iterator[str]:
    """What forbids that the scatter of points alone is their uncertainty, in words; arguments as of `points`.

    `units`: SI units of x and y.
    """
    x, y, rest = (np.asarray(data, dtype=float) for data in (x, y, residuals))
    n, p = np.shape(design)
    steps = np.diff(np.unique(y))
    step, most = divisor(steps), float(np.abs(rest).max())
    # Points at even x are nearly in steps too, without rounding.
    is_rounded = step > 0.0 and float(np.abs(steps - step * np.round(steps / step)).max()) < SAME * step
    # Errors of rounding are anywhere within half a step, whatever x is.
    if is_rounded and 2 * most < step and (2 * most / step) ** (n - p) < CHANCE:
        text = (
            "y is in steps of {step:figures}, and no point is farther than {most:figures} off the fit: what rounding "
            "left out is in no scatter, state 'u_y'"
        )
        yield said(text, step=readable(step, units[1], 3), most=readable(most, units[1], 3))
    weight = np.square(np.linalg.qr(np.asarray(design, dtype=float))[0]).sum(axis=1)
    if float(weight.max()) > ALONE:
        text = "the fit rests on one point alone, at x = {x:figures}, whose error shows in no residual: state 'u_y'"
        yield said(text, x=readable(float(x[weight.argmax()]), units[0], 4))


def bent(x: Floats, residuals: Floats, design: Floats, u: Floats) -> float:
    """Upper limit of the probability that residuals follow further terms in x so well by chance.

    Of one or two higher polynomials of its rank, and of other parameters from one of the middle points on, as of
    another range, the least probable by the ratio of variances of independent normal errors (F), times their number
    (Bonferroni). Of few points these tell what their order does not. `x` in order. Sources: N. R. Draper, H. Smith,
    Applied Regression Analysis, 3rd ed. (1998), 6.1; G. C. Chow, Econometrica 28 (1960) 591.
    """
    n, p = design.shape
    # By rank: of x itself a point far out would decide alone.
    away = 2 * (rankdata(x) - 1) / (n - 1) - 1
    higher = np.polynomial.legendre.legvander(away, p + 1)[:, p:] / u[:, None]
    first = max(p + 1, n // 4)
    places = np.flatnonzero(np.diff(x) > 0.0) + 1
    places = places[(places >= first) & (places <= n - first)]
    places = places[np.unique(np.linspace(0, len(places) - 1, PLACES).astype(int))] if len(places) else places
    # Parameters may have any unit.
    design = design / np.maximum(np.linalg.norm(design, axis=0), np.finfo(float).tiny)
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
    within = float(np.square(about_means(residuals, of)).sum())
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
