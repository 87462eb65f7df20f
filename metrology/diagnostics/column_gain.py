"""What the columns of a candidate gain beside everything that a fit carries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from metrology.diagnostics.likelihood import RANK
from metrology.diagnostics.line import Column, Line
from metrology.diagnostics.span import orthonormal
from metrology.diagnostics.subject import Array

INVISIBLE = 2e-3
"""Part of a column that the unknowns of a fit leave of it, below which nothing of it can be seen: a set-up's compliance
leaves that much of a softer line, which it is."""


def orthonormal_of(parts: Sequence[Array], count: int) -> Array:
    """Orthonormal columns that span all parts."""
    return orthonormal(np.hstack(parts)) if parts else np.zeros((count, 0))


def carried_by(line: Line) -> dict[str, Array]:
    """Columns of each effect that the fit carries, less their part within the base."""
    return {one.effect: rows for one, rows in zip(line.columns, line.left, strict=True) if one.direction is None}


def tried_beside(line: Line) -> Iterator[tuple[Column, Array]]:
    """Columns of the candidates, and the rows of each less their part within the base, shape (n + p, q).

    A derivative without readings where none of them shows it: only the priors show it then, as a compliance of the
    set-up is a softer line, which the stated k contradicts.
    """
    split = len(line.residual) - len(line.fit.theta)
    for column, left in zip(line.columns, line.left, strict=True):
        if column.direction is None:
            continue
        rows = left
        if column.direction.exact:
            hidden = np.linalg.norm(rows[:split], axis=0) <= INVISIBLE * np.linalg.norm(column.rows, axis=0)
            if hidden.any():
                rows = rows.copy()
                rows[:split, hidden] = 0.0
        yield column, rows


def gain_of(column: Column, rows: Array, residual: Array, priors: int) -> float | None:
    """Half the fall of the cost with a column beside everything that the fit carries; None where nothing is left of it.

    Zero where it would have the wrong sign. The last rows are the `priors`: what stated inputs can do in place of a
    candidate counts against it there.
    """
    whole = np.linalg.norm(column.rows, axis=0)
    split = len(rows) - priors
    data, stated = (np.linalg.norm(part, axis=0) for part in (rows[:split], rows[split:]))
    if not ((data > INVISIBLE * whole) | ((stated > data) & (stated > RANK * whole))).any():
        return None
    amounts, *_ = np.linalg.lstsq(rows, -residual, rcond=RANK)
    if not column.signed and amounts[0] < 0:
        return 0.0
    return 0.5 * float(-(rows @ amounts) @ residual)
