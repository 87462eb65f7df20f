"""Plots of the report as SVG: one module per subject, each drawn once and used by HTML and PDF alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.report.figures.style import Plot

Job = tuple[str, Callable[[], "Plot"]]


def draw(findings: Findings, progress: Callable[[str], None] = lambda _text: None) -> Mapping[str, Plot]:
    """Every plot of a report by its key: subject, then what it is of: ``elongation/al-1100-elongation``."""
    label = "RECONSTRUCTED READINGS" if findings.campaign.reconstructed else ""
    jobs = [*_tests(findings, label), *_evaluations(findings, label), *_judgements(findings, label)]
    plots = {}
    for index, (key, job) in enumerate(jobs, 1):
        progress(f"drawing plot {index} of {len(jobs)}")
        plots[key] = job()
    return plots


def _tests(findings: Findings, label: str) -> Iterator[Job]:
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
                yield f"decay/{test.id}", partial(decay.draw, releases, title, label=label)
            yield f"decrement/{test.id}", partial(decrement.draw, releases, title, label=label)
            yield f"damping/{test.id}", partial(damping.draw, releases, title, label=label)
        if test.response is not None and test.response.runs:
            yield f"response/{test.id}", partial(response.draw_fit, test.response.runs, title, label=label)
        for check in findings.verification:
            if check["test"] == test.id:
                for run in check["runs"]:
                    job = partial(response.draw_verification, run, title, label=label)
                    yield f"verification/{test.id}/{run['run']}", job
    for told in findings.diagnosis:
        yield from diagnosis.jobs(told, label)


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
