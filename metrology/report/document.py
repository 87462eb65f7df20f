"""What the templates print, arranged: each value as text in its display unit, each thing with a place to link to."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, Any

from metrology.coordinate import QUANTITIES, Coordinate
from metrology.findings import AuditRow, Comparison, Conformity, Correlation, Findings, Result, TestItem, Withheld
from metrology.language import answers, attention, done, notices, wording
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import (
    Shown,
    aligned,
    as_stated,
    concise,
    estimate,
    like,
    number,
    prefixed,
    rounded,
    scale,
    symbol,
    width,
)
from metrology.message import said
from metrology.methods import METHODS
from metrology.report import consensus, decimals, diagnosis, quality
from metrology.report.budget import Budget, budgets, freedom, shortened, sources
from metrology.report.ways import ways
from metrology.units import unit_text

if TYPE_CHECKING:
    from metrology.report.attachments import Attachment
    from metrology.report.figures.style import Plot
    from metrology.response import PaperResult

NAMES = {name: output.word for method in METHODS.values() for name, output in method.outputs.items()}
"""Quantities → what they are called."""
MARKS = {"pass": "✓", "conditional pass": "◐", "conditional fail": "✗", "fail": "✗"}
LARGEST_MATRIX = 12
"""Results up to which their correlation coefficients are a matrix; of more, as many pairs as it has are listed."""
WIDEST = 9
"""Characters that a number of the table on page 1 has room for."""


@dataclass(frozen=True)
class Line:
    """One result as a line of a table: texts of the framework (`shown`) and of Monte Carlo, shortest and symmetric.

    `value`, `u`, `low` and `high` are those that are reported, aligned with other lines.
    """

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
    expanded: str = ""
    before: Shown | None = None

    @property
    def leads(self) -> Shown:
        """By the framework where Monte Carlo confirms it, else by Monte Carlo with the interval that it reports."""
        if self.result.monte_carlo.law_valid:
            return self.shown
        if self.result.monte_carlo.reported == "shortest":
            return self.trials
        return replace(self.trials, low=self.symmetric.low, high=self.symmetric.high)


@dataclass(frozen=True)
class Method:
    """A method once, however many tests used it."""

    name: str
    title: str
    standard: str
    equations: tuple[str, ...]
    tests: tuple[str, ...]


def context(
    findings: Findings,
    plots: Mapping[str, Plot],
    files: Sequence[Attachment] = (),
    language: Language = ENGLISH,
) -> dict[str, Any]:
    """All names that a template can use; `language` is that of the annex."""
    lines = _lines(findings)
    made = methods(findings)
    found = consensus.names(findings, language)
    shown = {
        name: decimals.localised(function, language)
        for name, function in (
            ("prefixed", prefixed), ("estimate", estimate), ("rounded", rounded), ("concise", concise),
            ("scaled", scaled), ("sized", sized),
        )
    }  # fmt: skip
    headlines, common = _aligned([line for line in lines if line.result.headline], found["common"])
    rows: list[tuple[str, ...]] = [(one.value, one.u, one.expanded, one.low, one.high) for one in headlines]
    rows += [group.cells for group in common if group.cells]
    return {
        "findings": findings,
        "campaign": findings.campaign,
        "plots": plots,
        "lines": lines,
        "headlines": headlines,
        "replaced": any(line.before is not None for line in headlines),
        "crowded": crowded(rows) == "numbers",
        "wide_interval": crowded(rows) == "interval",
        "crowded_limits": crowded_limits((*findings.conformity, *findings.withheld)),
        "reasons": reasons(findings),
        "without_result": without_result(findings),
        "others": [line for line in lines if not line.result.headline],
        "units": {line.result.name: line.shown.unit for line in lines},
        "budgets": budgets(
            [line.result for line in lines if line.result.headline], findings.input_correlations, language
        ),
        "sources": sources(findings, language),
        "shortened": shortened,
        "verdict": lambda result: wording.verdict(result, language),
        "methods": made,
        "derived": derived(lines),
        "judged": [
            (entry, limits(entry, language), f"requirement-{i}") for i, entry in enumerate(findings.conformity, 1)
        ],
        "compared": [(entry, *_sides(entry)) for entry in findings.comparisons],
        "matrix": matrix(findings, language),
        "pairs": pairs(findings, language),
        "marks": MARKS,
        "sections": sections(findings),
        "sample_names": {sample.id: sample.name for sample in findings.samples},
        "created": issued(findings),
        "attached": {file.path: file for file in files},
        "test_dates": sorted({test.date for test in findings.tests if test.date}),
        **shown,
        "label": "Reconstructed readings" if findings.campaign.reconstructed else "",
        "way": way,
        "ways": lambda test: ways(findings, test, language),
        "second_models": second_models,
        "channel_unit": channel_unit,
        "chapters": diagnosis.chapters(findings, language),
        "spoken": lambda finding: answers.sentence(finding, language),
        "called": done.called(findings, language),
        "section_names": [name for name, _ in sections(findings)],
        "moved_inputs": moved_inputs,
        "audit_verdict": audit_verdict,
        "acceptance": lambda entry: acceptance(entry, language),
        "pair_name": lambda entry: notices.pair_name(entry, findings, language),
        "result_name": lambda name: done.result_name(name, findings, language),
        "freedom": freedom,
        "procedures": procedures(findings, language),
        "own_equations": lambda budget: _own_equations(budget, made),
        "first_record": _first_record(findings),
        "found": [text for kind, text in notices.brief(findings, language) if kind in ("Failure", "Check", "Fit")],
        "attention": attention.attention(findings, language),
        **quality.names(findings, language),
        **found,
        "common": common,
    }


def reasons(findings: Findings) -> dict[str, str]:
    """By test: why its results are not those of the model as stated."""
    return {one.test: one.stated.why for one in findings.results if one.headline and one.stated is not None}


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


SECTIONS = (
    ("methods", "Methods", "annex"),
    ("tests", "Results of each test", "annex"),
    ("diagnosis", "Diagnosis of the models", "annex"),
    ("fits", "Calibration lines and curves", "annex"),
    ("budgets", "Uncertainty of each result", "annex"),
    ("correlations", "Correlations of the results", "annex"),
    ("conformity", "Conformity with requirements", "annex"),
    ("comparisons", "Comparisons", "annex"),
    ("audit", "Audit of published and expected figures", "annex"),
    ("opinions", "Opinions and interpretations", "annex"),
    ("scope", "Purpose, place and sampling", "annex"),
    ("samples", "Items tested", "annex"),
    ("instruments", "Instruments and their calibration", "annex"),
    ("environment", "Dates, persons and conditions", "annex"),
    ("deviations", "Deviations, exclusions and anomalies", "annex"),
    ("references", "References", "annex"),
    ("metrics", "Records of the response tests", "quality"),
    ("candidates", "Records of the diagnosis", "quality"),
    ("sources", "Inputs and their sources", "quality"),
    ("trials", "Records of the Monte Carlo method", "quality"),
    ("notices", "Notices of the certificate, in full", "quality"),
    ("provenance", "Provenance", "quality"),
    ("checklist", "Checklists of the report", "quality"),
)
"""Template, title and part of every section after the certificate, in order."""


def sections(findings: Findings) -> list[tuple[str, str]]:
    """Template and title of the sections of the parts that the report has; without those that would be empty."""
    full = {
        "tests": findings.tests, "diagnosis": findings.diagnosis, "fits": findings.fits, "budgets": findings.results,
        "correlations": findings.correlations, "conformity": findings.conformity or findings.withheld,
        "comparisons": findings.comparisons or findings.consensus, "audit": findings.audit,
        "opinions": findings.campaign.opinions,
        "samples": findings.samples, "instruments": findings.instruments, "environment": findings.tests,
        "metrics": any(test.by == "response" for test in findings.tests), "candidates": findings.diagnosis,
        "sources": any(result.budget for result in findings.results),
        "trials": any(result.headline for result in findings.results), "notices": attention.attention(findings),
        "checklist": findings.campaign.checklists,
    }  # fmt: skip
    parts = findings.campaign.parts
    return [(name, title) for name, title, part in SECTIONS if part in parts and full.get(name, True)]


def _first_record(findings: Findings) -> str:
    """The section with which the records of quality assurance begin."""
    records = {name for name, _, part in SECTIONS if part == "quality"}
    return next((name for name, _ in sections(findings) if name in records), "")


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


MOVED = 2.0
"""Standard uncertainties from which on an input that a fit changes stands in the annex."""


def moved_inputs(finding: Any) -> list[Any]:
    """Inputs of a response test that the fit changes by more than twice their standard uncertainty."""
    return [row for row in finding.inputs if abs(row.distance) > MOVED]


def audit_verdict(row: AuditRow) -> str:
    """Same digits; or how far the recomputed value differs from the published one."""
    if row.agrees:
        return said("✓ same digits")
    within = re.search(r" ± ([\d.]+)", row.recomputed)
    apart = re.match(r"[-+]?[\d.]+", row.difference)
    if within is None or apart is None:
        return said("✗ differs")
    near = abs(float(apart[0])) <= float(within[1])
    return said("◐ differs, within u") if near else said("✗ differs beyond u")


def procedures(findings: Findings, language: Language = ENGLISH) -> list[tuple[str, str, str, str]]:
    """Tests that share specification, procedure as run and set-up, with these."""
    names = done.called(findings, language)
    grouped: dict[tuple[str, str, str], list[str]] = {}
    for test in findings.tests:
        key = (test.specification, test.as_run, test.setup)
        grouped.setdefault(key, []).append(names[test.id])
    return [(language.word("; ").join(tests), *key) for key, tests in grouped.items()]


def _own_equations(budget: Budget, made: Sequence[Method]) -> list[str]:
    """Equations of a budget's results that the chapter on the methods does not give."""
    given = {text for method in made for text in method.equations}
    found = dict.fromkeys(result.equation for result in budget.results if result.method == "derived")
    return [text for text in found if text and text not in given]


def channel_unit(channel: str, coordinate: Coordinate = "position") -> str:
    """SI unit of a channel of a response test, by what x is."""
    return QUANTITIES[coordinate][channel].unit


def shown_in_figures(note: str) -> bool:
    """Whether a note on a response test gives the noise of a run, which its plot and table show anyway."""
    return ": standard uncertainty of one reading: " in note


def derived(lines: list[Line]) -> list[tuple[str, str]]:
    """Equation of every derived quantity, with the names of those that it gives."""
    grouped: dict[str, list[str]] = {}
    for line in lines:
        if line.result.method == "derived":
            grouped.setdefault(line.result.equation, []).append(line.result.name)
    return [(equation, ", ".join(names)) for equation, names in grouped.items()]


def matrix(findings: Findings, language: Language = ENGLISH) -> list[tuple[str, list[str]]]:
    """Correlation coefficients of the headline results, lower triangle; empty where they are too many for a page."""
    results = _main(findings)
    if len(results) > LARGEST_MATRIX:
        return []
    samples = {sample.id: sample.name for sample in findings.samples}
    known = {frozenset((pair.a, pair.b)): pair.coefficient for pair in findings.correlations}
    rows = []
    for i, result in enumerate(results):
        cells = [known.get(frozenset((result.name, other.name))) for other in results[:i]]
        owner = samples.get(result.sample, result.sample)
        method = language.word(result.method, "method")
        name = ", ".join(filter(None, (symbol(result.quantity).replace("_n", "ₙ"), owner, method)))
        rows.append((name, ["" if r is None else f"{r:+.2f}".replace("-", "−") for r in cells] + ["1"]))
    return rows


def pairs(findings: Findings, language: Language = ENGLISH) -> tuple[list[Correlation], str]:
    """Pairs of the main results with the strongest correlation, and what is said of those that are not listed."""
    names = {result.name for result in _main(findings)}
    own = [pair for pair in findings.correlations if {pair.a, pair.b} <= names and abs(pair.coefficient) >= 0.005]
    ranked = sorted(own, key=lambda pair: -abs(pair.coefficient))
    most = LARGEST_MATRIX * (LARGEST_MATRIX - 1) // 2
    if len(ranked) <= most:
        return ranked, ""
    further = language.count(
        "{count} further pair, |r| at most {most:.2f}", "{count} further pairs, |r| at most {most:.2f}",
        len(ranked) - most, most=abs(ranked[most].coefficient),
    )  # fmt: skip
    return ranked[:most], language.say("{pairs}: see results.json.", pairs=further)


def _main(findings: Findings) -> Sequence[Result]:
    """Results that page 1 shows; all where it shows none."""
    return [result for result in findings.results if result.headline] or findings.results


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


def main_results(findings: Findings) -> list[Line]:
    """The results that page 1 shows, each by itself: value, u and U in its display unit."""
    return [replace(line, expanded=_expanded(line.result)) for line in _lines(findings) if line.result.headline]


def _line(result: Result, anchor: str, samples: Mapping[str, str]) -> Line:
    law, trials, unit = result.coverage, result.monte_carlo, result.display_unit
    shown = estimate(result.framework.value, result.framework.u, unit, (law.low, law.high))
    drawn = estimate(result.value, result.u, unit, (trials.shortest_low, trials.shortest_high))
    symmetric = _symmetric(result)
    if not (isfinite(result.value) and isfinite(result.u)):
        shown, drawn, symmetric = (replace(one, low="–", high="–") for one in (shown, drawn, symmetric))
    reported = shown if trials.law_valid else drawn
    return Line(
        result=result,
        anchor=anchor,
        sample=samples.get(result.sample, result.sample),
        name=_word(result),
        shown=shown,
        trials=drawn,
        symmetric=symmetric,
        value=reported.value,
        u=reported.u,
        before=None if result.stated is None else estimate(result.stated.value, result.stated.u, unit),
    )


def _word(result: Result) -> str:
    """What a method's own result is called; a derived quantity is the campaign's, whatever its letter."""
    if result.method == "derived":
        return ""
    method = METHODS.get(result.method)
    if method is None:
        return NAMES.get(result.quantity, "")
    return method.outputs[result.quantity].word if result.quantity in method.outputs else ""


def _symmetric(result: Result) -> Shown:
    """Mean, u and symmetric interval by Monte Carlo: where the draws have no u, rounded by that of the law."""
    trials, unit = result.monte_carlo, result.display_unit
    ends = (trials.low, trials.high)
    if isfinite(trials.u):
        return estimate(trials.mean, trials.u, unit, ends)
    return replace(estimate(trials.mean, result.u, unit, ends), u="–")


def _aligned(lines: list[Line], agreed: Sequence[consensus.Group]) -> tuple[list[Line], list[consensus.Group]]:
    """Rows of page 1 whose values, u, U and ends of the leading interval stand with their decimals below each other."""
    rows = [(line.value, line.u, _expanded(line.result), line.leads.low, line.leads.high) for line in lines]
    units = [line.shown.unit for line in lines]
    for group in agreed:
        if (shown := group.shown) is not None:
            rows.append((shown.value, shown.u, group.expanded, shown.low, shown.high))
            units.append(shown.unit)
    columns = [_column(list(column), units) for column in zip(*rows, strict=True)]
    cells = list(zip(*columns, strict=True))
    return [
        replace(line, value=value, u=u, expanded=expanded, low=low, high=high)
        for line, (value, u, expanded, low, high) in zip(lines, cells, strict=False)
    ], [replace(group, cells=own) for group, own in zip(agreed, cells[len(lines) :], strict=True)]


def _expanded(result: Result) -> str:
    """Expanded uncertainty to the place of u: half of the reported interval; a dash where that is not symmetric."""
    from metrology.gum.output import is_centred
    from metrology.units import factor

    low, high = result.interval
    if low is None or high is None or not high > low or not (isfinite(result.value) and isfinite(result.u)):
        return "–"
    if not is_centred(result.value, low, high):
        return "–"
    size = factor(result.display_unit)
    return like(0.5 * (high - low) / size, rounded(result.value / size, result.u / size)[1])


def _column(texts: list[str], units: list[str]) -> list[str]:
    """Numbers with their decimals below each other; where that is too wide for the page, those of one unit only."""
    together = aligned(texts)
    if max(map(len, together), default=0) <= WIDEST:
        return together
    found = list(texts)
    for unit in set(units):
        places = [i for i, other in enumerate(units) if other == unit]
        own = aligned([texts[i] for i in places])
        if max(map(len, own)) <= WIDEST:
            for place, text in zip(places, own, strict=True):
                found[place] = text
    return found


ROOM = (5.5, 4.8, 5.5, 12.0)
"""Width in em that the columns of page 1 have for value, u, U and the interval."""
ROOM_LIMIT, ROOM_BAND = 8.0, 5.4
"""Likewise for a limit and for the guard band of a requirement."""


WIDER = 14.0
"""Width in em of an interval for which the description of the result makes room."""


def crowded(rows: Sequence[tuple[str, ...]]) -> str:
    """What on page 1 is wider than its column, of value, u, U and the interval: `numbers`, the `interval` alone."""
    beyond = [
        max((width(text) - room for text in texts), default=0.0)
        for texts, room in zip(zip(*(_cells(*row) for row in rows), strict=True), ROOM, strict=False)
    ]
    if not beyond or max(beyond) <= 0:
        return ""
    return "numbers" if max(beyond[:3]) > 0 or beyond[3] > WIDER - ROOM[3] else "interval"


def _cells(value: str, u: str, expanded: str, low: str, high: str) -> tuple[str, str, str, str]:
    return value, u, expanded, f"{low.rstrip()} … {high}"


def crowded_limits(judged: Sequence[Conformity | Withheld]) -> bool:
    """Whether a limit or a guard band on page 1 is wider than its column."""
    return any(
        max(width(text.partition(" ")[0]) for text in stated_limits(entry)) > ROOM_LIMIT
        or (isinstance(entry, Conformity) and width(quality.band(entry)) > ROOM_BAND)
        for entry in judged
    )


def limits(entry: Conformity | Withheld, language: Language = ENGLISH) -> str:
    """Limits of a requirement."""
    low, high = (language.figures(text) for text in stated_limits(entry))
    if entry.lower is not None and entry.upper is not None:
        return language.say("{low} to {high}", low=low, high=high)
    return f"≥ {low}" if entry.upper is None else f"≤ {high}"


def stated_limits(entry: Conformity | Withheld) -> tuple[str, str]:
    """Tolerance limits as they are stated, in their units; a dash for one that is not there."""
    unit, given = entry.display_unit, ((entry.lower, entry.lower_stated), (entry.upper, entry.upper_stated))
    low, high = ("–" if limit is None else as_stated(limit, text, unit) for limit, text in given)
    return low, high


def _accepted(entry: Conformity, limit: float | None, stated: str) -> str:
    from metrology.units import convert, factor

    if limit is None or not entry.guard_band:
        return "–" if limit is None else stated
    unit = entry.display_unit
    text = rounded(convert(limit, unit), abs(entry.guard_band) / factor(unit))[0]
    return f"{text} {unit_text(unit)}".rstrip()


def acceptance(entry: Conformity, language: Language = ENGLISH) -> str:
    """Acceptance limits of a requirement, to the digits of their guard band; a dash where there are none."""
    ends = [
        _accepted(entry, limit, text)
        for limit, text in zip((entry.acceptance_lower, entry.acceptance_upper), stated_limits(entry), strict=True)
    ]
    low, high = map(language.figures, ends)
    if "–" in ends:
        return high if low == "–" else low
    return language.say("{low} to {high}", low=low, high=high)


def _sides(entry: Comparison) -> tuple[Shown, Shown, Shown]:
    unit = entry.display_unit
    return (
        estimate(entry.value_a, entry.u_a, unit),
        estimate(entry.value_b, entry.u_b, unit),
        estimate(entry.difference, entry.u_difference, unit),
    )
