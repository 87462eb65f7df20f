"""Slope of a record against force, with the memory of the record's own noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST = 400
"""Means of consecutive readings that a regression is made over: a slope lives at the lowest frequencies."""
LEAST = 12
"""Readings of a range, below which a slope has no uncertainty worth the name."""
SHARE = 0.41
"""ν = 0.41·n^(2/3) lowest cosines give the level of the noise (Lazarus, Lewis, Stock & Watson, J. Bus. Econ. Stat. 36
(2018) 541, eq. 4): few enough for any colour, enough for an interval."""
MEMORIES = 1.0 - np.geomspace(1.0, 0.01, 16)
"""Correlations φ of neighbouring readings that are weighed: from none to a memory of a hundred readings."""
CLEAR = 10.0
"""Power of a cosine of the force over that of noise, from which on a tenth of it at most is noise."""
WHITE = (0.0, 0.25, 0.5, 0.75, 0.9, 0.97)
"""Shares of white noise on top of it."""


@dataclass(frozen=True)
class Slope:
    """Line y = intercept + value·F through a record.

    Parameters
    ----------
    value, u, dof : float
        Slope in the unit of y by newton, its standard uncertainty by the scatter of the record, degrees of freedom.
    intercept : float
        y of the line at no force.
    bow, bow_u : float
        Deviation of a parabola through the readings from its chord in the middle, and its standard uncertainty, in the
        unit of y: what the line is out of straight. Positive where y grows faster and faster.
    level : float
        Standard deviation of one reading about the line.
    memory : float
        Correlation of neighbouring readings, mean over those that the record supports.
    count : int
        Readings.
    """

    value: float
    u: float
    dof: float
    intercept: float
    bow: float
    bow_u: float
    level: float
    memory: float
    count: int


def averaged(*channels: Array, most: int = MOST) -> tuple[Array, ...]:
    """Means of so many consecutive readings that `most` of them are left at most."""
    each = -(-len(channels[0]) // most)
    whole = len(channels[0]) // each * each
    return tuple(one[:whole].reshape(-1, each).mean(axis=1) for one in channels)


def scatter(values: Array) -> float:
    """Standard deviation of what each reading scatters by itself, in the unit of the readings, shape (n,).

    By second differences, to which no curve adds: those of independent readings have 1 + 4 + 1 times their variance.
    """
    return float(np.sqrt(np.mean(np.diff(values, 2) ** 2) / 6)) if len(values) > 2 else 0.0


def slope(force: Array, y: Array) -> Slope:
    """Fit a line to a record by generalised least squares, in the metric of its own noise.

    The noise is white noise and noise with a memory, S(ω) = w + (1 − w)·(1 − φ²)/|1 − φ·e^(−iω)|². Nobody knows φ and
    w: each of them is weighed by its restricted likelihood, and the slope is the mean over all. For each the level of
    the noise is that of what the line leaves in the lowest cosines over the record, where a slope lives as well: so a
    colour that S does not describe counts as it acts there. Student's distribution, with as many degrees of freedom as
    there are cosines.

    Parameters
    ----------
    force, y : ndarray, shape (n,)
        Readings of force / N and of a displacement or strain, evenly in time, `LEAST` at least.

    Notes
    -----
    Noise of the force would lessen the slope, the more so where the noise of y has a memory and differences count. The
    line is therefore drawn with the force without it (`ramp`) as an instrument (Durbin, Rev. Int. Stat. Inst. 22 (1954)
    23); what the force scatters counts with what the line leaves.

    Examples
    --------
    >>> F = np.linspace(0.0, 100.0, 101)
    >>> found = slope(F, 0.02 * F + 1e-3 * np.cos(2.0 * np.arange(101)))
    >>> round(found.value, 6), found.dof
    (0.02, 9.0)
    """
    F, Y = averaged(force, y)
    span = float(np.ptp(F)) or 1.0
    t, read = (ramp(F) - F.mean()) / span, (F - F.mean()) / span
    line, (values, covariance), memory = weighed(t, read, Y, 2)
    _, (bent, bent_covariance), _ = weighed(t, read, Y, 3)
    left = y - values[0] - values[1] * (force - F.mean()) / span
    return Slope(
        float(values[1]) / span, sqrt(covariance[1, 1]) / span, line, float(values[0] - values[1] * F.mean() / span),
        float(bent[2]) / 4, sqrt(bent_covariance[2, 2]) / 4, float(np.std(left)), memory, len(y),
    )  # fmt: skip


def ramp(force: Array) -> Array:
    """The force without its noise: a cubic of time, and of the rest the lowest cosines, down to the level of noise.

    That level is the mean power of the upper half of the cosines.
    """
    from numpy.polynomial import legendre
    from scipy.fft import dct, idct

    time = np.linspace(-1.0, 1.0, len(force))
    smooth = legendre.legval(time, legendre.legfit(time, force, 3))
    waves = np.asarray(dct(force - smooth, type=2, norm="ortho"))
    power = waves**2
    floor = float(np.mean(power[len(power) // 2 :]))
    # The cubic has what would stand in the first four.
    low = np.flatnonzero(np.maximum(power[4:-1], power[5:]) < CLEAR * floor)
    waves[4 + int(low[0]) if len(low) else len(waves) :] = 0.0
    return np.asarray(smooth + idct(waves, type=2, norm="ortho"))


def weighed(t: Array, read: Array, y: Array, terms: int) -> tuple[float, tuple[Array, Array], float]:
    """Degrees of freedom, values and covariance of a polynomial, mean over all colours; mean memory.

    The cosines of a record are independent of one another, whatever the colour (Whittle, Ark. Mat. 2 (1953) 423).
    """
    from scipy.fft import dct

    scale, n = float(np.abs(y).max()) or 1.0, len(y)
    columns = np.column_stack([t[:, None] ** np.arange(terms), read, y / scale])
    rows = np.asarray(dct(columns, type=2, norm="ortho", axis=0))
    spectra, prior, memories = _colours(n)
    X, left, dof = rows[:, :terms], rows[:, -1], _cosines(n, terms)
    seen = X.copy()
    seen[:, 1] = rows[:, terms]
    information = np.einsum("gn,ni,nj->gij", 1 / spectra, X, X)
    crossed = np.einsum("gn,ni,nj->gij", 1 / spectra, X, seen)
    values = np.linalg.solve(crossed, np.einsum("gn,ni,n->gi", 1 / spectra, X, left)[..., None])[..., 0]
    rest = left - values @ seen.T
    squares = np.maximum((rest**2 / spectra).sum(axis=1), 1e-28 * n)
    # Harville, Biometrika 61 (1974) 383: restricted likelihood, its level integrated out.
    likelihood = -0.5 * (
        np.log(spectra).sum(axis=1) + np.linalg.slogdet(information)[1] + (n - terms) * np.log(squares)
    )
    weights = prior * np.exp(likelihood - likelihood.max())
    weights /= weights.sum()
    inverse = np.linalg.inv(information)
    level = _levels(rest, spectra, X, inverse, dof)
    mean = weights @ values
    away = values - mean
    covariance = np.einsum("g,g,gij->ij", weights, level, inverse) + np.einsum("g,gi,gj->ij", weights, away, away)
    return float(dof), (scale * mean, scale**2 * covariance), float(weights @ memories)


@lru_cache(maxsize=32)
def _colours(n: int) -> tuple[Array, Array, Array]:
    """Spectra of unit variance at the cosines of n readings, shape (g, n), their weights beforehand, their memories."""
    omega = np.pi * np.arange(n) / n
    steps = np.abs(np.gradient(MEMORIES)) / len(WHITE)
    found = [
        (w + (1 - w) * (1 - memory**2) / (1 - 2 * memory * np.cos(omega) + memory**2), step, (1 - w) * memory)
        for memory, step in zip(MEMORIES.tolist(), steps.tolist(), strict=True) for w in WHITE
    ]  # fmt: skip
    spectra, prior, memories = (np.array(column) for column in zip(*found, strict=True))
    return spectra, prior, memories


def _cosines(n: int, terms: int) -> int:
    return int(min(max(round(SHARE * n ** (2 / 3)), 3), n - terms))


def _levels(rest: Array, spectra: Array, X: Array, inverse: Array, count: int) -> Array:
    """Mean square of whitened noise in the lowest cosines, over the part of it that the line leaves there."""
    low = slice(1, count + X.shape[1] - 1)
    taken = np.einsum("ni,gij,nj->gn", X[low], inverse, X[low]) / spectra[:, low]
    return np.asarray((rest[:, low] ** 2 / spectra[:, low]).sum(axis=1) / np.maximum((1 - taken).sum(axis=1), 1.0))
