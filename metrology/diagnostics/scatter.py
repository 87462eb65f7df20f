"""Few readings of unknown scatter: how much of them is scatter, and whether a fit leaves more than scatter."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from metrology.diagnosis import Test
from metrology.diagnostics.subject import Array, Fit
from metrology.message import said

RARE = 1e-4
"""Probability at which Student's t and the normal limit are made to agree: about where a score is beyond chance."""
KEPT = 0.005
"""Chance of a gain, among all candidates, below which it is taken out of the scatter."""
MOST = 3
"""Candidates that are taken out of the scatter at most."""
ROUNDS = 4


def scatter(y: Array, base: Array, known: tuple[Array, Array], candidates: Sequence[tuple[bool, Array]]) -> float:
    """Standard deviation of one reading, candidates that stand out and the best of the others taken out.

    An effect that is left in the scatter hides itself: its score is measured in it. So the scatter is that beside the
    best candidate, and it is widened by t(ν)/z at a chance of 1e-4: the score of that candidate is then as likely
    as Student's t says, though the engine reads it as a normal one.

    Parameters
    ----------
    y : ndarray, shape (n,)
        Readings.
    base : ndarray, shape (n, p)
        Columns of the model.
    known : (ndarray, ndarray), shapes (n, q) and (q,)
        Columns of known inputs, and their standard uncertainties in the unit of the readings.
    candidates : sequence of (bool, ndarray)
        Whether each may act either way, and its column, shape (n,).
    """
    from scipy.special import stdtr, stdtrit

    size = np.linalg.norm(base, axis=0)
    columns, u = known
    taken, s, dof = base / np.where(size > 0, size, 1.0), float(np.std(y)) or 1.0, 1
    for _ in range(MOST + 1):
        best = None
        for _ in range(ROUNDS):
            best, squares, dof = _best(y, taken, (columns, u), candidates, s)
            s = math.sqrt(max(squares, 0.0) / max(dof, 1)) or 1e-300
        if best is None:
            break
        at, t = best
        p = float(stdtr(max(dof, 1), -t)) * len(candidates) * (2 if candidates[at][0] else 1)
        if p > KEPT or dof < 3:
            break
        column = candidates[at][1]
        taken = np.column_stack([taken, column / np.linalg.norm(column)])
    return s * float(-stdtrit(max(dof, 2), RARE)) / 3.719


def _best(
    y: Array, taken: Array, known: tuple[Array, Array], candidates: Sequence[tuple[bool, Array]], s: float
) -> tuple[tuple[int, float] | None, float, int]:
    """Candidate that takes most from the squares, with its t; squares left beside it, and degrees of freedom."""
    columns, u = known
    # A known input is a reading of zero with its own uncertainty.
    seen = u > 0
    extra = np.diag(s / u[seen])
    design = np.block([[taken, columns[:, seen]], [np.zeros((len(extra), taken.shape[1])), extra]])
    q, r = np.linalg.qr(design)
    rank = int((np.abs(np.diag(r)) > 1e-10 * np.abs(np.diag(r)).max()).sum())
    target = np.concatenate([y - y.mean(), np.zeros(len(extra))])
    rest = target - q @ (q.T @ target)
    squares, dof = float(rest @ rest), len(target) - rank
    best, gain = None, 0.0
    for at, (signed, column) in enumerate(candidates):
        whole = np.concatenate([column, np.zeros(len(extra))])
        own = whole - q @ (q.T @ whole)
        size = float(own @ own)
        if size < 1e-8 * float(whole @ whole):
            continue
        pull = float(own @ rest)
        if (signed or pull > 0) and pull**2 / size > gain:
            best, gain = at, pull**2 / size
    if best is None:
        return None, squares, dof
    left = max(squares - gain, 0.0)
    t = math.sqrt(gain / max(left / max(dof - 1, 1), 1e-300))
    return (best, t), left, dof - 1


def left_over(fit: Fit, alternatives: Mapping[str, Array], false_alarm: float) -> Test:
    """F test of each group of columns against the scatter beside it; the limit is shared out among them.

    Groups of as many columns as readings are looked at one by one, by Student's t.

    Parameters
    ----------
    fit : Fit
        What may leave something over.
    alternatives : mapping of str to ndarray, shape (n, q)
        Columns in the order of the fit's readings.
    false_alarm : float
        Chance that any of them fails where nothing is left.
    """
    from scipy.special import fdtrc, stdtr

    J = np.zeros((sum(len(part) for part in fit.residuals), len(fit.theta)))
    first = 0
    for block, slope in zip(fit.problem.blocks, fit.slopes, strict=True):
        J[first : first + len(slope), np.array(block.uses)] = slope
        first += len(slope)
    r, bread = np.concatenate(fit.residuals), fit.covariance
    free = sum(entry.u is None for entry in fit.problem.unknowns)
    dof, worst, p_least, statistic = len(r) - free, "", 1.0, 0.0
    for name, columns in alternatives.items():
        D = columns.T @ columns - columns.T @ J @ bread @ J.T @ columns
        b = columns.T @ r
        if columns.shape[1] == len(r):
            size = np.diag(D)
            ok = size > 1e-6
            gains = np.where(ok, b**2 / np.where(ok, size, 1.0), 0.0)
            gain, ways = float(gains.max()), 1
        else:
            values, vectors = np.linalg.eigh(D)
            ok = values > 1e-6 * max(float(values.max()), 1e-300)
            gain, ways = float((((vectors.T @ b)[ok]) ** 2 / values[ok]).sum()), int(ok.sum())
        rest = dof - ways
        if ways == 0 or rest < 2:
            continue
        F = gain / ways / max((fit.cost - gain) / rest, 1e-12)
        p = float(fdtrc(ways, rest, max(F, 0.0)))
        if columns.shape[1] == len(r):
            p = min(1.0, 2 * float(stdtr(rest, -math.sqrt(max(F, 0.0)))) * len(r))
        if p < p_least:
            worst, p_least, statistic = name, p, F
    p = min(1.0, p_least * len(alternatives))
    passed = p >= false_alarm
    text = (
        "No more than scatter is left: F = {statistic:.1f} (p = {p:.2g} among {count} tests)."
        if passed
        else "More than scatter is left, most of it by {worst}: F = {statistic:.1f} (p = {p:.2g} among {count} tests)."
    )
    sentence = said(text, statistic=float(statistic), p=float(p), count=len(alternatives), worst=worst)
    return Test("residual", statistic, math.nan, p, false_alarm, passed, sentence)
