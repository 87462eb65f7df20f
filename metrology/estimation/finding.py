"""What an identification yields, as values that JSON can hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from metrology.estimation.budget import shares
from metrology.estimation.identification import Identification
from metrology.estimation.paper import PaperWay


@dataclass(frozen=True)
class ParameterRow:
    """One unknown: value, u, 95 % interval (None: open), what was known before; `sentence` where it is not determined.

    `shift`: distance from the prior in its standard uncertainties. `shares`: (cause, share of u²).
    """

    name: str
    symbol: str
    meaning: str
    run: str
    value: float
    u: float
    unit: str
    low: float | None
    high: float | None
    interval: Literal["parabola", "profile", "one-sided"]
    prior_mean: float | None
    prior_u: float | None
    shift: float | None
    determined: bool
    sentence: str
    shares: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class ChannelRow:
    """One channel of one run: stated or estimated noise, χ² for each reading, correlation length in readings."""

    run: str
    channel: str
    noise: float
    unit: str
    count: int
    chi_squared: float
    correlation_length: float


@dataclass(frozen=True)
class PaperRow:
    """The paper's way beside it: k, c by least RMS, and their distance from the joint fit in its u."""

    status: str
    sentence: str
    k: float | None
    c: float | None
    k_distance: float | None
    c_distance: float | None
    rms: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class ResponseFinding:
    """Everything that the report shows of one identification."""

    sample: str
    test: str
    status: Literal["ok", "failed"]
    sentence: str
    parameters: tuple[ParameterRow, ...]
    names: tuple[str, ...]
    correlation: tuple[tuple[float, ...], ...]
    chi_squared: float | None
    dof: int
    channels: tuple[ChannelRow, ...]
    paper: PaperRow | None
    notes: tuple[str, ...]
    equations: tuple[str, ...] = (
        "m·x″ = F(t) − T",
        "T = k·e + c·e′ ≥ 0, e = x − x_t > 0, else 0",
        "min Σ ((y − y_model(θ))/u)² + Σ ((θ_j − μ_j)/u_j)²",
    )


def finding(found: Identification, names: tuple[str, str], paper: PaperWay | None = None) -> ResponseFinding:
    """Result of a fit for the report.

    Parameters
    ----------
    found : Identification
        The fit; a failed one gives its sentence and no numbers.
    names : (str, str)
        Sample and test.
    paper : PaperWay, optional
        The paper's way on the same runs.
    """
    common = tuple(entry.name for entry in found.layout.unknowns[: found.layout.common])
    correlation: tuple[tuple[float, ...], ...] = ()
    if found.covariance is not None:
        total = found.total[: len(common), : len(common)]
        size = np.sqrt(np.diag(total))
        correlation = tuple(tuple(row) for row in (total / np.outer(size, size)).tolist())
    return ResponseFinding(
        sample=names[0], test=names[1], status=found.status, sentence=found.sentence, parameters=_parameters(found),
        names=common, correlation=correlation, chi_squared=None if found.dof <= 0 else found.chi_squared, dof=found.dof,
        channels=_channels(found), paper=None if paper is None else _paper(found, paper), notes=found.notes,
    )  # fmt: skip


def _parameters(found: Identification) -> tuple[ParameterRow, ...]:
    rows = []
    for entry in found.parameters:
        name, _, run = entry.name.partition("@")
        known = found.rig.parameters[name]
        shift = None
        if entry.prior_u is not None and entry.prior_mean is not None:
            shift = (entry.value - entry.prior_mean) / entry.prior_u
        rows.append(
            ParameterRow(
                name=name, symbol=known.symbol, meaning=known.meaning, run=run, value=entry.value, u=entry.u,
                unit=entry.unit, low=entry.low, high=entry.high, interval=entry.interval, prior_mean=entry.prior_mean,
                prior_u=entry.prior_u, shift=shift, determined=entry.determined, sentence=entry.sentence,
                shares=tuple(shares(found, entry.name).items()),
            )
        )  # fmt: skip
    return tuple(rows)


def _channels(found: Identification) -> tuple[ChannelRow, ...]:
    if found.covariance is None:
        return ()
    noise = {(one.name, channel): one.noise[channel] for one in found.runs for channel in one.channels}
    rows = []
    for one in found.covariance.scatter:
        by_channel = (
            noise[one.block, one.channel],
            found.rig.channel_units[one.channel],
            one.count,
            one.chi_squared,
            one.correlation_length,
        )
        rows.append(ChannelRow(one.block, one.channel, *by_channel))
    return tuple(rows)


def _paper(found: Identification, paper: PaperWay) -> PaperRow:
    if paper.status != "ok":
        return PaperRow(paper.status, paper.sentence, None, None, None, None, ())
    apart: list[float | None] = []
    for name, value in (("k", paper.k), ("c", paper.c)):
        known = {entry.name: entry for entry in found.parameters}
        apart.append((value - known[name].value) / known[name].u if name in known else None)
    return PaperRow(paper.status, paper.sentence, paper.k, paper.c, apart[0], apart[1], tuple(paper.rms.items()))
