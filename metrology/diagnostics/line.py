"""A fit as a straight line in its unknowns and in the sizes of all candidates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.likelihood import Noise, spread_out
from metrology.diagnostics.residual_spectra import Spectrum, spectra_of
from metrology.diagnostics.span import CHUNK, Span, orthonormal, spanned
from metrology.diagnostics.subject import Array, Fit, Marks
from metrology.estimation.priors import WIDER


@dataclass(frozen=True)
class Column:
    """What a candidate adds to the straight line: its columns, and what it costs to have them.

    Parameters
    ----------
    effect : str
        Candidate, or the unlisted law.
    rows : ndarray, shape (n + p, q)
        Change of the stacked residuals (readings, then priors) for one unit of each coefficient.
    signed : bool
        Whether its size may have either sign; else the first coefficient, its amount, is not negative.
    direction : Direction or None
        The trial that it came from; None for an effect that the fit carries.
    """

    effect: str
    rows: Array
    signed: bool
    direction: Direction | None = None


@dataclass(frozen=True)
class Line:
    """A fit as a straight line in its unknowns and in the sizes of all candidates.

    Parameters
    ----------
    fit : Fit
        Where the line touches.
    noise : Noise
        By which it is weighted.
    base : ndarray, shape (n + p, b)
        Columns of the unknowns that belong to no effect; the rows after n are the priors.
    residual : ndarray, shape (n + p,)
        Residuals with all effects at their null, by the straight line.
    columns : tuple of Column
        Effects that the fit carries first, then the candidates in all their shapes.
    count : int
        Readings with weight.
    """

    fit: Fit
    noise: Noise
    base: Array
    residual: Array
    columns: tuple[Column, ...]
    count: int

    @cached_property
    def basis(self) -> Array:
        """Orthonormal columns that span the base."""
        return orthonormal(self.base)

    @cached_property
    def explained(self) -> tuple[Span, Array]:
        """Span of everything in the line, and the residual beside it."""
        return self.explained_with(())

    def explained_with(self, extra: Sequence[Array]) -> tuple[Span, Array]:
        """Return the same of everything in the line together with further columns, shape (n + p, q) each."""
        taken = spanned((self.base, *(one.rows for one in self.columns), *extra))
        return taken, self.residual - taken.part(self.residual)

    @cached_property
    def spectra(self) -> tuple[Spectrum, ...]:
        """Spectra of the residual beside all that is in the line, for each channel of each block."""
        return spectra_of(self.fit, *self.explained)

    @cached_property
    def left(self) -> tuple[Array, ...]:
        """Rows of each column less their part within the base."""
        if not self.columns:
            return ()
        widths = np.cumsum([one.rows.shape[1] for one in self.columns])[:-1]
        whole = np.asfortranarray(np.hstack([one.rows for one in self.columns]))
        return tuple(np.split(self._reduced(whole), widths, axis=1))

    def with_misfit(self, factor: float) -> Line:
        """Return the same line with another λ: readings weigh less by its root, priors as before."""
        weight = np.ones(len(self.residual))
        weight[: len(weight) - len(self.fit.theta)] = math.sqrt(self.noise.misfit / factor)
        columns = tuple(replace(one, rows=weight[:, None] * one.rows) for one in self.columns)
        by = replace(self.noise, misfit=factor)
        return replace(
            self, noise=by, base=weight[:, None] * self.base, residual=weight * self.residual, columns=columns
        )

    def beside(self, rows: Array) -> Array:
        """What the base leaves of rows."""
        return self._reduced(np.array(rows))

    def _reduced(self, rows: Array) -> Array:
        """Rows less their part within the base, in place; twice, since rounding leaves some of it."""
        for _ in range(2):
            amounts = self.basis.T @ rows
            for first in range(0, len(rows), CHUNK):
                rows[first : first + CHUNK] -= self.basis[first : first + CHUNK] @ amounts
        return rows


def line(
    fit: Fit, candidates: Mapping[str, Candidate], directions: Sequence[Direction], by: Noise, used: Sequence[Marks]
) -> Line:
    """Straight line through a fit with all candidate directions, in the metric of the noise.

    Parameters
    ----------
    fit : Fit
        Model with the effects that it carries.
    candidates : mapping of str to Candidate
        The table.
    directions : sequence of Direction
        What the other candidates would do.
    by : Noise
        Colour and misfit.
    used : sequence of ndarray of bool
        Readings that count.
    """
    root = 1.0 / math.sqrt(by.misfit)
    J = root * by.whitened(fit, spread_out(fit), used)
    r = root * by.whitened(fit, fit.full, used)
    stated = {name: stated_places(fit, candidates[name]) for name in fit.effects}
    precision = np.sqrt(fit.problem.precision)
    # An input that the fit has freed is known as stated where its effect is left out.
    precision[[at for places in stated.values() for at in places]] *= WIDER
    J = np.vstack([J, np.diag(precision)])
    r = np.concatenate([r, precision * (fit.theta - fit.problem.mean)])
    own, columns = np.zeros(len(fit.theta), dtype=bool), []
    for name in fit.effects:
        places, null = effect_places(fit, candidates[name])
        own[places] = True
        rows = np.hstack([J[:, places], *(_freed(len(r), len(precision), at, precision) for at in stated[name])])
        columns.append(Column(name, rows, candidates[name].signed))
        # An effect that goes with a power of its size is gone along its slope after one part in that power.
        powers = np.array([_power(fit, place, candidates[name]) for place in places])
        seen = powers > 0
        r = r + rows[:, : len(places)][:, seen] @ ((null - fit.theta[places])[seen] / powers[seen])
    for one in directions:
        data = root * by.whitened(fit, tuple(part.reshape(len(part), -1) for part in one.rows), used)
        columns.append(_tried(one, data, precision, signed=candidates[one.effect].signed))
    count = int(sum(marks.sum() for marks in used))
    return Line(fit, by, J[:, ~own], r, tuple(columns), count)


def effect_places(fit: Fit, one: Candidate) -> tuple[list[int], Array]:
    """Unknowns that belong to an effect and would not be sought without it, and their nulls."""
    null = {size.name: size.null for size in one.parameters}
    own = {size.name for size in one.parameters if size.own}
    places = [
        at
        for at, entry in enumerate(fit.problem.unknowns)
        if (name := entry.name.split("@")[0]) in null and (entry.u is None or name in own)
    ]
    return places, np.array([null[fit.problem.unknowns[at].name.split("@")[0]] for at in places])


def base_places(fit: Fit, candidates: Mapping[str, Candidate]) -> list[int]:
    """Unknowns that belong to no effect: the columns of the base of a line, in their order."""
    own = {place for name in fit.effects for place in effect_places(fit, candidates[name])[0]}
    return [at for at in range(len(fit.theta)) if at not in own]


def stated_places(fit: Fit, one: Candidate) -> list[int]:
    """Inputs with a stated uncertainty that an effect frees: what it adds is a shift of the mean of their prior."""
    names = {size.name for size in one.parameters}
    return [at for at, entry in enumerate(fit.problem.unknowns) if entry.name in names and entry.u is not None]


def _freed(count: int, priors: int, at: int, precision: Array) -> Array:
    """Column of such a shift: no reading sees it."""
    found = np.zeros((count, 1))
    found[count - priors + at] = -precision[at]
    return found


def _power(fit: Fit, place: int, one: Candidate) -> int:
    """Power of a size with which its effect grows; 0 for a shape."""
    name = fit.problem.unknowns[place].name.split("@")[0]
    return next((size.power for size in one.parameters if size.name == name and not size.shape), 0)


def _tried(one: Direction, data: Array, precision: Array, *, signed: bool) -> Column:
    if one.stated is not None:
        # Freedom of a prior is a shift of its mean, which no reading sees.
        data = np.zeros((len(data), 1))
    priors = np.zeros((len(precision), data.shape[1]))
    if one.stated is not None:
        priors[one.stated, 0] = -one.amount * precision[one.stated]
    rows = np.vstack([data, priors])
    return Column(one.effect, rows, signed or rows.shape[1] > 1, one)
