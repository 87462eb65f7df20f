"""Plots of the report as SVG: one module per subject, each drawn once and used by HTML and PDF alike.

The module of a method has a function `jobs`: the plots of a test by it, each with its key and how it is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from metrology.findings import Findings
    from metrology.language.catalogue import Language
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
    drawn = jobs(findings, traces)
    plots = {}
    for index, (key, job) in enumerate(drawn.items(), 1):
        progress(f"drawing plot {index} of {len(drawn)}")
        plots[key] = job()
    return plots


def jobs(
    findings: Findings, traces: Mapping[str, Trace] = MappingProxyType({}), *, every: bool = False
) -> dict[str, Callable[[], Plot]]:
    """How each plot of a report is drawn, by its key; nothing is drawn yet.

    `every`: each test has its own plots, also the one that the certificate has already.
    """
    from metrology.language.catalogue import languages

    across, language = label(findings.campaign.reconstructed), languages(findings)[0]
    certified, story = _story(findings, across, language)
    of_tests = [*story, *_tests(findings, across, traces, language, "" if every else certified)]
    return dict([*of_tests, *_evaluations(findings, across, language), *_judgements(findings, across, language)])


def label(reconstructed: str) -> str:
    """What stands across a plot, by what a campaign says of readings that were not measured."""
    return "RECONSTRUCTED READINGS" if reconstructed else ""


@dataclass(frozen=True)
class Subject:
    """What the plots of a test are of: its name, their title, a label on each, and traces for those that zoom.

    `language` is that of their words. `certified`: the certificate has the plot of its first record.
    """

    test: str
    title: str
    label: str
    traces: Mapping[str, Trace]
    language: Language
    certified: bool = False

    def of(self, key: str) -> dict[str, Trace]:
        """Traces of one plot, by what is left of their names."""
        found = self.traces.items()
        return {name.removeprefix(f"{key}/"): trace for name, trace in found if name.startswith(f"{key}/")}


def _subjects(
    findings: Findings, label: str, traces: Mapping[str, Trace], language: Language, certified: str = ""
) -> Mapping[str, Subject]:
    from metrology.language import done
    from metrology.report.figures.style import plain

    named = (
        (test.id, f"{plain(done.title(test, findings, language))}, {plain(test.sample)}") for test in findings.tests
    )
    return {test: Subject(test, title, label, traces, language, test == certified) for test, title in named}


def _story(findings: Findings, label: str, language: Language) -> tuple[str, list[Job]]:
    """The picture of the certificate, and the test that it need not be drawn of again.

    It holds what the findings hold, whatever traces there are.
    """
    from metrology.report.figures import story

    found = story.job(findings, _subjects(findings, label, {}, language))
    return ("", []) if found is None else (found[0], [("story", found[1])])


def _tests(
    findings: Findings, label: str, traces: Mapping[str, Trace], language: Language, certified: str
) -> Iterator[Job]:
    from metrology.report.figures import diagnosis, step

    subjects = _subjects(findings, label, traces, language, certified)
    for test in findings.tests:
        subject = subjects[test.id]
        if test.finding is not None:
            yield from import_module(f"{__name__}.{test.by}").jobs(test.finding, subject)
        if test.response is not None:
            yield from step.jobs(findings, subject)
        yield from _verifications(findings, subject)
    for diagnosed in findings.diagnosis:
        yield from diagnosis.jobs(diagnosed, label, language)


def _verifications(findings: Findings, subject: Subject) -> Iterator[Job]:
    """Every run of a test that its fit has not seen, beside its simulation: by both models where there is a second."""
    checks = {one.get("basis", "stated"): one["runs"] for one in findings.verification if one["test"] == subject.test}
    if not checks:
        return
    from metrology.report.figures import models
    from metrology.report.figures.response import draw_verification

    second = {run["run"]: run for run in checks.get("extended", ())}
    for run in checks["stated"]:
        key, beside = f"verification/{subject.test}/{run['run']}", second.get(run["run"])
        known = subject.of(key)
        named: dict[str, Any] = {"label": subject.label, "language": subject.language}
        draw = partial(draw_verification, run, subject.title, traces=known, **named)
        if beside is not None and run["series"] and beside["series"]:
            both = {"stated": known, "extended": subject.of(f"extended/{subject.test}/{run['run']}")}
            draw = partial(models.draw, run, beside, subject.title, traces=both, **named)
        yield key, draw


def _evaluations(findings: Findings, label: str, language: Language) -> Iterator[Job]:
    from metrology.report.figures import density, fit

    for entry in findings.fits:
        if entry.x:
            yield f"fit/{entry.name}", partial(fit.draw, entry, label=label, language=language)
    for result in findings.results:
        if result.headline and result.monte_carlo.density:
            yield f"density/{result.name}", partial(density.draw, result, label=label, language=language)


def _judgements(findings: Findings, label: str, language: Language) -> Iterator[Job]:
    from metrology.language import done
    from metrology.report.figures import comparison, conformity

    for entry in findings.conformity:
        yield f"conformity/{entry.requirement}", partial(conformity.draw, entry, label=label, language=language)
    if findings.comparisons:
        sides = {side for entry in findings.comparisons for side in (entry.a, entry.b)}
        names = {side: done.short_name(side, findings, language) for side in sides}
        yield "comparison", partial(comparison.draw, findings.comparisons, label=label, names=names, language=language)
