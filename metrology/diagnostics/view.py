"""A fit as the search sees it: its straight line in the metric of the noise, and the sets of effects around it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.likelihood import Noise, noise
from metrology.diagnostics.line import Line, line
from metrology.diagnostics.misfit import misfit, narrow
from metrology.diagnostics.sets import Set
from metrology.diagnostics.span import orthonormal
from metrology.diagnostics.subject import Array, Fit, Subject
from metrology.diagnostics.table import Score, Table, scores, table


@dataclass(frozen=True)
class View:
    """A fit, its straight line in the metric of the noise, and the evidence of the sets around it."""

    fit: Fit
    line: Line
    table: Table
    evidence: Mapping[Set, float]
    compared: dict[int, tuple[Fit, float]] = field(default_factory=dict, repr=False, compare=False)
    """Ln evidence over it of the fits that were compared with it, each kept so that its identity stays its own."""

    @property
    def noise(self) -> Noise:
        """Colour of every channel and the factor of the misfit."""
        return self.line.noise

    @cached_property
    def scores(self) -> dict[str, Score]:
        """Every candidate alone beside the fit."""
        return scores(self.line)

    @property
    def effects(self) -> Set:
        """Effects that the fit carries."""
        return frozenset(self.fit.effects)


def view_of(fit: Fit, subject: Subject, directions: Sequence[Direction], base: Fit, rounding: float) -> View:
    """View of a fit with these directions.

    Parameters
    ----------
    fit : Fit
        Where the line touches.
    subject : Subject
        Model, candidates, data.
    directions : sequence of Direction
        What the other candidates would do.
    base : Fit
        Without effects.
    rounding : float
        Cost that rounding of few readings leaves of any model.
    """
    candidates = subject.candidates
    if subject.is_scarce:
        scarce = line(fit, candidates, directions, Noise({}), fit.used)
        few = replace(table(scarce, candidates, free=base.free), rounding=rounding)
        return View(fit, scarce, few, _evidence(fit, few))
    by = noise(fit, *_left(fit, candidates, directions, subject.floor))
    plain = line(fit, candidates, directions, by, fit.used)
    own = [one for one in plain.columns if one.direction is None]
    # What is left about the frequency of a line is no misfit elsewhere.
    sought = np.hstack([plain.base, *(one.rows for one in own if not candidates[one.effect].is_line)])
    factor = misfit(plain, sought)
    beside = narrow(plain, [one.rows for one in plain.columns if candidates[one.effect].is_line], factor)
    if beside:
        plain = line(fit, candidates, directions, replace(by, narrow=beside), fit.used)
    scaled = plain.with_misfit(factor)
    among = table(scaled, candidates)
    return View(fit, scaled, among, _evidence(fit, among))


def _evidence(fit: Fit, formed: Table) -> dict[Set, float]:
    """Ln evidence of every set around a fit, and of its own also where no search would form it."""
    own = frozenset(fit.effects)
    return {own: formed.log_evidence(own)} | formed.all()


def _left(
    fit: Fit, candidates: Mapping[str, Candidate], directions: Sequence[Direction], floor: float
) -> tuple[tuple[Array, ...], float, Array]:
    """What `noise` takes: residuals of every block that the fit and all candidates leave, and what took them."""
    plain = line(fit, candidates, directions, Noise({}), fit.used)
    taken = orthonormal(np.hstack([plain.base, *(one.rows for one in plain.columns)]))
    left = plain.residual - taken @ (taken.T @ plain.residual)
    bounds = np.cumsum([0, *(len(part) for part in fit.residuals)])
    return tuple(left[first:last] for first, last in pairwise(bounds)), floor, taken
