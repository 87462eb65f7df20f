"""The measurement model of a whole campaign: all inputs, and all equations over them, in the order of evaluation.

One model for the campaign, not one a test: what two results share (g, a certificate, a section) then correlates them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol, TypeVar

from metrology.gum.evaluation import Contribution, Measurand
from metrology.gum.inputs import Ensemble, Input, Knowledge, Redrawn

if TYPE_CHECKING:
    from metrology.diagnosis import Diagnosis
    from metrology.timeseries import Trace


P = ParamSpec("P")
R = TypeVar("R")


class Memo(Protocol):
    """Calls a function, or returns what the same call returned before."""

    def __call__(self, function: Callable[P, R], /, *inputs: P.args, **named: P.kwargs) -> R:
        """Return ``function(*inputs, **named)``; calls that differ only in `progress` are the same."""


def call(function: Callable[P, R], /, *inputs: P.args, **named: P.kwargs) -> R:
    """Call a function every time, as a `Memo` does that keeps nothing.

    Parameters
    ----------
    function : callable
        To be called.
    *inputs, **named
        What it is given.

    Returns
    -------
    object
        What it returns.
    """
    return function(*inputs, **named)


@dataclass(frozen=True)
class Identity:
    """What a result belongs to and how it is shown; `headline` results stand on page 1."""

    quantity: str
    method: str
    sample: str = ""
    test: str = ""
    display_unit: str = ""
    headline: bool = True


@dataclass(frozen=True)
class HeldParameter:
    """A number that a fit holds exactly, since nobody stated how well it is known.

    Parameters
    ----------
    test, name, description, unit : str
        Test whose fit it is, parameter of the rig, in words, and SI unit.
    value : float
        As it is held, in SI.
    reach : float
        Half of the range in which such a number is met in a laboratory.
    slopes : mapping of str to float
        By result: its derivative by this number.
    advice : str
        What can be done about it, a sentence; where nothing is said, it can be stated with an uncertainty.
    """

    test: str
    name: str
    description: str
    unit: str
    value: float
    reach: float
    slopes: Mapping[str, float]
    advice: str = ""


@dataclass
class Model:
    """The model as it is built up, test by test; the one mutable value of the chain.

    `failed_fits`: why, by the name of the fit. `undiagnosed`: why, by the name of the test whose
    diagnosis or its model failed. `failures` and `warnings`: sentences for the reader of the report. `once`: makes the
    calls that take long and depend on nothing but what they are given. `judged`: whether models are verified.
    """

    inputs: dict[str, Input] = field(default_factory=dict)
    ensembles: list[Ensemble] = field(default_factory=list)
    correlations: dict[tuple[str, str], float] = field(default_factory=dict)
    redrawn: list[Redrawn] = field(default_factory=list)
    measurands: list[Measurand] = field(default_factory=list)
    identities: dict[str, Identity] = field(default_factory=dict)
    verification: list[dict[str, Any]] = field(default_factory=list)
    diagnosis: list[Diagnosis] = field(default_factory=list)
    failed_fits: dict[str, str] = field(default_factory=dict)
    undiagnosed: dict[str, str] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    traces: dict[str, Trace] = field(default_factory=dict)
    held: list[HeldParameter] = field(default_factory=list)
    once: Memo = call
    judged: bool = True

    def add_inputs(self, inputs: Iterable[Input]) -> None:
        """Add inputs; one that is there already is the same quantity, shared between results."""
        for quantity in inputs:
            self.inputs.setdefault(quantity.name, quantity)

    def add_measurand(self, measurand: Measurand, identity: Identity) -> None:
        """Add an equation over what the plan holds so far."""
        self.measurands.append(measurand)
        self.identities[measurand.name] = identity

    def add(self, part: Contribution) -> None:
        """Add inputs, ensembles and correlations of a test; its results come by `Task.add`."""
        self.add_inputs(part.inputs)
        self.ensembles.extend(part.ensembles)
        self.correlate(part.correlations)

    def exchange(self, old: Contribution, new: Contribution) -> None:
        """Put one contribution in the place of another.

        The results keep their names and their place in the order; what is new comes before them, and may stand for an
        input that the old one had.
        """
        # By identity: their covariances are arrays.
        gone = {id(one) for one in old.ensembles}
        self.ensembles = [*(one for one in self.ensembles if id(one) not in gone), *new.ensembles]
        self.correlations = {pair: r for pair, r in self.correlations.items() if pair not in old.correlations}
        self.correlate(new.correlations)
        replaced = {one.name for one in old.measurands}
        at = next(index for index, one in enumerate(self.measurands) if one.name in replaced)
        kept = [one for one in self.measurands[at:] if one.name not in replaced]
        self.measurands = [*self.measurands[:at], *new.measurands, *kept]
        names = {one.name for one in new.measurands}
        self.inputs |= {one.name: one for one in new.inputs}
        self.inputs = {name: one for name, one in self.inputs.items() if name not in names}

    def correlate(self, correlations: Mapping[tuple[str, str], float]) -> None:
        """Add stated correlation coefficients."""
        self.correlations.update(correlations)

    @property
    def names(self) -> frozenset[str]:
        """Names of everything that an expression can use."""
        return frozenset(self.inputs) | {measurand.name for measurand in self.measurands}

    def estimates(self) -> dict[str, float]:
        """Values of all inputs, and of every result that they give, without uncertainties."""
        found = {name: one.value for name, one in self.inputs.items()}
        for measurand in self.measurands:
            with suppress(ArithmeticError, ValueError, KeyError):
                found[measurand.name] = float(measurand.function(found))
        return found

    @property
    def knowledge(self) -> Knowledge:
        """The joint state of knowledge about all inputs."""
        return Knowledge(self.inputs, tuple(self.ensembles), self.correlations, tuple(self.redrawn))
