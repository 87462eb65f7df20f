"""What a verification yields, as values that JSON can hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from metrology.doc import Doc

Floats = tuple[float, ...]
Verdict = Literal["validated within u_val", "not validated", "not testable"]


@dataclass(frozen=True)
class PhaseScore:
    """One channel in one phase of one run, open loop and with the run's own inputs re-estimated.

    `rms`, `nrms` (over the range of the readings of the whole run), `r_squared`, `peak_error`, `magnitude`, `phase`,
    `combined` (Sprague–Geers) of the open-loop prediction; `share`: of the readings with |E| ≤ 2·u_val; `u_val`: its
    RMS. `closed_rms`: RMS over noise once the run's own inputs are re-estimated; `closed_above`: how far its square is
    above that of noise, `closed_excess`: what is slow in it, both in standard deviations of what noise does. None where
    there is no number. `testable`: whether u_val is small enough.
    """

    channel: Annotated[str, Doc("Channel: x, v or T.")]
    name: Annotated[str, Doc("Name.")]
    start: Annotated[float, Doc("Start / s.")]
    stop: Annotated[float, Doc("End / s.")]
    count: Annotated[int, Doc("Number of readings.")]
    rms: float | None = None
    nrms: float | None = None
    r_squared: float | None = None
    peak_error: float | None = None
    magnitude: float | None = None
    phase: float | None = None
    combined: float | None = None
    share: float | None = None
    u_val: float | None = None
    closed_rms: float | None = None
    closed_above: float | None = None
    closed_excess: float | None = None
    testable: bool = False


@dataclass(frozen=True)
class RingingScore:
    """Swing of the taut line in one channel: measured and simulated frequency / (rad/s) and decay rate / (1/s)."""

    channel: Annotated[str, Doc("Channel: x, v or T.")]
    start: Annotated[float, Doc("Start / s.")]
    stop: Annotated[float, Doc("End / s.")]
    omega_measured: Annotated[float, Doc("Measured angular frequency / (rad/s).")]
    omega_measured_u: Annotated[float, Doc("Its standard uncertainty.")]
    omega_simulated: Annotated[float, Doc("Simulated angular frequency / (rad/s).")]
    rate_measured: Annotated[float, Doc("Measured decay rate / (1/s).")]
    rate_measured_u: Annotated[float, Doc("Its standard uncertainty.")]
    rate_simulated: Annotated[float, Doc("Simulated decay rate / (1/s).")]


@dataclass(frozen=True)
class Series:
    """One channel for drawing: measured, simulated with band, E and 2·u_val; `count`: readings of the channel.

    `closed`: prediction with the run's own inputs re-estimated; `closed_residual`: measured minus that; both empty
    where nothing could be re-estimated. A gap is None. What is longer than a plot can show is decimated by minimum and
    maximum.
    """

    channel: Annotated[str, Doc("Channel: x, v or T.")]
    unit: Annotated[str, Doc("SI unit written out, such as N/m.")]
    time: Annotated[Floats, Doc("Times of what is drawn / s.")]
    measured: Annotated[tuple[float | None, ...], Doc("What was measured.")]
    simulated: Annotated[Floats, Doc("What was simulated.")]
    low: Annotated[Floats, Doc("Lower end of the interval.")]
    high: Annotated[Floats, Doc("Upper end of the interval.")]
    error: Annotated[tuple[float | None, ...], Doc("Comparison error E, simulated less measured.")]
    twice_u_val: Annotated[Floats, Doc("Twice the validation uncertainty.")]
    closed: Floats
    closed_residual: tuple[float | None, ...]
    count: int = 0


@dataclass(frozen=True)
class RunVerification:
    """One held-out run: scores by channel and phase ('all' is the whole run), series, re-estimated inputs, verdict.

    `share`: of all readings with |E| ≤ 2·u_val; `in_band`: of all readings inside the 95 % band of the open loop.
    `own`: inputs of the run that were re-estimated, (name, value, distance from what was stated in its u).
    `u_num`: by channel.
    """

    run: Annotated[str, Doc("Run, by its name in the campaign file.")]
    verdict: Annotated[Verdict, Doc("The verdict.")]
    sentence: Annotated[str, Doc("The same in words.")]
    rule: Annotated[str, Doc("The rule of the decision, in words.")]
    share: float | None
    in_band: float | None
    phases: Annotated[tuple[tuple[str, float, float], ...], Doc("Phases of the run: name, start and end / s.")]
    scores: Annotated[tuple[PhaseScore, ...], Doc("Scores by channel and phase.")]
    ringing: Annotated[tuple[RingingScore, ...], Doc("Swing of the taut line, by channel.")]
    own: tuple[tuple[str, float, float], ...]
    u_num: tuple[tuple[str, float], ...]
    series: Annotated[tuple[Series, ...], Doc("What is drawn, by channel.")]
    notes: Annotated[tuple[str, ...], Doc("What is worth knowing, each a sentence.")] = ()


@dataclass(frozen=True)
class VerificationFinding:
    """Model of one sample against the runs that its fit has not seen; `basis`: as stated, or with what it lacked."""

    sample: Annotated[str, Doc("Sample, by its name in the campaign file.")]
    test: Annotated[str, Doc("Test, by its name in the campaign file.")]
    model: Annotated[str, Doc("The model in words.")]
    verdict: Annotated[Verdict, Doc("The verdict.")]
    sentence: Annotated[str, Doc("The same in words.")]
    rule: Annotated[str, Doc("The rule of the decision, in words.")]
    runs: Annotated[tuple[RunVerification, ...], Doc("The runs, one entry each.")]
    notes: Annotated[tuple[str, ...], Doc("What is worth knowing, each a sentence.")] = ()
    basis: Annotated[Literal["stated", "extended"], Doc("Whether the model is as stated, or extended.")] = "stated"
