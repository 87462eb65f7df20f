"""Input quantities of a measurement model, each with the components of its uncertainty (JCGM 100:2008, clause 4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, sqrt
from typing import Literal

import numpy as np

from metrology.gum.distributions import Normal, Student
from metrology.gum.influence import Distribution

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


KNOWN = 1e6
"""Degrees of freedom of a covariance that is stated, not estimated: as good as infinite."""


NAMELESS = "imported-"
"""Beginning of the names of causes that no person named: of results of other campaigns, by file and row."""


@dataclass(frozen=True)
class Component:
    """One cause of uncertainty of an input: an additive, zero-mean influence with a distribution of its own.

    Parameters
    ----------
    name : str
        What causes it, such as ``"certificate"``, ``"resolution"``, ``"repeatability"``.
    distribution : Distribution
        State of knowledge about the influence, in the unit of the input; it carries the standard uncertainty.
    dof : float
        Degrees of freedom of the standard uncertainty; infinite where it is taken as known (JCGM 100 G.4.2). Those of a
        `Student` distribution need not be repeated.
    kind : {"A", "B"}
        Type of evaluation (JCGM 100 4.2, 4.3).
    source : str
        Where the figure comes from: a certificate, a data sheet, the readings.
    cause : str
        Name of a cause that components of other inputs share: its one unknown value moves them all in the same
        direction, each by its own u. Empty where the component has a cause of its own (JCGM 100 5.2.4, F.1.2.3).
    opposite : bool
        Whether the cause moves this input against the others.
    """

    name: str
    distribution: Distribution
    dof: float = inf
    kind: Literal["A", "B"] = "B"
    source: str = ""
    cause: str = ""
    opposite: bool = False

    def __post_init__(self) -> None:
        if self.dof == inf and isinstance(self.distribution, Student):
            object.__setattr__(self, "dof", self.distribution.dof)

    @property
    def u(self) -> float:
        """Standard uncertainty, in the unit of the input."""
        return self.distribution.u

    @property
    def sign(self) -> float:
        """Direction in which its cause moves the input, 1 or −1."""
        return -1.0 if self.opposite else 1.0

    @property
    def drawn(self) -> Distribution:
        """Distribution of the Monte Carlo draws: a normal u known with ν degrees of freedom is drawn as scaled t.

        Source: JCGM 101:2008 6.4.9.2, 6.4.9.7.
        """
        if isfinite(self.dof) and isinstance(self.distribution, Normal):
            return Student(self.distribution.u, self.dof)
        return self.distribution


@dataclass(frozen=True)
class Input:
    """An input quantity X_i: its estimate, and every component of the uncertainty of that estimate.

    Parameters
    ----------
    name : str
        Unique name within the campaign, such as ``"al-1100.length"``.
    value : float
        Estimate, in SI.
    components : tuple of Component
        Independent of one another; an input without any is a constant.
    unit : str
        SI unit written out, such as ``"N/m"``; ``"1"`` for a number.
    description : str
        What it is, in the words of the report.
    is_stated : bool
        Whether somebody stated it, who could have stated its uncertainty too.
    """

    name: str
    value: float
    components: tuple[Component, ...] = ()
    unit: str = "1"
    description: str = ""
    is_stated: bool = False

    @property
    def u(self) -> float:
        """Combined standard uncertainty of the components, u² = Σ u_j²."""
        return sqrt(sum([component.u**2 for component in self.components]))


@dataclass(frozen=True)
class Ensemble:
    """Inputs read simultaneously, n times: their mean values vary together (JCGM 100 5.2.3, H.2; JCGM 102 5.3.2).

    An input named here takes one more component, of Type A, which this ensemble describes jointly with the others.

    Parameters
    ----------
    name : str
        Name of the set of readings, shown as the component of each member.
    members : tuple of str
        Names of the inputs, in the order of `covariance`.
    covariance : ndarray, shape (m, m)
        Covariance of the *means* of the members, S / n, in the units of the members.
    dof : float
        Degrees of freedom ν = n − 1 of the covariance.
    source : str
        Where it comes from.
    columns : ndarray, shape (m, q), optional
        What independent causes do to each member, columns·columnsᵀ = covariance: the members are then drawn by these.
        By a root of the covariance, what one of them is hardly moved by would settle how the others are drawn.
    again : callable, optional
        ``again(generator, size)``: the readings drawn and evaluated anew. Errors of the members, shape (m, size); the
        covariance over that of the ensemble, (size,); u² of what the members have besides over its own, (m, size),
        whose errors are among those of the members.
    """

    name: str
    members: tuple[str, ...]
    covariance: Floats
    dof: float
    source: str = ""
    columns: Floats | None = None
    again: Callable[[np.random.Generator, int], tuple[Floats, Floats, Floats]] | None = None


@dataclass(frozen=True)
class Redrawn:
    """Inputs that an algorithm yields together, drawn by that algorithm from drawn data: parameters of a fit.

    The law takes their components and correlations; only the draws come from here.

    Parameters
    ----------
    members : tuple of str
        Names of the inputs.
    draw : callable
        ``draw(generator, size)``: differences of the members from their estimates, shape (m, size).
    repeat : callable, optional
        ``repeat(generator, size)``: errors of the members in fits to data drawn about the fitted curve, and u² of each
        by that very fit over its own, both of shape (m, size).
    """

    members: tuple[str, ...]
    draw: Callable[[np.random.Generator, int], Floats]
    repeat: Callable[[np.random.Generator, int], tuple[Floats, Floats]] | None = None


@dataclass(frozen=True)
class Knowledge:
    """All that is known about the inputs of a campaign: the joint state of knowledge that is propagated.

    Parameters
    ----------
    inputs : mapping of str to Input
        By name.
    ensembles : tuple of Ensemble
        Simultaneous readings.
    correlations : mapping of (str, str) to float
        Stated correlation coefficients r(x_i, x_j) between the *estimates* of two inputs (JCGM 100 5.2.2),
        for inputs that are in no ensemble.
    redrawn : tuple of Redrawn
        Inputs whose draws an algorithm makes.
    """

    inputs: Mapping[str, Input]
    ensembles: tuple[Ensemble, ...] = ()
    correlations: Mapping[tuple[str, str], float] = field(default_factory=dict)
    redrawn: tuple[Redrawn, ...] = ()
