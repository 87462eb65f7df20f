"""What must hold for the stated correlations of a campaign: between inputs, each pair once, possible together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal, mean

if TYPE_CHECKING:
    from metrology.campaign.names import Names
    from metrology.campaign.schema import Campaign

_SINGULAR = 1e-12


def _inputs(campaign: Campaign) -> dict[str, bool]:
    """Names that a correlation may have, with whether they have an uncertainty."""
    known = {name: not stated.is_exact for name, stated in campaign.quantities.items()}
    for name, sample in campaign.samples.items():
        known |= {f"{name}.{key}": not stated.is_exact for key, stated in sample.properties.items()}
    for name, instrument in campaign.instruments.items():
        if instrument.correction is not None and instrument.correction.value is not None:
            known[f"{name}.correction"] = not instrument.correction.value.is_exact
    return known


def check_correlations(campaign: Campaign, names: Names) -> Iterator[Refusal]:
    """Everything that is wrong with the stated correlations, with places from the root of the file."""
    known = _inputs(campaign)
    members = {member for ensemble in campaign.ensembles.values() for member in ensemble.columns}
    pairs: dict[frozenset[str], float] = {}
    faulty = False
    for index, correlation in enumerate(campaign.correlations):
        pair = frozenset(correlation.between)
        wrong = [
            *(
                _member(name, known, members, names, ("correlations", index, "between", side))
                for side, name in enumerate(correlation.between)
            ),
            _pair(pair, pairs, ("correlations", index, "between")),
        ]
        pairs.setdefault(pair, correlation.coefficient)
        faulty = faulty or any(wrong)
        yield from filter(None, wrong)
    if pairs and not faulty:
        yield from _positive(pairs)


def _member(name: str, known: dict[str, bool], members: set[str], names: Names, place: Place) -> Refusal | None:
    if name in members:
        return Refusal(
            place, f"'{name}', a quantity of an ensemble", "quantities whose correlation the readings do not give"
        )
    if name in known:
        return None if known[name] else Refusal(place, f"'{name}', a constant", "a quantity with an uncertainty")
    if name in names.dimensions:
        return Refusal(place, f"'{name}', a result", "input quantities; correlations of results are computed")
    near = mean(name, list(known)) or (
        f"known are {', '.join(list(known)[:12])}" if known else "no quantity is declared"
    )
    return Refusal(
        place, f"'{name}', an unknown quantity", "the name of an input quantity of this campaign", near, name
    )


def _pair(pair: frozenset[str], pairs: dict[frozenset[str], float], place: Place) -> Refusal | None:
    if len(pair) == 1:
        return Refusal(place, f"'{next(iter(pair))}' with itself", "two quantities")
    return Refusal(place, "a pair of quantities a second time", "every pair once") if pair in pairs else None


def _positive(pairs: dict[frozenset[str], float]) -> Iterator[Refusal]:
    order = sorted(set().union(*pairs))
    matrix = np.eye(len(order))
    for pair, coefficient in pairs.items():
        i, j = (order.index(name) for name in pair)
        matrix[i, j] = matrix[j, i] = coefficient
    least = np.linalg.eigvalsh(matrix)[0]
    if least > _SINGULAR:
        return
    got = f"coefficients between {', '.join(order)} that no quantities can have together"
    fix = "correct a coefficient"
    if least > -_SINGULAR:
        got = f"coefficients between {', '.join(order)} by which one is known from the others"
        fix = "where quantities share their whole uncertainty, state one and use it in both places"
    yield Refusal(("correlations",), got, "a correlation matrix that is positive definite", fix)
