"""Parameters of the rig from measured runs: jointly, weighted, inside what the lab knows beforehand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from metrology.errors import Fault, MetrologyError
from metrology.estimation import inspection
from metrology.estimation.covariance import Covariance, covariance, log_evidence
from metrology.estimation.identification import Estimated, Identification, Residual
from metrology.estimation.measured import MeasuredRun
from metrology.estimation.priors import Layout, Prior, lay_out
from metrology.estimation.profile import NORMAL_95, Interval, interval
from metrology.estimation.search import Found, search, starts
from metrology.message import counted, said
from metrology.rig import Rig, simulate

CONTRADICTED = 4.0
"""Distance of an estimate from its prior, in standard uncertainties of the prior, from which on a note says so."""
UNEXPLAINED = 1.5
"""Inflation of the variance of a channel from which on a note says that its residuals are no noise."""


@dataclass(frozen=True)
class Settings:
    """How a fit is done.

    Parameters
    ----------
    bounds : mapping of str to (float, float)
        Closed bounds of parameters, tighter than the equation's own.
    starts : sequence of mapping
        Further start values, as mappings of parameter to value.
    profile : bool
        Check the parabola for the free parameters, and take the profile where it is wrong.
    near : bool
        Search from the start values alone: they are an optimum of nearly the same problem, and others would be no help.
    """

    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    starts: Sequence[dict[str, float]] = ()
    profile: bool = True
    near: bool = False


def fit(
    rig: Rig,
    runs: Sequence[MeasuredRun],
    *,
    free: Sequence[str] = ("k", "c"),
    priors: Sequence[Prior] = (),
    settings: Settings | None = None,
) -> Identification:
    """Estimates of the free parameters with their uncertainty, from all runs together.

    Minimises Σ ((y − y_model(θ))/u)² + Σ ((θ_j − μ_j)/u_j)², the second sum over the priors (pseudo-observations, JCGM
    100 F.2.3.2, with a common part and a part per run), as ``docs/methods/response.md`` tells.

    Parameters
    ----------
    rig : Rig
        As the lab states it; the start of the search.
    runs : sequence of MeasuredRun
        Those with the purpose 'identification' are used.
    free : sequence of str
        Parameters of the rig about which nothing is known but their range.
    priors : sequence of Prior
        What is known within an uncertainty.
    settings : Settings, optional
        Bounds, starts, profile.

    Returns
    -------
    Identification
        With status 'failed' and a sentence where the search did not converge.

    Raises
    ------
    MetrologyError
        Runs that cannot be what they claim (signs, start state, no motion), names that the rig does not have.
    """
    settings = settings or Settings()
    _load_kernel(rig, runs)
    chosen, notes = _chosen(rig, runs)
    layout = lay_out(rig, [one.name for one in chosen], free, priors, settings.bounds)
    found = search(rig, chosen, layout, starts(rig, layout, settings.starts), near=settings.near)
    if found is None:
        return _failed(rig, chosen, layout, (tuple(priors), notes), _unanswered(rig, chosen))
    if found.solution.status != "converged":
        sentence = said(
            "the fit is {sentence}; the model may not be able to follow these runs, or its start values may be far "
            "off: compare the runs with the stated rig, then give other start values or bounds",
            sentence=found.solution.sentence,
        )
        return _failed(rig, chosen, layout, (tuple(priors), notes), sentence)
    return _identified(rig, (chosen, layout, tuple(priors)), found, notes, settings.profile)


def _load_kernel(rig: Rig, runs: Sequence[MeasuredRun]) -> None:
    """Load the compiled kernel before the first of some thousand motions; without a compiler NumPy serves as well."""
    for measured in runs[:1]:
        simulate(rig, measured.run, engine="compiled")


def _chosen(rig: Rig, runs: Sequence[MeasuredRun]) -> tuple[tuple[MeasuredRun, ...], tuple[str, ...]]:
    chosen = [one for one in runs if one.purpose == "identification"]
    if not chosen:
        raise MetrologyError(Fault("identify.runs", "no run for identification", "at least one"))
    found = inspection.faults(rig, chosen)
    if found:
        raise MetrologyError(*found)
    cleaned = [inspection.without_saturation(one) for one in chosen]
    notes = [note for _, one in cleaned for note in one]
    notes += [note for one, _ in cleaned for note in inspection.remarks(one)]
    return tuple(one for one, _ in cleaned), tuple(notes)


def _unanswered(rig: Rig, runs: Sequence[MeasuredRun]) -> str:
    messages = [motion.message for one in runs if (motion := simulate(rig, one.run)).status != "ok"]
    reason = messages[0] if messages else said("the motion could not be followed with the start values")
    return said("nothing was fitted: {reason}; check the stated rig and the start values", reason=reason)


def _failed(
    rig: Rig,
    runs: tuple[MeasuredRun, ...],
    layout: Layout,
    given: tuple[tuple[Prior, ...], tuple[str, ...]],
    sentence: str,
) -> Identification:
    nothing = np.full(len(layout.unknowns), math.nan)
    return Identification(
        status="failed", sentence=sentence, rig=rig, runs=runs, layout=layout, priors=given[0], theta=nothing,
        covariance=None, parameters=(), chi_squared=math.nan, dof=0, residuals=(), log_evidence=-math.inf, steps=0,
        notes=given[1],
    )  # fmt: skip


def _identified(
    rig: Rig,
    posed: tuple[tuple[MeasuredRun, ...], Layout, tuple[Prior, ...]],
    found: Found,
    notes: tuple[str, ...],
    profile: bool,
) -> Identification:
    runs, layout, priors = posed
    solution = found.solution
    assert solution.point is not None
    spread = covariance(found.problem, solution)
    parameters = _estimates(found, layout, spread, profile)
    known = sum(entry.u is not None for entry in layout.unknowns)
    dof = found.problem.count + known - len(layout.unknowns)
    sentence = counted(
        "converged in {steps} steps of the last search, {whole} in all, {count} search",
        "converged in {steps} steps of the last search, {whole} in all, {count} searches",
        found.searches,
        steps=solution.steps,
        whole=found.steps,
    )
    if found.spent:
        text = "{sentence}; the iteration limit was reached before all starts were tried: another start may end lower"
        sentence = said(text, sentence=sentence)
    return Identification(
        status="ok", sentence=sentence, rig=rig, runs=runs, layout=layout, priors=priors, theta=solution.point.theta,
        covariance=spread, parameters=parameters, chi_squared=solution.point.chi_squared, dof=dof,
        residuals=_residuals(runs, found), log_evidence=log_evidence(found.problem, solution), steps=found.steps,
        notes=(*notes, *_contradictions(parameters, spread), *_misfit(spread)),
    )  # fmt: skip


def _estimates(found: Found, layout: Layout, spread: Covariance, profile: bool) -> tuple[Estimated, ...]:
    assert found.solution.point is not None
    total = np.sqrt(np.maximum(np.diag(spread.total), 0.0))
    bread = np.sqrt(np.maximum(np.diag(spread.bread), 0.0))
    estimates = []
    for at, entry in enumerate(layout.unknowns):
        value, u = float(found.solution.point.theta[at]), float(total[at])
        blind = entry.u is None and float(bread[at]) > 1e3 * max(abs(value), entry.scale)
        u = float(bread[at]) if blind else u
        if profile and entry.u is None and not blind:
            ends = interval(found.problem, found.solution, at, u, float(bread[at]))
        else:
            ends = Interval(value - NORMAL_95 * u, value + NORMAL_95 * u, "parabola")
        determined = not blind and ends.kind != "one-sided"
        sentence = "" if determined else _undetermined(entry.name, entry.unit, ends, blind)
        known = (entry.mean, entry.u)
        estimates.append(
            Estimated(entry.name, entry.unit, value, u, *known, ends.low, ends.high, ends.kind, determined, sentence)
        )
    return tuple(estimates)


def _undetermined(name: str, unit: str, ends: Interval, blind: bool) -> str:
    if blind:
        return said("these runs say nothing about {name}", name=name)
    if ends.high is not None:
        text = "{name} is not determined by these runs; it is at most {value:.4g} {unit} (95 %, one-sided)"
        return said(text, name=name, value=float(ends.high), unit=unit)
    assert ends.low is not None
    text = "{name} is not determined by these runs; it is at least {value:.4g} {unit} (95 %, one-sided)"
    return said(text, name=name, value=float(ends.low), unit=unit)


def _residuals(runs: Sequence[MeasuredRun], found: Found) -> tuple[Residual, ...]:
    """Residuals of all readings: those without weight as well, where a reading and the model are there."""
    assert found.solution.point is not None
    residuals = []
    for measured, block, weighted in zip(runs, found.problem.blocks, found.solution.point.residuals, strict=True):
        for segment in block.segments:
            part = weighted[segment.first : segment.last]
            t = measured.stamps(segment.name)[: len(part)]
            used = part != 0.0
            scaled = np.where(used, part * measured.noise[segment.name], np.nan)
            residuals.append(Residual(measured.name, segment.name, t, scaled, np.where(used, part, np.nan), used))
    return tuple(residuals)


def _contradictions(parameters: Sequence[Estimated], spread: Covariance) -> list[str]:
    """Known inputs that the fit moved too far, and what that means beside residuals that are, or are not, noise."""
    misfit = any(entry.inflation > UNEXPLAINED for entry in spread.scatter)
    reason = said(
        "the residuals are not noise, so the model lacks something for which this input stands in"
        if misfit
        else "the residuals are noise, so the statement is wrong, or the model lacks what acts alike"
    )
    found: list[str] = []
    for entry in parameters:
        if entry.prior_u is None or entry.prior_mean is None:
            continue
        distance = (entry.value - entry.prior_mean) / entry.prior_u
        if abs(distance) > CONTRADICTED:
            found.append(
                said(
                    "the fitted and the stated {name} disagree by {distance:.1f} u: {value:.5g} against {stated:.5g} "
                    "with u = {u:figures}; {reason}",
                    name=entry.name,
                    distance=float(abs(distance)),
                    value=float(entry.value),
                    stated=float(entry.prior_mean),
                    u=f"{entry.prior_u:.3g} {entry.unit}".removesuffix(" 1"),
                    reason=reason,
                )
            )
    return found


def _misfit(spread: Covariance) -> list[str]:
    return [
        said(
            "{run}, {channel}: residuals are {ratio:.2f} times the noise, and correlated over {length:.1f} readings: "
            "uncertainties are widened, which does not cover a bias of the model",
            run=entry.block,
            channel=entry.channel,
            ratio=math.sqrt(entry.chi_squared),
            length=float(entry.correlation_length),
        )
        for entry in spread.scatter
        if entry.inflation > UNEXPLAINED
    ]


def fit_own(rig: Rig, measured: MeasuredRun, own: Sequence[Prior]) -> Identification:
    """Inputs of one run re-estimated within their priors, everything else held; for runs of any purpose.

    Parameters
    ----------
    rig : Rig
        With the values that are held.
    measured : MeasuredRun
        The run.
    own : sequence of Prior
        With a part per run.

    Returns
    -------
    Identification
        With status 'failed' and a sentence where the search did not converge.

    Raises
    ------
    MetrologyError
        Names that the rig does not have, uncertainties that are negative.
    """
    cleaned, notes = inspection.without_saturation(measured)
    layout = lay_out(rig, [cleaned.name], (), own)
    start = np.array([entry.start for entry in layout.unknowns])
    found = search(rig, [cleaned], layout, [start])
    if found is None or found.solution.status != "converged":
        sentence = said("the run's own inputs could not be re-estimated")
        return _failed(rig, (cleaned,), layout, (tuple(own), notes), sentence)
    return _identified(rig, ((cleaned,), layout, tuple(own)), found, notes, profile=False)
