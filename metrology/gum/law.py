"""Law of propagation of uncertainty: sensitivities, combined u, effective degrees of freedom (JCGM 100:2008, 5, G)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, nan, sqrt
from typing import Any

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.gum.evaluation import Coverage, Measurand
from metrology.gum.inputs import Floats, Knowledge
from metrology.gum.joint import Joint, joint
from metrology.message import said


class Namespace(Mapping[str, Any]):
    """Quantities by name, which remembers the names that were read."""

    def __init__(self, quantities: dict[str, Any]) -> None:
        self.quantities = quantities
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> Any:
        self.read.add(name)
        return self.quantities[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)


@dataclass(frozen=True)
class Linear:
    """A measurand at the estimates of its inputs: value, sensitivities c_i = ∂y/∂x_i, and all inputs that it reads.

    `failure` is a sentence where the value (then NaN) or a sensitivity does not exist.
    """

    measurand: Measurand
    value: float
    sensitivities: Mapping[str, float]
    reads: frozenset[str]
    failure: str = ""


def linearise(measurands: Sequence[Measurand], knowledge: Knowledge) -> tuple[Linear, ...]:
    """Value and sensitivities of every measurand, by the derivatives that `uncertainties` carries along.

    A measurand may read the inputs and every measurand before it.

    Parameters
    ----------
    measurands : sequence of Measurand
        In order of use.
    knowledge : Knowledge
        The inputs, in SI.

    Returns
    -------
    tuple of Linear
        For each measurand its value, its sensitivities by input, and what it reads.

    Raises
    ------
    MetrologyError
        A measurand reads a name that is neither an input nor an earlier measurand.

    Notes
    -----
    JCGM 100:2008 5.1.3.
    """
    from uncertainties import ufloat

    members = {member for ensemble in knowledge.ensembles for member in ensemble.members}
    quantities: dict[str, Any] = {
        # The standard deviation of the variable is of no account: only derivatives are read off.
        name: ufloat(item.value, 1.0) if item.u or name in members else float(item.value)
        for name, item in knowledge.inputs.items()
    }
    variables = {id(quantities[name]): name for name in quantities}
    reads: dict[str, frozenset[str]] = {name: frozenset([name]) for name in quantities}
    found = []
    for measurand in measurands:
        linear = _linear(measurand, quantities, variables, reads)
        reads[measurand.name] = linear.reads
        found.append(linear)
    return tuple(found)


def _linear(
    measurand: Measurand, quantities: dict[str, Any], variables: dict[int, str], reads: dict[str, frozenset[str]]
) -> Linear:
    namespace = Namespace(quantities)
    failure = ""
    try:
        result = measurand.function(namespace)
    except KeyError as error:
        raise MetrologyError(_unknown(measurand, error)) from error
    except (ArithmeticError, ValueError) as error:
        text = "The equation has no value at the estimates of its inputs ({error})."
        result, failure = nan, said(text, error=str(error))
    quantities[measurand.name] = result
    inputs = frozenset().union(*(reads[name] for name in namespace.read))
    value = float(getattr(result, "nominal_value", result))
    if not isfinite(value):
        failure = failure or said("The equation has no finite value at the estimates.")
        return Linear(measurand, nan, {}, inputs, failure)
    derivatives = getattr(result, "derivatives", {})
    slopes = {variables[id(variable)]: float(slope) for variable, slope in derivatives.items()}
    undefined = sorted(name for name, slope in slopes.items() if not isfinite(slope))
    if undefined:
        text = "The derivative with respect to {names:comma} does not exist at the estimates."
        failure = said(text, names=tuple(undefined))
        return Linear(measurand, value, {}, inputs, failure)
    return Linear(measurand, value, slopes, inputs)


def _unknown(measurand: Measurand, error: KeyError) -> Fault:
    return Fault(measurand.name, f"an equation that reads {error}", "inputs, or measurands that come before it")


@dataclass(frozen=True)
class Law:
    """The GUM uncertainty framework applied to all measurands."""

    linear: tuple[Linear, ...]
    joint: Joint

    @cached_property
    def contributions(self) -> Floats:
        """Signed c_a·u_a of every measurand (rows) and term (columns)."""
        names = [term.input.name for term in self.joint.terms]
        slopes = [[line.sensitivities.get(name, 0.0) for name in names] for line in self.linear]
        return np.array(slopes).reshape(len(self.linear), len(names)) * self.joint.u

    @cached_property
    def covariance(self) -> Floats:
        """Covariance matrix of the outputs, C V Cᵀ (JCGM 102:2011 6.2.1.3)."""
        return np.asarray(self.contributions @ self.joint.times(self.contributions.T))

    def u(self, row: int) -> float:
        """Combined standard uncertainty (JCGM 100:2008 5.1.2, 5.2.2); NaN where the law fails."""
        return nan if self.linear[row].failure else sqrt(max(float(self.covariance[row, row]), 0.0))

    def dof(self, row: int) -> tuple[float | None, str]:
        """Effective degrees of freedom; None, with the reason, where they are infinite or undefined.

        Welch–Satterthwaite, ν = u⁴ / Σ u_j⁴/ν_j, over contributions that are independent of one another: simultaneous
        readings form one contribution with ν = n − 1, correlated inputs without finite degrees of freedom another.

        Source: JCGM 100:2008 G.4.1.
        """
        return self._freedoms[row]

    @cached_property
    def _freedoms(self) -> tuple[tuple[float | None, str], ...]:
        return tuple(self._freedom(row) for row in range(len(self.linear)))

    def _freedom(self, row: int) -> tuple[float | None, str]:
        u = self.u(row)
        if not u > 0:
            reason = self.linear[row].failure or said("the GUM uncertainty framework gives u = 0")
            return None, said("undefined: {reason}", reason=reason)
        if culprits := self._correlated_finite(row):
            reason = said(
                "a correlation is stated for {names:comma}, of finite degrees of freedom; the Welch–Satterthwaite "
                "formula asks for independent inputs, so there is no coverage factor and the Monte Carlo interval is "
                "used. Simultaneous readings given as an ensemble would have ν = n − 1",
                names=tuple(culprits),
            )
            return None, said("undefined: {reason}", reason=reason)
        total = sum((self._variance(row, rows) / u**2) ** 2 / dof for rows, dof in self.joint.scatters)
        if total == 0:
            return None, said("infinite: every contribution is taken as exactly known")
        return 1 / total, ""

    def _correlated_finite(self, row: int) -> list[str]:
        """Inputs with finite ν that are correlated, by statement, with another input that contributes too."""
        sensitivities = self.linear[row].sensitivities
        active = {name for pair in self.joint.stated for name in pair if all(sensitivities.get(n) for n in pair)}
        if not active:
            return []
        finite = (term.input.name for term in self.joint.terms if isfinite(term.component.dof) and term.component.u)
        return [name for name in dict.fromkeys(finite) if name in active]

    def _variance(self, row: int, rows: list[int]) -> float:
        """Variance of the sum of a measurand's contributions from some terms."""
        if len(rows) == 1:
            return float(self.contributions[row, rows[0]]) ** 2
        parts = self.contributions[row, rows]
        return float(parts @ self.joint.among(rows) @ parts) if parts.any() else 0.0

    def coverage(self, row: int, probability: float) -> Coverage:
        """Interval y ± k·u with k the quantile of Student's distribution (JCGM 100:2008 G.3, G.6.4)."""
        dof, note = self.dof(row)
        value, u = self.linear[row].value, self.u(row)
        if u == 0:
            return Coverage(probability, None, value, value)
        if note.startswith("undefined"):
            return Coverage(probability, None, None, None)
        k = coverage_factor(probability, inf if dof is None else dof)
        return Coverage(probability, k, value - k * u, value + k * u)

    def coefficients(self) -> tuple[tuple[float | None, ...], ...]:
        """Correlation coefficients between the outputs; None where a u is zero or undefined."""
        u = [self.u(row) for row in range(len(self.linear))]
        return tuple(
            tuple(
                (1.0 if i == j else self._coefficient(i, j)) if u[i] > 0 and u[j] > 0 else None for j in range(len(u))
            )
            for i in range(len(u))
        )

    def _coefficient(self, i: int, j: int) -> float:
        return min(1.0, max(-1.0, float(self.covariance[i, j]) / (self.u(i) * self.u(j))))


def effective_dof(parts: Iterable[tuple[float, float]]) -> float:
    """Effective degrees of freedom of a sum of independent parts, ν = u⁴ / Σ u_j⁴/ν_j (JCGM 100:2008 G.4.1).

    Parameters
    ----------
    parts : iterable of (float, float)
        Variance and degrees of freedom of each part.

    Returns
    -------
    float
        ν, infinite where every part is taken as known.

    Examples
    --------
    >>> effective_dof([(1.0, 4.0), (1.0, float("inf"))])
    16.0
    """
    known = list(parts)
    total = sum(variance for variance, _ in known)
    least = sum((variance / total) ** 2 / dof for variance, dof in known) if total > 0 else 0.0
    return 1 / least if least else inf


def coverage_factor(probability: float, dof: float = inf) -> float:
    """Coverage factor k of the two-sided interval y ± k·u (JCGM 100:2008 G.3.4, Table G.2).

    Parameters
    ----------
    probability : float
        Coverage probability, above 0 and below 1.
    dof : float
        Degrees of freedom; a normal distribution where infinite.

    Returns
    -------
    float
        k, the quantile of the t-distribution at (1 + p)/2.

    Examples
    --------
    >>> round(coverage_factor(0.99, 16), 2), round(coverage_factor(0.95), 2)
    (2.92, 1.96)
    """
    from scipy.special import ndtri, stdtrit

    tail = (1 - probability) / 2
    return -float(stdtrit(dof, tail) if isfinite(dof) else ndtri(tail))


def propagate(measurands: Sequence[Measurand], knowledge: Knowledge) -> Law:
    """Apply the law to every measurand; the joint knowledge is limited to the inputs that any of them reads.

    Parameters
    ----------
    measurands : sequence of Measurand
        In order of use.
    knowledge : Knowledge
        The inputs, in SI.

    Returns
    -------
    Law
        Covariance, degrees of freedom and contributions on demand.

    Raises
    ------
    MetrologyError
        As `linearise`.

    Notes
    -----
    JCGM 100:2008 5.1.2, 5.2.2; JCGM 102:2011 6.2.
    """
    linear = linearise(measurands, knowledge)
    names = frozenset[str]().union(*(line.reads for line in linear))
    return Law(linear, joint(knowledge, names))
