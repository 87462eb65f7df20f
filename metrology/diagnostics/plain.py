"""A subject of diagnosis made of plain functions: readings in blocks, unknowns, and a model that predicts a block."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from metrology.coordinate import QUANTITIES
from metrology.diagnosis import Missing, Picture
from metrology.diagnostics.block_trials import Trial, moved_rows, overlay
from metrology.diagnostics.blocks import Readings, block_of, own_unknown, unknown_of
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.subject import Array, Fit, Marks, Slow, rounded
from metrology.estimation import Block, Prior, Problem, Unknown, solve
from metrology.estimation.problem import evaluate

CLOSE = 3e-3
"""Length of the last step of a fit, in standard uncertainties: no digit that a report prints is lost."""


GAIN = "gain"
"""What the reading of a motion is multiplied by."""
UNITS = {one.word: one.unit for words in QUANTITIES.values() for one in words.values()} | {"extension": "m", GAIN: "1"}
"""Unit of each word by which an unlisted law is named."""
FAR = 0.3
"""Root mean square of what is left over that of the motion, from which on a straight line says nothing: cos of a phase
that is off by so much is no longer straight in it."""


@dataclass(frozen=True)
class Plain:
    """Readings in blocks and a function that predicts them.

    Parameters
    ----------
    sample, method : str
        For the result.
    candidates : mapping of str to Candidate
        Closed table.
    blocks : tuple of Readings
        Repeats, releases.
    common : tuple of Unknown
        Unknowns of all blocks.
    own : tuple of tuple of Unknown
        Unknowns of each block, named ``'zero@block'``.
    predict : callable
        Takes the number of a block and the values by plain name (without ``@block``, effects at their null left out);
        returns the readings that the model gives, or None.
    trials : mapping of str to sequence of Trial
        How each candidate is tried.
    reasons : mapping of str to str
        Candidates that cannot be tested with these data, and why.
    gap : callable, optional
        Takes the number of a block and its residuals; returns columns to look at what is missing against.
    drawn : callable, optional
        Takes the base fit and the extended one, None without; returns pictures.
    sweep : callable, optional
        As `predict` for many values at once, where that is quicker.
    slopes : callable, optional
        Takes the number of a block, the values and its unknowns; returns the derivatives of the readings, shape
        (p, n), or None. Without it they are central differences.
    beginnings : tuple of Plain
        The same on growing first parts of every block, to which a model that begins far off is fitted before it is
        fitted to all. A model without them is straight in its unknowns and cannot lose the readings.
    dear : float
        What a derivative costs over one of a usual test of response.
    suggested : callable, optional
        Takes effects; returns values to begin from where a model begins far off.
    floor : float
        Level, over that stated with the readings, below which their noise is not estimated.
    is_scarce : bool
        Whether readings are so few that their noise is white and its size estimated with the rest.
    has_repeats : bool
        Whether the blocks are repeats, which differ by chance alone; the parts of one record are none.
    scatters : mapping of str to float
        Standard deviation among the blocks of a size that every block has for itself, by the readings: what departs
        from the mean of the blocks, and is not an amount of its own.
    slow, priors : tuple
        What each block is given for a slow motion; what is stated within an uncertainty and sought again: nothing.
    forms : callable
        Takes a fit; returns the unlisted laws.
    acts_in : callable
        Takes a fit, an effect and the standard uncertainties of the unknowns; returns in which blocks it acts.
    equivalents : callable
        Takes a fit and one of its effects; returns the cause that does the same to the readings and the values with it,
        or None.
    """

    sample: str
    method: str
    candidates: Mapping[str, Candidate]
    blocks: tuple[Readings, ...]
    common: tuple[Unknown, ...]
    own: tuple[tuple[Unknown, ...], ...]
    predict: Callable[[int, Mapping[str, float]], Array | None]
    trials: Callable[[str, Fit], Sequence[Trial]]
    reasons: Mapping[str, str] = field(default_factory=dict)
    gap: Callable[[Fit], Missing | None] = lambda _fit: None
    drawn: Callable[[Fit, Fit | None], tuple[Picture, ...]] = lambda _before, _after: ()
    sweep: Callable[[int, Sequence[Mapping[str, float]]], Sequence[Array | None]] | None = None
    slopes: Callable[[int, Mapping[str, float], Sequence[Unknown]], Array | None] | None = None
    beginnings: tuple[Plain, ...] = ()
    dear: float = 1.0
    suggested: Callable[[Sequence[str]], Mapping[str, float]] = lambda _effects: {}
    floor: float = 0.0
    is_scarce: bool = False
    has_repeats: bool = True
    scatters: Mapping[str, float] = field(default_factory=dict)
    slow: tuple[Slow, ...] = ()
    priors: tuple[Prior, ...] = ()
    forms: Callable[[Fit], Sequence[Direction]] = lambda _fit: ()
    acts_in: Callable[[Fit, str, Array], str] = lambda _fit, _name, _spread: ""
    equivalents: Callable[[Fit, str], tuple[str, Mapping[str, float]] | None] = lambda _fit, _name: None

    # ---- fits ---------------------------------------------------------------------------------------------------
    def unknowns(self, effects: Sequence[str], values: Mapping[str, float]) -> tuple[Unknown, ...]:
        """Common ones, those of the effects, then each block's own."""
        found = list(self.common)
        for name in effects:
            for size in self.candidates[name].parameters:
                if size.held:
                    continue
                if size.own:
                    found += [own_unknown(size, data.name, self.scatters.get(size.name)) for data in self.blocks]
                    continue
                found.append(unknown_of(size))
        found += [entry for own in self.own for entry in own]
        return tuple(
            replace(entry, start=float(np.clip(values.get(entry.name, entry.start), entry.low, entry.high)))
            for entry in found
        )

    @property
    def count(self) -> int:
        """Readings of all blocks."""
        return sum(len(data.y) for data in self.blocks)

    def problem(self, effects: Sequence[str], values: Mapping[str, float]) -> Problem:
        """Weighted problem of the model with these effects; shapes that are not sought come from `values`."""
        unknowns = self.unknowns(effects, values)
        names = {size.name for name in effects for size in self.candidates[name].parameters}
        fixed = {name: values[name] for name in names if name in values and all(one.name != name for one in unknowns)}
        blocks = (self._block(at, unknowns, fixed) for at in range(len(self.blocks)))
        return Problem(unknowns, tuple(blocks))

    def _block(self, at: int, unknowns: tuple[Unknown, ...], fixed: Mapping[str, float]) -> Block:
        slopes = None if self.slopes is None else partial(self.slopes, at)
        return block_of(self.blocks[at], unknowns, fixed, partial(self.sweep or self._one_by_one, at), slopes)

    def _one_by_one(self, at: int, many: Sequence[Mapping[str, float]]) -> list[Array | None]:
        return [self.predict(at, values) for values in many]

    def _begun(self, effects: tuple[str, ...], values: Mapping[str, float]) -> tuple[Problem, float]:
        """Problem with starts that fit: where these are far off, from growing parts of the blocks.

        With the derivatives that it took, in those of whole blocks.
        """
        posed, steps = self.problem(effects, values), 0.0
        point = evaluate(posed, posed.start)
        if not self.beginnings or (point is not None and not self._is_far(point.residuals)):
            return posed, steps
        if point is None:
            # What the straight line suggests runs away: begin without the effects.
            nulls = {
                size.name: size.null for name in effects for size in self.candidates[name].parameters if not size.own
            }
            values = {**values, **nulls}
        values = {**values, **self.suggested(effects)}
        for beginning in self.beginnings:
            solution = solve(beginning.problem(effects, values), close=0.1, steps=15)
            steps += solution.steps * beginning.count / self.count
            if solution.point is None:
                return posed, steps
            sought = {entry.name: float(one) for entry, one in zip(posed.unknowns, solution.point.theta, strict=True)}
            values = {**values, **sought}
        grown = self.problem(effects, values)
        there = evaluate(grown, grown.start)
        return posed if there is None or (point is not None and there.cost > point.cost) else grown, steps

    def is_far(self, effects: tuple[str, ...], values: Mapping[str, float]) -> bool:
        """Whether the model with these values has nothing to do with the readings."""
        posed = self.problem(effects, values)
        point = evaluate(posed, posed.start)
        return point is None or self._is_far(point.residuals)

    def glance(self, effects: tuple[str, ...], values: Mapping[str, float]) -> tuple[float, float]:
        """Cost for each reading of the first part of the blocks, fitted from what their motion suggests."""
        beginning = next(iter(self.beginnings), self)
        posed = beginning.problem(effects, {**values, **self.suggested(effects)})
        solution = solve(posed, close=0.1, steps=15)
        found = math.inf if solution.point is None else solution.point.cost / posed.count
        return found, solution.steps * self.dear * beginning.count / self.count

    def fit(self, effects: tuple[str, ...], starts: Sequence[Mapping[str, float]]) -> Fit | None:
        """Best of the optima from these starts."""
        best: Fit | None = None
        steps = 0.0
        # A law in the place of another was not tried by the straight line, place by place.
        first = {size.name: size.null for name in effects for size in self.candidates[name].parameters if size.held}
        for begun in map(rounded, starts or ({},)):
            values = {**first, **begun}
            posed, before = self._begun(effects, values)
            solution = solve(posed, close=CLOSE, steps=40)
            steps += before + solution.steps
            point, here = solution.point, solution.slope
            if point is None or here is None or solution.status == "failed":
                continue
            used = tuple(np.ones(len(part), dtype=bool) for part in point.residuals)
            found = Fit(
                effects, posed, point.theta, point.residuals, here.blocks, here.information, point.penalty,
                point.residuals, used, self._held(effects, posed, values), dear=self.dear,
            )  # fmt: skip
            if best is None or found.cost < best.cost:
                best = found
        return None if best is None else replace(best, steps=steps)

    def finished(self, fit: Fit) -> Fit:
        """Return a fit carried on to its last digit."""
        return fit.finished(lambda point: point.residuals)

    def _held(self, effects: tuple[str, ...], posed: Problem, values: Mapping[str, float]) -> dict[str, float]:
        """Shapes of the effects that are not sought, as the fit had them."""
        sought = {entry.name for entry in posed.unknowns}
        names = (size.name for name in effects for size in self.candidates[name].parameters)
        return {name: values[name] for name in names if name in values and name not in sought}

    def equivalent(self, fit: Fit, name: str) -> tuple[str, Mapping[str, float]] | None:
        """Another cause that does the same to the readings, and the values with it; None without one."""
        return self.equivalents(fit, name)

    def families(self, fit: Fit) -> Sequence[Direction]:
        """Unlisted laws of any form."""
        return self.forms(fit)

    def unit_of(self, family: str) -> str:
        """SI unit of an unlisted law."""
        return UNITS[family.removeprefix("fine ").partition(" of ")[0]]

    def where(self, fit: Fit, name: str, spread: Array) -> str:
        """In which blocks an effect acts."""
        return self.acts_in(fit, name, spread)

    def loses(self, fit: Fit) -> bool:
        """Whether a fit is so far from the readings that a straight line through it says nothing."""
        return bool(self.beginnings) and self._is_far(fit.full)

    def _is_far(self, residuals: Sequence[Array]) -> bool:
        squares = sum(float(np.sum(part**2)) for part in residuals)
        whole = sum(float(np.sum(((data.y - data.y.mean()) / data.u) ** 2)) for data in self.blocks)
        return squares > FAR**2 * whole

    # ---- directions ---------------------------------------------------------------------------------------------
    def directions(self, fit: Fit, effects: Sequence[str]) -> Sequence[Direction]:
        """Every candidate in all its shapes."""
        found = []
        for name in effects:
            if name in self.reasons or name in fit.effects:
                continue
            size = self.candidates[name].size
            for trial in self.trials(name, fit):
                if size.own:
                    found.append(overlay(self.blocks, self.predict, fit, self.candidates[name], trial, self.scatters))
                    continue
                values = {**trial.shapes, size.name: size.null + trial.amount}
                rows = moved_rows(self.blocks, self.predict, fit, values)
                if rows is not None:
                    found.append(Direction(name, values, trial.amount, rows, trial.looks))
        return found

    # ---- what is reported ---------------------------------------------------------------------------------------
    def untestable(self) -> Mapping[str, str]:
        """Candidates that these data cannot test, with the reason."""
        return self.reasons

    def missing(self, fit: Fit) -> Missing | None:
        """What is missing, without a model."""
        return self.gap(fit)

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """What makes a cause visible."""
        return self.drawn(before, after)

    def parts(self, _fit: Fit) -> Mapping[tuple[str, str], Sequence[tuple[str, Marks]]]:
        """Parts of each block, as stated with the readings."""
        found: dict[tuple[str, str], Sequence[tuple[str, Marks]]] = {}
        for data in self.blocks:
            for one in data.segments():
                whole = [("all", np.ones(one.last - one.first, dtype=bool))]
                found[data.name, one.name] = data.phases or whole
        return found

    def extended(self, fit: Fit) -> Mapping[str, float]:
        """Values of the parameters of the effects."""
        names = [size.name for name in fit.effects for size in self.candidates[name].parameters]
        return {name: {**fit.shapes, **fit.values}[name] for name in names if name in {**fit.shapes, **fit.values}}
