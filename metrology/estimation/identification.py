"""What a fit yields: values, covariance by source, residuals, and a sentence where something is amiss."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from metrology.estimation.covariance import Covariance
from metrology.estimation.measured import MeasuredRun
from metrology.estimation.priors import Layout, Prior
from metrology.estimation.problem import Array
from metrology.gum.inputs import KNOWN
from metrology.gum.matrix import root
from metrology.rig import Rig


@dataclass(frozen=True)
class Estimated:
    """One unknown after the fit.

    Parameters
    ----------
    name, unit : str
        Of the parameter; ``'thrust.gain@run'`` for the part of one run.
    value, u : float
        Estimate and standard uncertainty.
    prior_mean, prior_u : float or None
        What was known beforehand.
    low, high : float or None
        95 % interval; None for an end that the data leave open.
    interval : {'parabola', 'profile', 'one-sided'}
        How it was found.
    determined : bool
        Whether the data, with the priors, determine it.
    sentence : str
        Where not, what they do say.
    """

    name: str
    unit: str
    value: float
    u: float
    prior_mean: float | None
    prior_u: float | None
    low: float | None
    high: float | None
    interval: Literal["parabola", "profile", "one-sided"]
    determined: bool
    sentence: str = ""


@dataclass(frozen=True)
class Residual:
    """Measured minus fitted in one channel of one run: `residual` / unit of the channel, `whitened` = residual / u.

    `used` marks the readings with weight.
    """

    run: str
    channel: str
    t: Array
    residual: Array
    whitened: Array
    used: Array


@dataclass(frozen=True)
class Source:
    """A part of the uncertainty of all unknowns with one cause.

    Parameters
    ----------
    name : str
        ``'readings'``, the name of a prior, or what else it is.
    kind : {'readings', 'common', 'per run', 'effects', 'inadequacy', 'models'}
        A common part has one column, and its sign is kept; the others add up as covariances.
    columns : ndarray, shape (p, r)
        Covariance of the unknowns from this source: columns·columnsᵀ.
    mean, u : float
        Of the prior, for a common part.
    unit : str
        Of the prior.
    dof : float
        Degrees of freedom of the covariance; as good as infinite where it is stated, not estimated.
    """

    name: str
    kind: Literal["readings", "common", "per run", "effects", "inadequacy", "models"]
    columns: Array
    mean: float = 0.0
    u: float = 0.0
    unit: str = "1"
    dof: float = KNOWN


@dataclass(frozen=True)
class Joint:
    """Joint distribution of what all runs share: values / SI, and the parts of their covariance by cause."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    sources: tuple[Source, ...]


@dataclass(frozen=True)
class Identification:
    """Result of a joint fit to several runs.

    Parameters
    ----------
    status : {'ok', 'failed'}
        Only an 'ok' result has numbers that may be used.
    sentence : str
        What happened.
    rig : Rig
        As stated.
    runs : tuple of MeasuredRun
        That went in, with the readings that were left out of them marked.
    layout : Layout
        Which unknown acts where.
    priors : tuple of Prior
        What was known beforehand.
    theta : ndarray, shape (p,)
        Estimates in the order of ``layout.unknowns``; NaN when failed.
    covariance : Covariance or None
        By source.
    parameters : tuple of Estimated
        The same with intervals.
    chi_squared : float
        Of the readings.
    dof : int
        Readings with weight plus priors minus unknowns.
    residuals : tuple of Residual
        Of every run and channel.
    log_evidence : float
        For comparison with another model fitted to the same readings with the same priors.
    steps : int
        Derivatives taken.
    notes : tuple of str
        What a reader has to know: noise, readings that were left out, priors that the data contradict.
    """

    status: Literal["ok", "failed"]
    sentence: str
    rig: Rig
    runs: tuple[MeasuredRun, ...]
    layout: Layout
    priors: tuple[Prior, ...]
    theta: Array
    covariance: Covariance | None
    parameters: tuple[Estimated, ...]
    chi_squared: float
    dof: int
    residuals: tuple[Residual, ...]
    log_evidence: float
    steps: int
    notes: tuple[str, ...]

    def parameter(self, name: str) -> Estimated:
        """One unknown by name.

        Raises
        ------
        KeyError
            For a name that was not sought.
        """
        for entry in self.parameters:
            if entry.name == name:
                return entry
        raise KeyError(name)

    def value(self, name: str) -> float:
        """Estimate of one unknown."""
        return self.parameter(name).value

    def u(self, name: str) -> float:
        """Standard uncertainty of one unknown."""
        return self.parameter(name).u

    def correlation(self, one: str, other: str) -> float:
        """Correlation coefficient of two estimates."""
        total = self.total
        a, b = self.layout.index(one), self.layout.index(other)
        return float(total[a, b] / np.sqrt(total[a, a] * total[b, b]))

    @property
    def total(self) -> Array:
        """Covariance of all unknowns, shape (p, p)."""
        if self.covariance is None:
            return np.full((len(self.theta), len(self.theta)), np.nan)
        return self.covariance.total

    @property
    def reduced_chi_squared(self) -> float:
        """χ²/ν."""
        return self.chi_squared / self.dof if self.dof > 0 else float("nan")

    @property
    def common_values(self) -> dict[str, float]:
        """Values of the unknowns that all runs share."""
        common = self.layout.unknowns[: self.layout.common]
        return {entry.name: float(value) for entry, value in zip(common, self.theta, strict=False)}

    @property
    def fitted(self) -> Rig:
        """The rig with the estimates that all runs share."""
        return self.rig.with_values(self.common_values)

    def rig_of(self, run: str) -> Rig:
        """Return the rig with the estimates of one run, its own parts included."""
        at = self.layout.runs.index(run)
        return self.rig.with_values(self.layout.values(at, self.theta[list(self.layout.uses[at])]))

    @property
    def sources(self) -> tuple[Source, ...]:
        """Parts of the covariance by cause; they add up to `total`."""
        if self.covariance is None:
            return ()
        scatter = sum(one.count / one.correlation_length for one in self.covariance.scatter)
        dof = max(1.0, scatter - len(self.layout.unknowns))
        found = [Source("readings", "readings", root(self.covariance.readings), dof=dof)]
        own: dict[str, list[Array]] = {}
        for at, column in self.covariance.priors.items():
            entry = self.layout.unknowns[at]
            if at < self.layout.common:
                mean, u = float(entry.mean or 0.0), float(entry.u or 0.0)
                found.append(Source(entry.name, "common", column[:, None], mean, u, entry.unit))
            else:
                own.setdefault(entry.name.split("@")[0], []).append(column)
        found += [Source(name, "per run", np.column_stack(columns)) for name, columns in own.items()]
        return tuple(found)

    @property
    def joint(self) -> Joint:
        """Joint distribution of the unknowns that all runs share."""
        common = self.layout.unknowns[: self.layout.common]
        rows = tuple(replace(one, columns=one.columns[: len(common)]) for one in self.sources)
        names, units = tuple(one.name for one in common), tuple(one.unit for one in common)
        return Joint(names, units, self.theta[: len(common)], rows)

    def draws(self, rng: np.random.Generator, count: int) -> Array:
        """Joint draws of all unknowns, normal, kept within their bounds; shape (count, p)."""
        drawn: Array = self.theta + rng.standard_normal((count, len(self.theta))) @ root(self.total).T
        low = np.array([entry.low for entry in self.layout.unknowns])
        high = np.array([entry.high for entry in self.layout.unknowns])
        return np.clip(drawn, low, high)
