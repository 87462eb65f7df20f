"""Diagnosis of response tests."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from metrology.diagnosis import Diagnosis
from metrology.diagnostics.candidate import Candidate, turned_table
from metrology.diagnostics.engine import BUDGET, rank
from metrology.diagnostics.overlays import Overlay, largest_step, sought_apart, with_overlays
from metrology.diagnostics.own import declared
from metrology.diagnostics.runs import Response
from metrology.diagnostics.subject import LOST, Fit, Marks
from metrology.errors import Fault, MetrologyError
from metrology.estimation import MeasuredRun, Prior, inspection, repeats, search, step
from metrology.estimation.step import Step
from metrology.message import counted, said
from metrology.noise import OUTLYING, outlying, spikes
from metrology.rig import Rig, engines
from metrology.rig.own import OwnEffect


def response(
    rig: Rig, runs: Sequence[MeasuredRun], *, rng: np.random.Generator, free: Sequence[str] = ("k", "c"),
    priors: Sequence[Prior] = (), settings: Settings | None = None,
) -> Diagnosis:  # fmt: skip
    """Diagnose response tests: what the model of the rig lacks, why, and what an extension gains.

    Parameters
    ----------
    rig : Rig
        As the laboratory states it; effects that it carries already belong to the base model.
    runs : sequence of MeasuredRun
        All of the test, whatever their purpose: each is left out once.
    rng : Generator
        For simulated limits and bootstrap intervals.
    free : sequence of str
        Parameters of which nothing is known.
    priors : sequence of Prior
        What is known within an uncertainty, with a common part and a part per run.
    settings : Settings, optional
        Names, start values, budget.

    Raises
    ------
    MetrologyError
        No run, runs that cannot be what they claim, or names that the rig does not have.
    """
    settings = settings or Settings()
    faults = inspection.faults(rig, runs)
    if not runs:
        faults.append(Fault("diagnose.runs", "no run", "at least one"))
    if faults:
        raise MetrologyError(*faults)
    # Both before anything is fitted: which of them were there would else change the last digits.
    for base in (False, True):
        engines.compiled(base)
    unsaturated = [inspection.without_saturation(run)[0] for run in runs]
    stepless, steps = step.without(rig, unsaturated, free, priors)
    single = [repeats.without_repeats(run) for run in stepless]
    cleaned = tuple(run for run, _ in single)
    repeated = sum(count for _, count in single)
    subject = Response(
        rig, cleaned, tuple(free), tuple(priors), settings.sample, dict(settings.start), workers=settings.workers
    )
    if rig.coordinate == "angle":
        subject = replace(subject, candidates=turned_table())
    subject, notes = _prepared(subject)
    if repeated:
        text = (
            "Where {times} readings in a row or more lie within one division, their rounding does not average out: "
            "{count} of them are left out."
        )
        notes.append(said(text, times=repeats.REPEATED, count=repeated))
    forces = {effect.name: declared(effect) for effect in settings.own if effect.force}
    candidates = _open(subject.candidates, {*rig.effects}, settings.without) | forces
    found = rank(
        replace(subject, candidates=candidates), rng=rng, test=settings.test, budget=settings.budget,
        workers=settings.workers, progress=settings.progress,
    )  # fmt: skip
    if all({"x", "v"} <= {*run.channels} for run in cleaned):
        found = with_overlays(sought_apart(found), _stepped(steps, cleaned[0].unit("x")))
    return replace(found, notes=(*found.notes, *notes), coordinate=rig.coordinate)


def _open(every: Mapping[str, Candidate], carried: Container[str], left_out: Container[str]) -> dict[str, Candidate]:
    """Candidates but those left out, and those that are tried beside one of these alone.

    What the stated model carries is beside all of them.
    """
    found = {}
    for name, one in every.items():
        first = one.cause.beside
        there = first != "" and every[first].size.name in carried
        if name not in left_out and (there or not first or first not in left_out):
            found[name] = replace(one, cause=replace(one.cause, beside="")) if there else one
    return found


@dataclass(frozen=True)
class Settings:
    """How a diagnosis is done.

    Parameters
    ----------
    sample, test : str
        Ids, for the result.
    start : mapping of str to float
        Where the base fit begins, by name of unknown. All values of an `Identification` with the same free parameters
        and priors spare the search for the optimum.
    without : tuple of str
        Candidates that are not to be tried.
    own : tuple of OwnEffect
        Effects of the laboratory's own, tried like all others; their forces belong to the rig.
    budget : int
        Fits of sets of effects at most.
    workers : int
        Fits at a time.
    progress : callable, optional
        Takes one line of text now and then.
    """

    sample: str = ""
    test: str = ""
    start: Mapping[str, float] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    own: tuple[OwnEffect, ...] = ()
    budget: int = BUDGET
    workers: int = 2
    progress: Callable[[str], None] | None = None


def _stepped(steps: Mapping[str, Step], unit: str) -> list[Overlay]:
    """Steps of the position that no velocity shows, by run."""
    if not steps:
        return []
    value = largest_step(list(steps.values()), unit)
    places = tuple(
        said(
            "{size:.3g} m{unit} at {time:.4g} s in {record}", size=1e3 * one.size, unit=unit, time=one.time, record=name
        )
        for name, one in steps.items()
    )
    text = "Found before the fit, and the readings of x after it left out: {hops}."
    return [Overlay("hop", (value,), said(text, hops=places), sum(one.log_bayes for one in steps.values()))]


ROUGH = 1.2
"""χ² for each reading from which on the base model is sought from several starts; so it is where its steps ran out."""


def _searched(subject: Response, found: Fit | None) -> Fit | None:
    """Better of an optimum and of what a thorough search finds, where the first one is poor."""
    rig, layout = subject.layout((), subject.start)
    begun = all(entry.name in subject.start for entry in layout.unknowns)
    if found is not None and (begun or (found.chi_squared < ROUGH * found.count and not found.spent)):
        return found
    other = search.search(rig, subject.runs, layout, search.starts(rig, layout))
    if other is None or other.solution.point is None:
        return found
    values = dict(zip([entry.name for entry in layout.unknowns], other.solution.point.theta.tolist(), strict=True))
    again = subject.fit((), [values])
    if found is None or again is None:
        return found or again
    return min(found, again, key=lambda fit: fit.mean_cost)


def _prepared(subject: Response) -> tuple[Response, list[str]]:
    """Leave out single readings far off among good neighbours, and say so; by the model, or by themselves.

    Of a model that loses the motion nothing is far off: there it is what their neighbours contradict.
    """
    fit = _searched(subject, subject.fit((), [{}]))
    if fit is None:
        return subject, []
    follows = _cost_beside(fit) <= LOST
    runs: list[MeasuredRun] = []
    found: dict[str, dict[str, int]] = {}
    for at, run in enumerate(subject.runs):
        marks = {}
        for segment in fit.problem.blocks[at].segments:
            rows = slice(segment.first, segment.last)
            residual = fit.residuals[at][rows]
            far = outlying(residual) if follows else _alone(run, segment.name)
            if far.any():
                marks[segment.name] = run.used(segment.name) & ~far
                found.setdefault(run.name, {})[segment.name] = int(far.sum())
        runs.append(replace(run, use={**run.use, **marks}))
    notes = [_left_out(found)] if found else []
    begun = {**subject.start, **fit.values} if follows else subject.start
    return replace(subject, runs=tuple(runs), start=begun), notes


def _alone(run: MeasuredRun, channel: str) -> Marks:
    """Single readings far off among their neighbours, by the readings of a channel alone."""
    values, used = np.asarray(getattr(run, channel), dtype=float), run.used(channel)
    far = np.zeros(len(values), dtype=bool)
    far[used] = spikes(values[used], run.noise[channel])
    return far


def _cost_beside(fit: Fit) -> float:
    """Cost for each reading without those far off among good neighbours: three of them make any fit a poor one."""
    cost = fit.mean_cost * fit.count
    for block, residual in zip(fit.problem.blocks, fit.residuals, strict=True):
        parts = (residual[one.first : one.last] for one in block.segments)
        cost -= sum(float(np.sum(part[outlying(part)] ** 2)) for part in parts)
    return cost / fit.count


def _left_out(found: Mapping[str, Mapping[str, int]]) -> str:
    """Note on outliers; `found`: how many, by run and channel."""
    count = sum(sum(channels.values()) for channels in found.values())
    places = tuple(
        f"{run} ({', '.join(f'{name}: {own}' for name, own in channels.items())})" for run, channels in found.items()
    )
    return counted(
        "{count} outlier, a single reading more than {limit:g} standard uncertainties off among good neighbours, is "
        "left out (drop-outs, reflections): {places}",
        "{count} outliers, single readings more than {limit:g} standard uncertainties off among good neighbours, are "
        "left out (drop-outs, reflections): {places}",
        count, limit=OUTLYING, places=places,
    )  # fmt: skip
