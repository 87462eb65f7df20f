"""What a response test yields, as values that JSON can hold."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Literal

from metrology.check import Check
from metrology.coordinate import Coordinate
from metrology.doc import Doc

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

    name: Annotated[str, Doc("Name.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]
    low: Annotated[float | None, Doc("Lower end of the interval.")]
    high: Annotated[float | None, Doc("Upper end of the interval.")]
    interval: Annotated[Literal["parabola", "profile", "one-sided"], Doc("How the interval was found.")]
    determined: Annotated[bool, Doc("Whether the runs determine it.")]
    sentence: str
    shares: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class InputAfter:
    """An input known beforehand within an uncertainty, before and after the fit; `run` is empty for a common part."""

    name: Annotated[str, Doc("Name.")]
    run: str
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    prior: Annotated[float, Doc("Value beforehand.")]
    prior_u: Annotated[float, Doc("Its standard uncertainty.")]
    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]
    source: Annotated[str, Doc("Where it comes from.")]

    @property
    def distance(self) -> float:
        """How far the fit moved it, in its standard uncertainty beforehand."""
        return (self.value - self.prior) / self.prior_u


@dataclass(frozen=True)
class GivenValue:
    """A stiffness or damping that was simulated with, not sought: value, standard uncertainty, and its source."""

    name: Annotated[str, Doc("Name.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    value: Annotated[float, Doc("Value, in SI.")]
    u: Annotated[float, Doc("Standard uncertainty, in SI.")]
    source: Annotated[str, Doc("Where it comes from.")]


@dataclass(frozen=True)
class PaperResult:
    """k and c the paper's way, least RMS difference with the stated inputs taken as exact.

    In N/m and N·s/m, of an angle in N·m/rad and N·m·s/rad.

    `k_u`, `c_u`: jackknife over the runs; None for fewer than three. `rms`: by channel, in its unit. None where it
    failed.
    """

    status: Annotated[Literal["ok", "failed"], Doc("Whether it could be computed.")]
    sentence: Annotated[str, Doc("The same in words.")]
    k: Annotated[float | None, Doc("Stiffness / (N/m), of an angle / (N·m/rad).")]
    c: Annotated[float | None, Doc("Damping coefficient / (N·s/m), of an angle / (N·m·s/rad).")]
    k_u: float | None
    c_u: float | None
    rms: tuple[tuple[str, float], ...]
    objective: Annotated[float | None, Doc("The objective at its least.")]


@dataclass(frozen=True)
class ChannelFit:
    """One channel of one run beside the fit, decimated by minimum and maximum; a gap is None.

    `residual` = measured − fitted; `noise`: standard uncertainty of one reading; `rms`: of the residuals that carry
    weight.
    """

    channel: Annotated[str, Doc("Channel: x, v or T.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    noise: float
    rms: float | None
    count: Annotated[int, Doc("Number of readings.")]
    time: Annotated[Floats, Doc("Times of what is drawn / s.")]
    measured: Annotated[Gaps, Doc("What was measured.")]
    fitted: Annotated[Floats, Doc("What was fitted.")]
    residual: Gaps


@dataclass(frozen=True)
class FittedRun:
    """A run that went into the fit."""

    run: Annotated[str, Doc("Run, by its name in the campaign file.")]
    channels: Annotated[tuple[ChannelFit, ...], Doc("The channels of the run.")]


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
    sentence: Annotated[str, Doc("The same in words.")]
    model: str
    sought: Annotated[tuple[Sought, ...], Doc("Parameters that were sought.")]
    inputs: Annotated[tuple[InputAfter, ...], Doc("Inputs known beforehand, before and after the fit.")]
    given: tuple[GivenValue, ...]
    correlated: tuple[str, ...]
    correlation: tuple[Floats, ...]
    chi_squared: float | None
    paper: Annotated[PaperResult | None, Doc("k and c by the least RMS difference.")]
    runs: Annotated[tuple[FittedRun, ...], Doc("The runs, one entry each.")]
    notes: Annotated[tuple[str, ...], Doc("What is worth knowing, each a sentence.")]
    failures: Annotated[tuple[str, ...], Doc("What could not be computed, each a sentence.")]
    equations: tuple[str, ...] = ()
    coordinate: Coordinate = "position"
    mass: Annotated[float | None, Doc("Mass / kg as stated, of an angle the moment of inertia / (kg·m²).")] = None
    checks: Annotated[tuple[Check, ...], Doc("Checks of the records before any model.")] = ()
