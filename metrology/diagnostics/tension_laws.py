"""Laws of a tension test that nobody lists: extension of any form, by both readings or by one alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from metrology.diagnostics.direction import STRAIGHT, Direction
from metrology.diagnostics.families import hats
from metrology.diagnostics.subject import Array
from metrology.diagnostics.tension_records import Record
from metrology.effect import Pulled

KNOTS, FINE = 8, 40
"""Places over the load at which a law has a size of its own; of one that comes again, such as every turn of a screw."""
SET_UP, EXTENSOMETER = "the set-up", "the extensometer"
"""What a law of one reading alone is a law of."""


def unlisted(records: Sequence[Record], whole: Pulled, *, crosshead: bool, strain: bool) -> list[Direction]:
    """Extension of load by both readings, by either alone, of load and direction by either.

    Parameters
    ----------
    records : sequence of Record
        Of the specimens.
    whole : Pulled
        All readings together: largest force, scatter.
    crosshead, strain : bool
        Which readings there are.
    """
    low = min(float(one.seen.force.min()) for one in records)
    knots, fine = (np.linspace(low, whole.most, count) for count in (KNOTS, FINE))
    places = [name for name, there in ((SET_UP, crosshead), (EXTENSOMETER, strain)) if there]

    def family(name: str, at: Array, acts: Callable[[Pulled], Array]) -> Direction:
        """Hats over the load, where they act and how much."""
        rows = [-whole.u * hats(one.seen.force, at) * acts(one.seen)[:, None] / one.u[:, None] for one in records]
        values = {f"{name}@{number}": float(knot) for number, knot in enumerate(at)}
        return Direction(name, values, whole.u, tuple(rows), ways=tuple(values))

    # A parabola of the specimen is listed: `curvature`.
    found = [replace(family("extension of load", knots, _every), listed=(0, 1, 2))]
    if len(places) > 1:
        found.append(replace(family(f"extension of load in {SET_UP}", knots, _in(SET_UP)), listed=STRAIGHT))
    found += [replace(family(f"fine extension of load in {place}", fine, _in(place)), listed=STRAIGHT)
              for place in places]  # fmt: skip
    if any(one.seen.falling.any() for one in records):
        found += [family(f"extension of load and direction in {place}", knots, _back(place)) for place in places]
    return found


def _every(seen: Pulled) -> Array:
    """1 for every reading."""
    return np.ones(len(seen.force))


def _in(place: str) -> Callable[[Pulled], Array]:
    """1 for readings of the crosshead, or of the extensometer."""
    return lambda seen: seen.crosshead if place == SET_UP else 1.0 - seen.crosshead


def _back(place: str) -> Callable[[Pulled], Array]:
    """−½ for these readings while the force rises, ½ while it falls."""
    return lambda seen: _in(place)(seen) * (seen.falling - 0.5)
