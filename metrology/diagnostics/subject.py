"""A model, its candidate effects, some data: what the engine asks of whatever is to be diagnosed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from metrology.diagnosis import Missing, Picture
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.estimation import Prior, Problem
from metrology.estimation.covariance import bread_of
from metrology.estimation.problem import Point
from metrology.estimation.solver import finished

Array = NDArray[np.float64]
Marks = NDArray[np.bool_]
Blocks = tuple[Array, ...]
LOST = 10.0
"""χ² for each reading beyond which a model loses the motion: what comes late leads nowhere, and scores say nothing."""


@dataclass(frozen=True)
class Fit:
    """A model with some effects, fitted.

    Parameters
    ----------
    effects : tuple of str
        Candidates that it carries.
    problem : Problem
        As it was weighted at the optimum.
    theta : ndarray, shape (p,)
        The optimum.
    residuals, slopes : tuple of ndarray
        Whitened residuals and their derivatives, block by block.
    information : ndarray, shape (p, p)
        JᵀJ + P.
    penalty : float
        What the priors cost.
    full : tuple of ndarray
        Whitened residuals of all readings, those without weight as well.
    used : tuple of ndarray of bool
        Readings with weight.
    shapes : mapping of str to float
        Parameters of the effects that the fit held, such as the place of a slip.
    spent : bool
        Whether the search used up its steps before it converged.
    steps : float
        Derivatives that the search took, in those of whole blocks.
    dear : float
        What one of them costs over one of the cheapest model, counted, so that it is the same on every machine.
    """

    effects: tuple[str, ...]
    problem: Problem
    theta: Array
    residuals: Blocks
    slopes: Blocks
    information: Array
    penalty: float
    full: Blocks
    used: tuple[Marks, ...]
    shapes: Mapping[str, float] = field(default_factory=dict)
    spent: bool = False
    steps: float = 0
    dear: float = 1.0

    @property
    def chi_squared(self) -> float:
        """Of the readings."""
        return float(sum(part @ part for part in self.residuals))

    @property
    def cost(self) -> float:
        """χ² of readings and priors."""
        return self.chi_squared + self.penalty

    @property
    def mean_cost(self) -> float:
        """Cost for each reading with weight: fits that give weight to different readings are compared by it."""
        return self.cost / self.count

    @property
    def count(self) -> int:
        """Readings with weight."""
        return int(sum(marks.sum() for marks in self.used))

    @property
    def values(self) -> dict[str, float]:
        """Unknowns by name, and the shapes that were held."""
        sought = {entry.name: float(value) for entry, value in zip(self.problem.unknowns, self.theta, strict=True)}
        return {**self.shapes, **sought}

    @property
    def gradient(self) -> Array:
        """JᵀR + P(θ − μ), shape (p,): what the search left of it; 0 where an unknown is pressed against a bound."""
        problem, theta = self.problem, self.theta
        found: Array = problem.precision * (theta - problem.mean)
        for block, part, residual in zip(problem.blocks, self.slopes, self.residuals, strict=True):
            np.add.at(found, np.array(block.uses), part.T @ residual)
        found[((theta <= problem.low) & (found > 0)) | ((theta >= problem.high) & (found < 0))] = 0.0
        return found

    @cached_property
    def covariance(self) -> Array:
        """Inverse of the information, shape (p, p)."""
        return bread_of(self.problem, self.slopes)

    @cached_property
    def unfinished(self) -> float:
        """What one more step promises to take off the cost: 0 at an optimum, however far one is."""
        return float(self.gradient @ self.covariance @ self.gradient)

    @cached_property
    def free(self) -> float:
        """Readings less the unknowns that they determine: those without a prior whole, others as far as beyond it."""
        C, unknowns = self.covariance, self.problem.unknowns
        taken = (
            1.0 if entry.u is None else max(1.0 - float(C[at, at]) / entry.u**2, 0.0)
            for at, entry in enumerate(unknowns) if entry.scale > 0
        )  # fmt: skip
        return self.count - math.fsum(taken)

    def finished(self, full: Callable[[Point], Blocks]) -> Fit:
        """Return the fit carried on to its last digit; `full` gives the residuals of all readings at its end."""
        end = finished(self.problem, self.theta)
        if end is None:
            return self
        point, here = end
        return replace(
            self, theta=point.theta, residuals=point.residuals, slopes=here.blocks, information=here.information,
            penalty=point.penalty, full=full(point),
        )  # fmt: skip

    def index(self, name: str) -> int | None:
        """Place of an unknown, None where it is not sought."""
        return next((at for at, entry in enumerate(self.problem.unknowns) if entry.name == name), None)


def rounded(values: Mapping[str, float]) -> dict[str, float]:
    """Values to start from, to six digits: what a straight line promises has others on every processor below that.

    Two searches from one start take the same way, and end at the same last digit.
    """
    return {name: float(f"{value:.5e}") for name, value in values.items()}


@dataclass(frozen=True)
class Slow:
    """What a block is given for a slow motion under its readings, whether it has one or not.

    `names`: its unknowns, from what is steady on; `count`: readings of the block; `rounding`: by what rounding alone
    their means are off.
    """

    names: tuple[str, ...]
    count: int
    rounding: float

    def places(self, fit: Fit) -> list[int]:
        """Places of those that a fit has."""
        return [at for at in (fit.index(name) for name in self.names) if at is not None]


class Subject(Protocol):
    """A model, its candidate effects, some data."""

    @property
    def sample(self) -> str:
        """Id of the sample."""

    @property
    def method(self) -> str:
        """Method of the laboratory: response, decay, elongation."""

    @property
    def candidates(self) -> Mapping[str, Candidate]:
        """Closed table of causes."""

    def fit(self, effects: tuple[str, ...], starts: Sequence[Mapping[str, float]]) -> Fit | None:
        """Fit the model with these effects from each start (values by name); None where none converges."""

    def finished(self, fit: Fit) -> Fit:
        """Return a fit carried on to the last digit: what is said of it is then the same on every processor."""

    def directions(self, fit: Fit, effects: Sequence[str]) -> Sequence[Direction]:
        """What each of these candidates would do, in one or several shapes."""

    @property
    def floor(self) -> float:
        """Level, over that stated with the readings, below which their noise is not estimated."""

    @property
    def is_scarce(self) -> bool:
        """Whether readings are so few that their noise is white and its size estimated with the rest."""

    @property
    def has_repeats(self) -> bool:
        """Whether the blocks are repeats, which differ by chance alone; the parts of one record are none."""

    @property
    def scatters(self) -> Mapping[str, float]:
        """Standard deviation among the blocks, by the readings, of what every block has for itself, by name."""

    @property
    def priors(self) -> Sequence[Prior]:
        """What is stated within an uncertainty, and sought again with the model."""

    @property
    def slow(self) -> Sequence[Slow]:
        """What each block is given for a slow motion; none where the model has no such thing."""

    def equivalent(self, fit: Fit, name: str) -> tuple[str, Mapping[str, float]] | None:
        """Another cause that does exactly what an effect of a fit does, and the values with it; None without one."""

    def families(self, fit: Fit) -> Sequence[Direction]:
        """Unlisted laws: a column for every place where the law has a size of its own, in the unit of `amount`."""

    def unit_of(self, family: str) -> str:
        """SI unit of an unlisted law."""

    def is_far(self, effects: tuple[str, ...], values: Mapping[str, float]) -> bool:
        """Whether the model with these effects and values has nothing to do with the readings."""

    def glance(self, effects: tuple[str, ...], values: Mapping[str, float]) -> tuple[float, float]:
        """Cost for each reading of a model that is fitted to the first moments alone, and the derivatives that it took.

        It compares models where no straight line does. The fit begins with a usual amount of each effect, in the shapes
        of `values`; its cost is infinite without an answer.
        """

    def where(self, fit: Fit, name: str, spread: Array) -> str:
        """In which blocks an effect of a fit acts, in words that end with a full stop; empty where in all alike.

        `spread`: standard uncertainty of every unknown.
        """

    def loses(self, fit: Fit) -> bool:
        """Whether a fit is so far from the readings that a straight line through it says nothing."""

    def untestable(self) -> Mapping[str, str]:
        """Candidates that these data cannot test at all, with the reason."""

    def missing(self, fit: Fit) -> Missing | None:
        """What is missing, estimated without a model; None where the data do not allow it."""

    def parts(self, fit: Fit) -> Mapping[tuple[str, str], Sequence[tuple[str, Marks]]]:
        """Phases of each block and channel, as (name, marks of its readings within the segment)."""

    def extended(self, fit: Fit) -> Mapping[str, float]:
        """Values of the model that carries these effects, as a campaign's `model:` block takes them."""

    def pictures(self, before: Fit, after: Fit | None) -> tuple[Picture, ...]:
        """What makes a cause visible: with the model as it stands, and with the extended one where there is one."""
