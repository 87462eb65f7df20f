"""What a response test yields, as values that JSON can hold."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from metrology.coordinate import Coordinate

Floats = tuple[float, ...]
Gaps = tuple[float | None, ...]


def plotted(values: Iterable[float | None]) -> Gaps:
    """Return numbers as a plot needs them, with seven digits; a gap stays None.

    >>> plotted([1.23456789, None])
    (1.234568, None)
    """
    return tuple(None if value is None else float(f"{value:.7g}") for value in values)


@dataclass(frozen=True)
class Sought:
    """A parameter that was sought in the runs: estimate, standard uncertainty, 95 % interval and how it was found.

    An end of the interval that the data leave open is None. `shares`: part of each cause in the variance, adding up
    to 1. `sentence`: where the runs do not determine it, what they do say.
    """

    name: str
    unit: str
    value: float
    u: float
    low: float | None
    high: float | None
    interval: Literal["parabola", "profile", "one-sided"]
    determined: bool
    sentence: str
    shares: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class InputAfter:
    """An input known beforehand within an uncertainty, before and after the fit; `run` is empty for a common part."""

    name: str
    run: str
    unit: str
    prior: float
    prior_u: float
    value: float
    u: float
    source: str

    @property
    def distance(self) -> float:
        """How far the fit moved it, in its standard uncertainty beforehand."""
        return (self.value - self.prior) / self.prior_u


@dataclass(frozen=True)
class GivenValue:
    """A stiffness or damping that was simulated with, not sought: value, standard uncertainty, and its source."""

    name: str
    unit: str
    value: float
    u: float
    source: str


@dataclass(frozen=True)
class PaperResult:
    """k and c the paper's way, least RMS difference with the stated inputs taken as exact.

    In N/m and N·s/m, of an angle in N·m/rad and N·m·s/rad.

    `k_u`, `c_u`: jackknife over the runs; None for fewer than three. `rms`: by channel, in its unit. None where it
    failed.
    """

    status: Literal["ok", "failed"]
    sentence: str
    k: float | None
    c: float | None
    k_u: float | None
    c_u: float | None
    rms: tuple[tuple[str, float], ...]
    objective: float | None


@dataclass(frozen=True)
class ChannelFit:
    """One channel of one run beside the fit, decimated by minimum and maximum; a gap is None.

    `residual` = measured − fitted; `noise`: standard uncertainty of one reading; `rms`: of the residuals that carry
    weight.
    """

    channel: str
    unit: str
    noise: float
    rms: float | None
    count: int
    time: Floats
    measured: Gaps
    fitted: Floats
    residual: Gaps


@dataclass(frozen=True)
class FittedRun:
    """A run that went into the fit."""

    run: str
    channels: tuple[ChannelFit, ...]


@dataclass(frozen=True)
class ResponseFinding:
    """What a response test showed.

    `model` says in words what was simulated, `equations` in symbols, every effect carried with value and unit.
    `correlation` is that of the estimates of `correlated`, common to all runs. `chi_squared` is the reduced one, of the
    readings. Where nothing was sought, `status` is 'given' and `given` says what was simulated with. `coordinate` is
    what x is; for an angle, k and c are N·m/rad and N·m·s/rad. The verification of the model stands in
    `Findings.verification`.
    """

    status: Literal["ok", "failed", "given"]
    sentence: str
    model: str
    sought: tuple[Sought, ...]
    inputs: tuple[InputAfter, ...]
    given: tuple[GivenValue, ...]
    correlated: tuple[str, ...]
    correlation: tuple[Floats, ...]
    chi_squared: float | None
    paper: PaperResult | None
    runs: tuple[FittedRun, ...]
    notes: tuple[str, ...]
    failures: tuple[str, ...]
    equations: tuple[str, ...] = ()
    coordinate: Coordinate = "position"
