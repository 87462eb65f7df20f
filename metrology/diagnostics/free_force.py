"""What a free force along the fitted motion says: how much a law of each quantity would remove, and its picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from metrology.diagnosis import Missing
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.flexible import CURVED, UNITS
from metrology.diagnostics.likelihood import spread_out
from metrology.diagnostics.span import orthonormal
from metrology.diagnostics.subject import Array, Fit
from metrology.message import said

SEEN = 1e-5
"""Share of a combination of hats that the other unknowns have to leave, else it counts for nothing."""


@dataclass(frozen=True)
class Form:
    """One family, judged: χ² that it would remove, its degrees of freedom, and the amounts with their uncertainty."""

    family: str
    """What it is, and of what: 'force of velocity', 'fine force of time', 'curve of tension'."""
    chi_squared: float
    dof: int
    p_value: float
    at: Array
    amounts: Array
    u: Array

    @property
    def quantity(self) -> str:
        """What it depends on."""
        return self.family.removeprefix("fine ").partition(" of ")[2]

    @property
    def kind(self) -> str:
        """Whether it is a force, a torque, or a curved reading."""
        return self.family.removeprefix("fine ").partition(" of ")[0]


def forms(fit: Fit, families: Sequence[Direction]) -> list[Form]:
    """Scores of all families, in units of the noise that the readings themselves show."""
    level, off, explained = _level(fit), fit.covariance @ fit.gradient, _explained(fit)
    return [_form(fit, family, (off, explained), level) for family in families]


def _explained(fit: Fit) -> Array:
    """Orthonormal columns of all that the unknowns and their priors explain, shape (n + p, p).

    The products JᵀJ and JᵀG keep half of the digits, of which a combination that the unknowns explain but for 1e-5
    has none left.
    """
    J = np.vstack([*spread_out(fit), np.diag(np.sqrt(fit.problem.precision))])
    return orthonormal(J)


def _gathered(fit: Fit, rows: Sequence[Array]) -> Array:
    """JᵀG over all blocks, shape (p, …)."""
    total = np.zeros((len(fit.theta), *rows[0].shape[1:]))
    for block, slope, part in zip(fit.problem.blocks, fit.slopes, rows, strict=True):
        total[np.array(block.uses)] += slope.T @ part
    return total


def _form(fit: Fit, family: Direction, at: tuple[Array, Array], level: float) -> Form:
    from scipy.special import gammaincc

    off, explained = at
    G = np.vstack([*family.rows, np.zeros((len(off), len(family.values)))])
    b = _gathered(fit, family.rows).T @ off - np.asarray(
        sum(part.T @ own for part, own in zip(family.rows, fit.residuals, strict=True))
    )
    size = np.maximum(np.linalg.norm(G, axis=0), 1e-150)
    left = G / size - explained @ (explained.T @ (G / size))
    _, own, ways = np.linalg.svd(left, full_matrices=False)
    values, vectors = own**2, ways.T
    seen = values > max(SEEN, 1e-6 * float(values.max(initial=0.0)))
    turned = vectors[:, seen].T @ (b / size)
    chi_squared = float(np.sum(turned**2 / values[seen])) / level**2
    dof = int(seen.sum())
    p = float(gammaincc(dof / 2, chi_squared / 2)) if dof else 1.0
    amounts = vectors[:, seen] @ (turned / values[seen]) / size * family.amount
    u = level * np.sqrt(np.sum(vectors[:, seen] ** 2 / values[seen], axis=1)) / size * family.amount
    return Form(family.effect, chi_squared, dof, p, np.array(list(family.values.values())), amounts, u)


def _level(fit: Fit) -> float:
    """Noise of the readings over what is stated, from one reading to the next."""
    parts = [np.diff(part[used]) for part, used in zip(fit.residuals, fit.used, strict=True)]
    squares = np.concatenate(parts) ** 2
    # Without the largest: readings on either side of a channel's end, or of a gap, are not neighbours.
    return math.sqrt(max(float(np.mean(np.minimum(squares, 50.0))) / 2, 1e-12))


def missing(found: Sequence[Form]) -> Missing | None:
    """Force that is missing, as a function of what explains most of it; None where none of them stands out."""
    seen = [one for one in found if one.dof and len(one.at) > 2]
    if not seen:
        return None
    best = min(seen, key=lambda one: (one.p_value, -one.chi_squared / one.dof))
    excess = {one.quantity: 0.0 for one in seen}
    for one in seen:
        excess[one.quantity] = max(one.chi_squared - one.dof, excess[one.quantity])
    total = max(excess.values()) or 1.0
    by = best.quantity
    what, unit = ("reading", UNITS[by]) if best.kind == CURVED else (best.kind, UNITS[best.kind])
    largest = int(np.argmax(np.abs(best.amounts) / np.maximum(best.u, 1e-300)))
    text = (
        "A {what} of {size:.2g} {unit} (u = {u:.1g} {unit}) is missing where the {by} is {at:.3g} {by_unit}; what is "
        "missing depends most on {by}."
    )
    sentence = said(
        text, what=what, size=float(best.amounts[largest]), unit=unit, u=float(best.u[largest]), by=by,
        at=float(best.at[largest]), by_unit=UNITS[by],
    )  # fmt: skip
    return Missing(
        said("missing {what}", what=what), unit, by, UNITS[by], tuple(best.at.tolist()), tuple(best.amounts.tolist()),
        tuple(best.u.tolist()), {name: value / total for name, value in excess.items()}, sentence,
    )  # fmt: skip
