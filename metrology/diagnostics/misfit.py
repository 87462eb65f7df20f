"""Residuals of the full list of effects: a factor on the covariance of the readings, and the noise about lines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from metrology.diagnostics.line import Line
from metrology.diagnostics.residual_spectra import Spectrum, segments, spectra_of
from metrology.diagnostics.span import Span, orthonormal
from metrology.diagnostics.subject import Array
from metrology.noise import PLACES, power_of

ABOUT = 8
"""Bins of the spectrum either side of a line over which the noise about it is taken: 30 degrees of freedom, a quarter;
a mode of a clamp or frame with 1 % of damping is as wide where a record holds hundreds of its periods."""


def misfit(full: Line, sought: Array, explained: tuple[Span, Array] | None = None) -> float:
    """λ: mean square of what the full list leaves, where the unknowns act, over that of the noise; 1 at least.

    With orthonormal whitened columns Q of the unknowns and the periodogram P̂ of the residual,
    λ = mean over k of Σ_f |Q_k|²·P̂ / Σ_f |Q_k|². P̂ is smoothed over as many bins either side as unknowns were fitted,
    and raised by the degrees of freedom that they took there.

    Parameters
    ----------
    full : Line
        With every candidate, weighted with a misfit of 1.
    sought : ndarray, shape (n + p, m)
        Columns of the unknowns and effects about which something is to be said.
    explained : (Span, ndarray of shape (n + p,)), optional
        Span of a longer list than the line's own, and the residual beside it.
    """
    taken, _ = explained or full.explained
    spectra = spectra_of(full.fit, *explained) if explained else full.spectra
    Q = orthonormal(sought)
    over = power = 0.0
    for rows, spectrum in zip(segments(full.fit), spectra, strict=True):
        weight, here = _spectral(Q[rows], spectrum, taken.width)
        over += float((weight * here).sum())
        power += float(weight.sum())
    # Known to some per cent; rounded, it is the same on every processor.
    return max(1.0, round(over / max(power, 1e-300), PLACES))


def narrow(full: Line, lines: Sequence[Array], whole: float) -> tuple[tuple[slice, Array, float], ...]:
    """Where the noise of a record about a line that is tried, or carried, is stronger than a smooth colour says.

    A band of noise is no line: what it leaves beside the line's frequency says how much of the line it makes itself.
    A record has noise of its own: a clamp that rings in one run does not in the others.

    Parameters
    ----------
    full : Line
        With every candidate, weighted with a misfit of 1.
    lines : sequence of ndarray, shape (n + p, q)
        Columns of each line.
    whole : float
        Misfit where all unknowns act.
    """
    found = []
    for part, spectrum in zip(segments(full.fit), full.spectra, strict=True) if lines else ():
        own = np.zeros((part.stop - part.start, 0))
        for rows in lines:
            columns = rows[part][:, rows[part].any(axis=0)]
            if not columns.shape[1]:
                continue
            weight, here = _spectral(orthonormal(columns), spectrum, ABOUT)
            factor = round(float((weight * here).sum() / weight.sum()), PLACES) / whole
            if factor > 1.0:
                about = _about(columns)
                about = orthonormal(about - own @ (own.T @ about))
                own = np.hstack([own, about])
                found.append((part, about, factor))
    return tuple(found)


def _about(rows: Array) -> Array:
    """Columns of a line in one record and of those within one bin of the spectrum, which grow along it."""
    along = np.linspace(-1.0, 1.0, len(rows))[:, None]
    return np.hstack([rows, along * rows, along**2 * rows])


def _spectral(Q: Array, record: Spectrum, bins: int) -> tuple[Array, Array]:
    """Power of the unknowns by frequency in one record, and smoothed power of what is left."""
    weight = power_of(Q)
    width = min(2 * max(bins, 1) + 1, len(record.left))
    kernel = np.ones(width)
    inside = np.convolve(np.ones(len(record.left)), kernel, "same")
    smooth = np.convolve(record.left, kernel, "same") / inside
    # Of the two degrees of freedom of a bin, those that the fit took are not in what it leaves.
    free = 1.0 - np.convolve(record.absorbed, kernel, "same") / inside
    return weight, smooth / np.maximum(free, 0.3)
