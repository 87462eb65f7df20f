"""Stated inputs that a diagnosis refutes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from metrology.diagnostics.judged import Judged
from metrology.diagnostics.search import EQUAL
from metrology.estimation import Prior
from metrology.estimation.fit import CONTRADICTED
from metrology.estimation.priors import input_of


def refuted(judged: Judged, priors: Sequence[Prior]) -> Iterator[str]:
    """Stated inputs, of all runs or of one, that the extended model, or one that does as well, moves too far.

    By what is stated, also of an input that is named as the cause, whose prior is wider there.
    """
    known, found = {one.name: one for one in priors}, set()
    as_well = [fit for fit, more in judged.exchanged.values() if more > -EQUAL]
    for fit in (judged.last, *as_well):
        for entry in fit.problem.unknowns:
            name, _, run = entry.name.partition("@")
            prior = known.get(name)
            u = 0.0 if prior is None else prior.per_run if run else prior.common
            moved = 0.0 if entry.mean is None else abs(fit.values[entry.name] - entry.mean)
            if moved > CONTRADICTED * u > 0 and entry.name not in found:
                found.add(entry.name)
                yield input_of(name, run)
