"""What a verification yields, as values that JSON can hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Floats = tuple[float, ...]
Verdict = Literal["validated within u_val", "not validated", "not testable"]


@dataclass(frozen=True)
class PhaseScore:
    """One channel in one phase of one run, open loop and with the run's own inputs re-estimated.

    `rms`, `nrms` (over the range of the readings of the whole run), `r_squared`, `peak_error`, `magnitude`, `phase`,
    `combined` (Sprague–Geers) of the open-loop prediction; `share`: of the readings with |E| ≤ 2·u_val; `u_val`: its
    RMS. `closed_rms`: RMS over noise once the run's own inputs are re-estimated, `closed_excess`: what is slow in that,
    in standard deviations of white noise. None where there is no number. `testable`: whether u_val is small enough.
    """

    channel: str
    name: str
    start: float
    stop: float
    count: int
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
    closed_excess: float | None = None
    testable: bool = False


@dataclass(frozen=True)
class RingingScore:
    """Swing of the taut line in one channel: measured and simulated frequency / (rad/s) and decay rate / (1/s)."""

    channel: str
    start: float
    stop: float
    omega_measured: float
    omega_measured_u: float
    omega_simulated: float
    rate_measured: float
    rate_measured_u: float
    rate_simulated: float


@dataclass(frozen=True)
class Series:
    """One channel for drawing: measured, simulated with band, E and 2·u_val; `count`: readings of the channel.

    `closed`: prediction with the run's own inputs re-estimated; `closed_residual`: measured minus that; both empty
    where nothing could be re-estimated. A gap is None. What is longer than a plot can show is decimated by minimum and
    maximum.
    """

    channel: str
    unit: str
    time: Floats
    measured: tuple[float | None, ...]
    simulated: Floats
    low: Floats
    high: Floats
    error: tuple[float | None, ...]
    twice_u_val: Floats
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

    run: str
    verdict: Verdict
    sentence: str
    rule: str
    share: float | None
    in_band: float | None
    phases: tuple[tuple[str, float, float], ...]
    scores: tuple[PhaseScore, ...]
    ringing: tuple[RingingScore, ...]
    own: tuple[tuple[str, float, float], ...]
    u_num: tuple[tuple[str, float], ...]
    series: tuple[Series, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class VerificationFinding:
    """Model of one sample against the runs that its fit has not seen."""

    sample: str
    test: str
    model: str
    verdict: Verdict
    sentence: str
    rule: str
    runs: tuple[RunVerification, ...]
    notes: tuple[str, ...] = ()
