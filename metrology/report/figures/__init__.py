"""Plots of the report as SVG: one module per subject, each drawn once and used by HTML and PDF alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.report.figures.style import Plot
    from metrology.timeseries import Trace

Job = tuple[str, Callable[[], "Plot"]]


def draw(
    findings: Findings,
    progress: Callable[[str], None] = lambda _text: None,
    *,
    traces: Mapping[str, Trace] = MappingProxyType({}),
) -> Mapping[str, Plot]:
    """Every plot of a report by its key: subject, then what it is of: ``elongation/al-1100-elongation``.

    `traces` are what the plots that can be zoomed hold; without them it is what the findings hold.
    """
    label = "RECONSTRUCTED READINGS" if findings.campaign.reconstructed else ""
    jobs = [*_tests(findings, label, traces), *_evaluations(findings, label), *_judgements(findings, label)]
    plots = {}
    for index, (key, job) in enumerate(jobs, 1):
        progress(f"drawing plot {index} of {len(jobs)}")
        plots[key] = job()
    return plots


def _tests(findings: Findings, label: str, traces: Mapping[str, Trace]) -> Iterator[Job]:
    from metrology.report.figures import damping, decay, decrement, diagnosis, elongation, response
    from metrology.report.figures.style import plain

    for test in findings.tests:
        title = f"{plain(test.title)}, {plain(test.sample)}"
        if test.elongation is not None and test.elongation.force:
            finding = test.elongation
            yield f"elongation/{test.id}", partial(elongation.draw, finding, title, label=label)
        if test.decay is not None and test.decay.records:
            releases = test.decay
            if any(record.time for record in releases.records):
                key = f"decay/{test.id}"
                yield key, partial(decay.draw, releases, title, label=label, traces=_of(traces, key))
            yield f"decrement/{test.id}", partial(decrement.draw, releases, title, label=label)
            yield f"damping/{test.id}", partial(damping.draw, releases, title, label=label)
        if test.response is not None and test.response.runs:
            key, runs = f"response/{test.id}", test.response.runs
            yield key, partial(response.draw_fit, runs, title, label=label, traces=_of(traces, key))
        for check in findings.verification:
            if check["test"] == test.id:
                for run in check["runs"]:
                    key = f"verification/{test.id}/{run['run']}"
                    own = _of(traces, key)
                    yield key, partial(response.draw_verification, run, title, label=label, traces=own)
    for told in findings.diagnosis:
        yield from diagnosis.jobs(told, label)


def _of(traces: Mapping[str, Trace], key: str) -> dict[str, Trace]:
    """Traces of one plot, by what is left of their names."""
    return {name.removeprefix(f"{key}/"): trace for name, trace in traces.items() if name.startswith(f"{key}/")}


def _evaluations(findings: Findings, label: str) -> Iterator[Job]:
    from metrology.report.figures import density, fit

    for entry in findings.fits:
        if entry.x:
            yield f"fit/{entry.name}", partial(fit.draw, entry, label=label)
    for result in findings.results:
        if result.headline and result.monte_carlo.density:
            yield f"density/{result.name}", partial(density.draw, result, label=label)


def _judgements(findings: Findings, label: str) -> Iterator[Job]:
    from metrology.report.figures import comparison, conformity

    for entry in findings.conformity:
        yield f"conformity/{entry.requirement}", partial(conformity.draw, entry, label=label)
    if findings.comparisons:
        yield "comparison", partial(comparison.draw, findings.comparisons, label=label)
