"""Candidates of a tension test: shapes within what its loads show, sizes that all records share."""

from __future__ import annotations

from dataclasses import replace

from metrology.diagnostics.candidate import Candidate
from metrology.effect import Pulled


def limited(one: Candidate, seen: Pulled) -> Candidate:
    """Candidate with shapes within what the loads can show."""
    limits = one.limits(seen)
    sizes = (
        replace(size, low=limits[size.name][0], high=limits[size.name][1], null=max(size.null, limits[size.name][0]),
                scale=size.scale and 0.05 * limits[size.name][1])
        if size.name in limits else size
        for size in one.parameters
    )  # fmt: skip
    return replace(one, parameters=tuple(sizes))


def shared(one: Candidate) -> Candidate:
    """Candidate with one size for all records."""
    return replace(one, parameters=tuple(replace(size, own=False) for size in one.parameters))
