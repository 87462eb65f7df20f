"""Values from which a set of effects is fitted: where the straight line leads, and nearer to a smaller model."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.line import base_places
from metrology.diagnostics.sets import Set
from metrology.diagnostics.subject import Array, Fit
from metrology.diagnostics.view import View

LITTLE, HARDLY = 0.3, 0.01
"""Parts of what can just be seen of an effect with which a fit begins: to have a way on, and to change nothing."""


def starts(here: View, candidates: Mapping[str, Candidate], wanted: Set, smaller: Fit | None) -> list[dict[str, float]]:
    """Values to begin from: the straight line's, those of the fit with a little of what is new, a smaller model's.

    In the last there is hardly anything else than that model.
    """
    values, plain = dict(here.fit.values), dict(here.fit.values)
    hardly = {**plain, **(smaller.values if smaller else {})}
    found = here.table.amounts(wanted)
    rows = np.zeros(len(here.line.residual))
    first = 0
    for name, member in here.table.members.items():
        if name not in wanted:
            continue
        width = member.rows.shape[1]
        if found is not None:
            amounts = found[0][first : first + width]
            rows = rows + member.column.rows @ amounts
            if member.column.direction is not None:
                values |= _begun(here.fit, candidates[name], member.column.direction, amounts)
        if member.column.direction is not None:
            plain |= _begun(here.fit, candidates[name], member.column.direction, np.full(width, LITTLE))
        if smaller is not None and name not in smaller.effects:
            hardly |= _hardly(here, smaller, candidates[name])
        first += width
    _shifted(here, candidates, values, rows)
    return [values, plain, hardly]


def _hardly(here: View, smaller: Fit, candidate: Candidate) -> dict[str, float]:
    """Hardly anything of an effect, to begin with beside a smaller model."""
    member, size = here.table.members[candidate.name], candidate.size
    if member.column.direction is not None:
        return _begun(smaller, candidate, member.column.direction, np.full(member.rows.shape[1], HARDLY))
    at = here.fit.index(size.name)
    u = 0.0 if at is None else math.sqrt(float(here.fit.covariance[at, at]))
    return {size.name: size.null + HARDLY * math.copysign(u, here.fit.values.get(size.name, size.null) - size.null)}


def _begun(fit: Fit, candidate: Candidate, one: Direction, amounts: Array) -> dict[str, float]:
    """Values of a candidate with so much of its trial."""
    size = candidate.size
    if candidate.cause.spectral:
        pairs = [amounts[at : at + 2] for at in range(0, len(amounts), 2)]
        phase = candidate.parameters[2].name
        own = {f"{phase}@{way.partition('@')[2]}": math.atan2(cosine, sine)
               for way, (sine, cosine) in zip(one.ways[::2], pairs, strict=True)}  # fmt: skip
        mean = float(np.mean([math.hypot(*pair) for pair in pairs]))
        return {**one.values, size.name: one.amount * mean, **own}
    if one.ways:
        return {**one.values, **{way: one.amount * float(a) for way, a in zip(one.ways, amounts, strict=True)}}
    if one.stated is not None:
        return {}
    values = dict(one.values)
    origin = fit.values.get(size.name, size.null)
    total = size.amount(one.amount, float(amounts[0])) if origin == size.null == 0.0 else one.amount * amounts[0]
    values[size.name] = float(np.clip(origin + total, size.low, size.high))
    return values


def _shifted(here: View, candidates: Mapping[str, Candidate], values: dict[str, float], rows: Array) -> None:
    """Unknowns of the base where the straight line leads them beside these rows."""
    size = np.linalg.norm(here.line.base, axis=0)
    scaled = here.line.base / np.where(size > 0, size, 1.0)
    shift, *_ = np.linalg.lstsq(scaled, -(here.line.residual + rows), rcond=1e-12)
    shift = shift / np.where(size > 0, size, np.inf)
    places = base_places(here.fit, candidates)
    for place, moved in zip(places, shift, strict=True):
        entry = here.fit.problem.unknowns[place]
        values[entry.name] = float(np.clip(values[entry.name] + moved, entry.low, entry.high))
