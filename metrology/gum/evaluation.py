"""What an evaluation of a measurement model yields: estimates with budget, coverage, Monte Carlo and correlations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import isfinite, isinf
from typing import TYPE_CHECKING, Annotated, Any

from metrology.doc import Doc
from metrology.gum.intervals import Kind

if TYPE_CHECKING:
    from metrology.gum.inputs import Ensemble, Input
    from metrology.gum.output import Output

Floats = tuple[float, ...]


@dataclass(frozen=True)
class Measurand:
    """One equation of a measurement model: an output quantity as a function of inputs and of earlier outputs.

    Parameters
    ----------
    name : str
        Unique name within the campaign, such as ``"al-1100-elongation.k"``.
    function : callable
        Takes a mapping of name to quantity and returns the quantity in SI. It is called with ``uncertainties``
        variables (law of propagation) and with arrays of draws (Monte Carlo): arithmetic and the functions of
        `metrology.gum.functions` serve both.
    unit : str
        SI unit written out, such as ``"N/m"``.
    equation : str
        The equation as the report prints it.
    """

    name: str
    function: Callable[[Mapping[str, Any]], Any]
    unit: str = "1"
    equation: str = ""


@dataclass(frozen=True)
class Contribution:
    """What a test puts into a measurement model: inputs, their joint scatter, and the equations of its results."""

    inputs: tuple[Input, ...] = ()
    ensembles: tuple[Ensemble, ...] = ()
    correlations: Mapping[tuple[str, str], float] = field(default_factory=dict)
    measurands: tuple[Measurand, ...] = ()


@dataclass  # not frozen: that takes three times as long to make, and there is one for each term of each result
class BudgetRow:
    """One component of one input in the uncertainty budget of an output (JCGM 100, Table H.1).

    `contribution` is c_j·u_j with its sign; `share` the part of u² that the row carries, so that shares add up to one.
    For correlated inputs the cross terms are split evenly between the two rows of a pair; a share can then be negative.
    """

    input: Annotated[str, Doc("Input, by its full name.")]
    component: Annotated[str, Doc("Component of the input's uncertainty.")]
    description: Annotated[str, Doc("What the input is.")]
    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    distribution: Annotated[str, Doc("Distribution of the component.")]
    kind: Annotated[str, Doc("Type A or B.")]
    dof: Annotated[float | None, Doc("Effective degrees of freedom; null where infinite or undefined.")]
    sensitivity: Annotated[float, Doc("Sensitivity coefficient, the derivative of the result by the input.")]
    contribution: float
    share: float
    source: Annotated[str, Doc("Where it comes from.")] = ""
    cause: Annotated[
        str, Doc("Cause that the campaign names for it: one unknown value in all inputs; empty without.")
    ] = ""
    opposite: Annotated[bool, Doc("Whether the cause moves this input against the others.")] = False

    @property
    def moved(self) -> float:
        """Contribution with the direction in which its cause moves the input."""
        return -self.contribution if self.opposite else self.contribution


@dataclass(frozen=True)
class Coverage:
    """Coverage interval by the GUM framework: value ± k·u, at the stated probability p (JCGM 100, clause 6, G.6).

    JSON writes ``{"p": …, "k": …, "low": …, "high": …}``. Where degrees of freedom are undefined, `k`, `low`
    and `high` are None.
    """

    p: Annotated[float, Doc("Coverage probability.")]
    k: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class MonteCarlo:
    """Propagation of distributions (JCGM 101): moments, both 100p % intervals, the verdict of its clause 8 on the law.

    `low`, `high`: probabilistically symmetric; `shortest_low`, `shortest_high`: shortest interval. `tolerance` is the δ
    of clause 7.9.2, `d_low` and `d_high` the differences of clause 8.1 between the law's end points and the Monte Carlo
    ones. `edges` and `density` are a histogram of the draws for the report (len(edges) = len(density) + 1).
    `u` is infinite where the standard deviation does not exist (Student's distribution with ν ≤ 2), and every figure is
    NaN where draws gave no number; `verdict` then says so.
    """

    mean: Annotated[float, Doc("Mean of the draws.")]
    u: float
    low: float
    high: float
    shortest_low: float
    shortest_high: float
    p: Annotated[float, Doc("Coverage probability.")]
    trials: Annotated[int, Doc("Number of draws.")]
    converged: Annotated[bool, Doc("Whether the adaptive procedure reached its tolerance.")]
    law_valid: Annotated[
        bool,
        Doc("Whether JCGM 101 clause 8 confirms the GUM uncertainty framework; its interval is then the one to use."),
    ]
    verdict: str
    tolerance: float
    d_low: float | None
    d_high: float | None
    edges: Floats
    density: Floats
    reported: Annotated[
        Kind, Doc("Which of its two intervals is the one to report: the shortest where it is clearly shorter.")
    ] = "shortest"

    @property
    def has_no_moments(self) -> bool:
        """Whether there are draws, but they have no standard deviation."""
        return isinf(self.u) and isfinite(self.low)

    @property
    def interval(self) -> tuple[float, float]:
        """The interval to report by Monte Carlo."""
        return (self.shortest_low, self.shortest_high) if self.reported == "shortest" else (self.low, self.high)


@dataclass(frozen=True)
class Estimate:
    """An output quantity: y, u(y), ν_eff, coverage interval, budget, Monte Carlo, and what to measure better.

    `value` and `u` are those of the GUM uncertainty framework, like the budget; `reported` says which count.
    `dof` is None where it is infinite or undefined; `dof_note` says which, with the reason ("" when finite). `output`
    is the distribution that every statement about the quantity comes from; None where the draws are no numbers.
    """

    name: str
    value: float
    u: float
    unit: str
    dof: float | None
    dof_note: str
    coverage: Coverage
    monte_carlo: MonteCarlo
    budget: tuple[BudgetRow, ...]
    advice: str = ""
    equation: str = ""
    output: Output | None = None

    @property
    def reported(self) -> tuple[float, float]:
        """Value and u of the distribution that every statement comes from: of the draws where Monte Carlo leads."""
        return (self.value, self.u) if self.output is None else (self.output.value, self.output.u)


@dataclass(frozen=True)
class Evaluation:
    """All outputs of a measurement model with their correlation (JCGM 102).

    `correlation[i][j]` is r(y_i, y_j) of ``names[i]`` and ``names[j]`` by the GUM framework; None where u is zero.
    `of_inputs` are the pairs of inputs that are correlated, each once with its coefficient.
    """

    estimates: Mapping[str, Estimate]
    names: tuple[str, ...]
    correlation: tuple[tuple[float | None, ...], ...]
    of_inputs: tuple[tuple[str, str, float], ...] = ()
