"""Few readings of unknown scatter: whether their noise has heavy tails, of which one is like a misread reading."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import gammaln

from metrology.diagnostics.likelihood import spread_out
from metrology.diagnostics.sets import log_prior
from metrology.diagnostics.subject import Array, Fit

TAILS = (3.0, 5.0, 10.0)
"""Degrees of freedom of Student's t, equally probable: from the fewest with a variance to nearly normal."""
EXACT = 1e-12
"""Mean square of residuals, over what was stated, below which they are rounding."""
ROUNDS = 50
"""Steps of the iteration; each has half of the error of the one before at worst."""


def either(fit: Fit, among: int, rounding: float = 0.0) -> float:
    """Ln evidence of a model whose noise may have heavy tails, over that of normal noise.

    A reading that is far off is one that was misread where the others are normal, and is one of the noise where that
    has such readings. Heavy tails are one more candidate (`sets.log_prior`). The unknowns are at the optimum of each
    likelihood (iteratively reweighted least squares: Lange et al., J. Am. Stat. Assoc. 84 (1989) 881); in the
    difference of two, the degrees of freedom that the unknowns take have no part.

    Parameters
    ----------
    fit : Fit
        The model.
    among : int
        Candidates of the whole list.
    rounding : float
        Cost that rounding of the readings leaves of any model: no reading is nearer to one than that.
    """
    J, r = np.vstack(spread_out(fit)), np.concatenate(fit.residuals)
    root = np.sqrt(fit.problem.precision)
    known = root > 0
    rows = np.vstack([J, np.diag(root)[known]])
    sought = np.concatenate([r, (root * (fit.theta - fit.problem.mean))[known]])
    least = rounding / max(len(r), 1)
    normal = _likelihood(rows, sought, (len(r), least), math.inf)
    part, count = fit.free / max(fit.count, 1), len(fit.effects)
    gains = [part * (_likelihood(rows, sought, (len(r), least), dof) - normal) for dof in TAILS]
    odds = log_prior(count + 1, among + 1) - log_prior(count, among + 1)
    return float(np.logaddexp(0.0, np.logaddexp.reduce(gains) - math.log(len(TAILS)) + odds))


def _likelihood(rows: Array, sought: Array, readings: tuple[int, float], dof: float) -> float:
    """Largest ln likelihood of readings (the first rows) and priors, up to a constant; the noise has any size.

    `readings`: how many there are, and the square that rounding adds to each.
    """
    count, least = readings
    size = np.linalg.norm(rows, axis=0)
    # What moves no reading by more than its square can be held is no column.
    size[size < 1e-150] = math.inf
    weight, square = np.ones(len(rows)), 1.0
    for _ in range(ROUNDS):
        scale = np.sqrt(weight)[:, None]
        amounts = np.linalg.lstsq(scale * (rows / size), -scale[:, 0] * sought, rcond=1e-12)[0] / size
        left = sought + rows @ amounts
        squares = left[:count] ** 2 + least
        pull = 1.0 if math.isinf(dof) else (dof + 1.0) / (dof + squares / square)
        square = max(float(np.mean(pull * squares)), EXACT)
        weight[:count] = pull / square
    priors = float(left[count:] @ left[count:])
    if math.isinf(dof):
        return -0.5 * (count * math.log(square) + count + priors) - 0.5 * count * math.log(2 * math.pi)
    shape = gammaln(0.5 * (dof + 1)) - gammaln(0.5 * dof) - 0.5 * math.log(math.pi * dof)
    tails = 0.5 * (dof + 1) * float(np.log1p(squares / (dof * square)).sum())
    return count * (float(shape) - 0.5 * math.log(square)) - tails - 0.5 * priors
