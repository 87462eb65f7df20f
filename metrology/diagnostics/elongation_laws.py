"""Laws of an elongation test that nobody lists: extension of any form, of load, direction, repeat and order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from metrology.diagnostics.direction import STRAIGHT, Direction
from metrology.diagnostics.families import hats
from metrology.diagnostics.subject import Array

Rows = np.ndarray[tuple[int, ...], np.dtype[np.intp]]

ORDERS = 8
"""Places over the order of reading at which an unlisted law has a size of its own."""


def unlisted(at: Sequence[Rows], force: Array, back: Array, unit: float) -> list[Direction]:
    """Extension of load, of load and direction, of these in each repeat; of the order of reading.

    Parameters
    ----------
    at : sequence of ndarray
        Readings of each repeat.
    force, back : ndarray, shape (n,)
        Of every reading, and whether it was taken while unloading.
    unit : float
        Amount of each way / m: the standard uncertainty of a reading.
    """
    rows = np.concatenate(at)
    order = np.linspace(-0.5, len(rows) - 0.5, ORDERS)
    family = partial(_family, at, unit)
    whole: Array = np.ones(len(rows))
    loads = np.unique(force)
    by, way = force[rows], back[rows]
    acts = {"extension of load": whole}
    if 0 < way.mean() < 1:
        acts["extension of load and direction"] = way - 0.5
    found = [family(name, [(by, loads, one)]) for name, one in acts.items()]
    found[0] = replace(found[0], rough=True)
    if len(at) > 1:
        repeats = [np.isin(rows, own).astype(float) for own in at]
        found += [family(f"{name} that differs between repeats", [(by, loads, one * own) for own in repeats])
                  for name, one in acts.items()]  # fmt: skip
    by_order = family("extension of order", [(np.arange(len(rows), dtype=float), order, whole)])
    return [*found, replace(by_order, listed=STRAIGHT)]


def _family(at: Sequence[Rows], unit: float, name: str, parts: Sequence[tuple[Array, Array, Array]]) -> Direction:
    """Hats over what a law depends on (by reading, places, whether it acts), one part beside the other."""
    columns: list[Array] = []
    values: dict[str, float] = {}
    for number, (by, knots, acts) in enumerate(parts):
        columns.append(hats(by, knots) * acts[:, None])
        values |= {f"{name} {number}@{place}": float(knot) for place, knot in enumerate(knots)}
    ends = np.cumsum([len(own) for own in at])[:-1]
    return Direction(name, values, unit, tuple(np.split(-np.column_stack(columns), ends)), ways=tuple(values))
