"""What the templates print, arranged: each value as text in its display unit, each thing with a place to link to."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, Any

from metrology.coordinate import QUANTITIES, Coordinate
from metrology.findings import Comparison, Conformity, Findings, Result, TestItem
from metrology.methods import METHODS
from metrology.report import diagnosis, notices, quality, wording
from metrology.report.budget import budget, shortened, sources
from metrology.report.display import (
    Shown,
    aligned,
    concise,
    estimate,
    number,
    prefixed,
    rounded,
    scale,
    symbol,
    unit_text,
)
from metrology.report.ways import ways

if TYPE_CHECKING:
    from metrology.report.attachments import Attachment
    from metrology.report.figures.style import Plot
    from metrology.response import PaperResult

NAMES = {name: output.word for method in METHODS.values() for name, output in method.outputs.items()}
"""Quantities → what they are called."""
MARKS = {"pass": "✓", "conditional pass": "◐", "conditional fail": "✗", "fail": "✗"}
LARGEST_MATRIX = 12
WIDEST = 9
"""Characters that a number of the table on page 1 has room for."""


@dataclass(frozen=True)
class Line:
    """One result as a line of a table: texts of the law (`shown`) and of Monte Carlo, shortest and symmetric."""

    result: Result
    anchor: str
    sample: str
    name: str
    shown: Shown
    trials: Shown
    symmetric: Shown
    value: str
    u: str
    low: str = ""
    high: str = ""

    @property
    def leads(self) -> Shown:
        """The law's interval where Monte Carlo confirms it, else the shortest Monte Carlo one."""
        return self.shown if self.result.monte_carlo.law_valid else self.trials


@dataclass(frozen=True)
class Method:
    """A method once, however many tests used it."""

    name: str
    title: str
    standard: str
    equations: tuple[str, ...]
    tests: tuple[str, ...]


def context(findings: Findings, plots: Mapping[str, Plot], files: Sequence[Attachment] = ()) -> dict[str, Any]:
    """All names that a template can use."""
    lines = _lines(findings)
    made = methods(findings)
    return {
        "findings": findings,
        "campaign": findings.campaign,
        "plots": plots,
        "lines": lines,
        "headlines": _aligned([line for line in lines if line.result.headline]),
        "replaced": replaced(lines),
        "without_result": without_result(findings),
        "others": [line for line in lines if not line.result.headline],
        "budget": budget,
        "sources": sources(findings),
        "shortened": shortened,
        "verdict": wording.verdict,
        "methods": made,
        "derived": derived(lines),
        "judged": [(entry, _limits(entry), f"requirement-{i}") for i, entry in enumerate(findings.conformity, 1)],
        "compared": [(entry, *_sides(entry)) for entry in findings.comparisons],
        "matrix": matrix(findings),
        "marks": MARKS,
        "sections": sections(findings),
        "sample_names": {sample.id: sample.name for sample in findings.samples},
        "created": issued(findings),
        "attached": {file.path: file for file in files},
        "test_dates": _span([test.date for test in findings.tests if test.date]),
        "prefixed": prefixed,
        "estimate": estimate,
        "rounded": rounded,
        "concise": concise,
        "label": "Reconstructed readings" if findings.campaign.reconstructed else "",
        "scaled": scaled,
        "sized": sized,
        "way": way,
        "ways": ways,
        "second_models": second_models,
        "channel_unit": channel_unit,
        "chapters": diagnosis.chapters(findings),
        **notices.names(findings, [method.title for method in made]),
        **quality.names(findings),
    }


def replaced(lines: Sequence[Line]) -> dict[str, list[tuple[Line, Shown]]]:
    """Headline results that the model as stated gives otherwise, with what it gives, by the reason why."""
    found: dict[str, list[tuple[Line, Shown]]] = {}
    for line in lines:
        known = line.result.stated
        if known is not None and line.result.headline:
            shown = estimate(known.value, known.u, line.result.display_unit)
            found.setdefault(f"{line.result.test or line.result.name}: {known.why}", []).append((line, shown))
    return found


def second_models(findings: Findings, test: str) -> list[dict[str, Any]]:
    """Verifications of a test by its extended model."""
    return [one for one in findings.verification if one["test"] == test and one.get("basis") == "extended"]


def without_result(findings: Findings) -> list[str]:
    """Requirements without a verdict for want of a result."""
    withheld = {one.requirement for one in findings.withheld}
    return [name for name in findings.unjudged if name not in withheld]


def issued(findings: Findings) -> str:
    """Date of issue, ``2026-11-20``; empty where there is none."""
    date = findings.campaign.issued
    return date if re.fullmatch(r"\d{4}-\d\d-\d\d", date) else ""


def sections(findings: Findings) -> list[tuple[str, str]]:
    """Template and title of every section after the first page, in order; what a campaign does not have is left out."""
    wanted = (
        ("scope", "Purpose, place and sampling", True),
        ("samples", "Items tested", True),
        ("instruments", "Instruments and their calibration", True),
        ("environment", "Dates, persons and conditions", True),
        ("methods", "Methods", True),
        ("tests", "Results of each test", bool(findings.tests)),
        ("diagnosis", "What the model lacks", bool(findings.diagnosis)),
        ("fits", "Calibration lines and curves", bool(findings.fits)),
        ("budgets", "Uncertainty of each result", bool(findings.results)),
        ("correlations", "Correlations of the results", bool(findings.correlations)),
        ("conformity", "Conformity with requirements", True),
        ("comparisons", "Comparisons", bool(findings.comparisons)),
        ("audit", "Audit of published and expected figures", bool(findings.audit)),
        ("opinions", "Opinions and interpretations", bool(findings.campaign.opinions)),
        ("deviations", "Deviations, exclusions and anomalies", True),
        ("sources", "Inputs and their sources", any(result.budget for result in findings.results)),
        ("references", "References", True),
        ("provenance", "Provenance", True),
        ("signatures", "Signatures", bool(findings.campaign.signatures)),
        ("checklist", "Annex: checklist of the report", bool(findings.campaign.checklists)),
    )
    return [(name, title) for name, title, present in wanted if present]


def methods(findings: Findings) -> list[Method]:
    """Every method with its equations, and the tests that used it."""
    samples = {sample.id: sample.name for sample in findings.samples}
    grouped: dict[tuple[str, str, str, tuple[str, ...]], list[str]] = {}
    for test in findings.tests:
        title = test.title.removesuffix(f": {samples.get(test.sample, test.sample)}")
        grouped.setdefault((test.method, title, test.standard, _equations(test)), []).append(test.id)
    return [Method(*key, tests=tuple(tests)) for key, tests in grouped.items()]


def _equations(test: TestItem) -> tuple[str, ...]:
    return test.finding.equations if test.finding is not None else ()


def way(paper: PaperResult | None, name: str) -> tuple[float, float | None] | None:
    """Value and u of k or c the paper's way; None where there is none."""
    if paper is None or name not in {"k", "c"}:
        return None
    value, u = (paper.k, paper.k_u) if name == "k" else (paper.c, paper.c_u)
    return None if value is None else (value, u)


def channel_unit(channel: str, coordinate: Coordinate = "position") -> str:
    """SI unit of a channel of a response test, by what x is."""
    return QUANTITIES[coordinate][channel].unit


def told_in_figures(note: str) -> bool:
    """Whether a note on a response test gives the noise of a run, which its plot and table show anyway."""
    return ": standard uncertainty of one reading: " in note


def derived(lines: list[Line]) -> list[tuple[str, str]]:
    """Equation of every derived quantity, with the names of those that it gives."""
    grouped: dict[str, list[str]] = {}
    for line in lines:
        if line.result.method == "derived":
            grouped.setdefault(line.result.equation, []).append(line.result.name)
    return [(equation, ", ".join(names)) for equation, names in grouped.items()]


def matrix(findings: Findings) -> list[tuple[str, list[str]]]:
    """Correlation coefficients of the headline results, lower triangle; empty where they are too many for a page."""
    results = [result for result in findings.results if result.headline] or findings.results
    if len(results) > LARGEST_MATRIX:
        return []
    samples = {sample.id: sample.name for sample in findings.samples}
    known = {frozenset((pair.a, pair.b)): pair.coefficient for pair in findings.correlations}
    rows = []
    for i, result in enumerate(results):
        cells = [known.get(frozenset((result.name, other.name))) for other in results[:i]]
        owner = samples.get(result.sample, result.sample)
        name = ", ".join(filter(None, (symbol(result.quantity).replace("_n", "ₙ"), owner, result.method)))
        rows.append((name, ["" if r is None else f"{r:+.2f}".replace("-", "−") for r in cells] + ["1"]))
    return rows


def scaled(value: float | None, unit: str) -> str:
    """A value of an SI unit in its display unit, to four digits; a dash for nothing."""
    from metrology.units import convert

    return "–" if value is None else f"{number(convert(value, unit), 4)} {unit_text(unit)}".rstrip()


def sized(value: float, unit: str) -> str:
    """A value of an SI unit on the scale that reads well, to three digits."""
    factor, text = scale(value, unit)
    return f"{number(value / factor)} {text}".rstrip()


def _lines(findings: Findings) -> list[Line]:
    samples = {sample.id: sample.name for sample in findings.samples}
    return [_line(result, f"result-{i}", samples) for i, result in enumerate(findings.results, 1)]


def _line(result: Result, anchor: str, samples: Mapping[str, str]) -> Line:
    law, trials, unit = result.coverage, result.monte_carlo, result.display_unit
    shown = estimate(result.value, result.u, unit, (law.low, law.high))
    return Line(
        result=result,
        anchor=anchor,
        sample=samples.get(result.sample, result.sample),
        name=NAMES.get(result.quantity, ""),
        shown=shown,
        trials=estimate(trials.mean, result.u, unit, (trials.shortest_low, trials.shortest_high)),
        symmetric=_symmetric(result),
        value=shown.value,
        u=shown.u,
    )


def _symmetric(result: Result) -> Shown:
    """Mean, u and symmetric interval by Monte Carlo: where the draws have no u, rounded by that of the law."""
    trials, unit = result.monte_carlo, result.display_unit
    ends = (trials.low, trials.high)
    if isfinite(trials.u):
        return estimate(trials.mean, trials.u, unit, ends)
    return replace(estimate(trials.mean, result.u, unit, ends), u="–")


def _aligned(lines: list[Line]) -> list[Line]:
    """Lines whose values, u and ends of the leading interval stand with their decimals below each other."""
    units = [line.shown.unit for line in lines]
    columns = (
        _column([line.shown.value for line in lines], units),
        _column([line.shown.u for line in lines], units),
        _column([line.leads.low for line in lines], units),
        _column([line.leads.high for line in lines], units),
    )
    return [
        replace(line, value=value, u=u, low=low, high=high)
        for line, value, u, low, high in zip(lines, *columns, strict=True)
    ]


def _column(texts: list[str], units: list[str]) -> list[str]:
    """Numbers with their decimals below each other; where that is too wide for the page, those of one unit only."""
    together = aligned(texts)
    if max(map(len, together), default=0) <= WIDEST:
        return together
    found = list(texts)
    for unit in set(units):
        places = [i for i, other in enumerate(units) if other == unit]
        for place, text in zip(places, aligned([texts[i] for i in places]), strict=True):
            found[place] = text
    return found


def _limits(entry: Conformity) -> str:
    lower, upper = entry.lower, entry.upper
    if lower is not None and upper is not None:
        return f"{scaled(lower, entry.display_unit)} to {scaled(upper, entry.display_unit)}"
    return f"≥ {scaled(lower, entry.display_unit)}" if upper is None else f"≤ {scaled(upper, entry.display_unit)}"


def _sides(entry: Comparison) -> tuple[Shown, Shown, Shown]:
    unit = entry.display_unit
    return (
        estimate(entry.value_a, entry.u_a, unit),
        estimate(entry.value_b, entry.u_b, unit),
        estimate(entry.difference, entry.u_difference, unit),
    )


def _span(dates: list[str]) -> str:
    return "" if not dates else dates[0] if len(set(dates)) == 1 else f"{min(dates)} to {max(dates)}"
