"""What the templates print, arranged: each value as text in its display unit, each thing with a place to link to."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from metrology.coordinate import QUANTITIES, Coordinate
from metrology.findings import AuditRow, Comparison, Correlation, Findings, Result, TestItem
from metrology.language import answers, attention, done, notices, wording
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import Shown, concise, estimate, number, prefixed, rounded, scale, symbol
from metrology.message import said
from metrology.report import consensus, decimals, diagnosis, quality
from metrology.report.budget import Budget, budgets, freedom, shortened, sources
from metrology.report.limits import acceptance, crowded_limits, limits
from metrology.report.lines import Line, aligned_lines, all_lines, crowded
from metrology.report.sections import first_record, sections
from metrology.report.ways import ways
from metrology.units import unit_text

if TYPE_CHECKING:
    from metrology.report.attachments import Attachment
    from metrology.report.figures.style import Plot
    from metrology.response import PaperResult

MARKS = {"pass": "✓", "conditional pass": "◐", "conditional fail": "✗", "fail": "✗"}
LARGEST_MATRIX = 12
"""Results up to which their correlation coefficients are a matrix; of more, as many pairs as it has are listed."""


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
    lines = all_lines(findings)
    made = methods(findings)
    found = consensus.names(findings, language)
    shown = {
        name: decimals.localised(function, language)
        for name, function in (
            ("prefixed", prefixed), ("estimate", estimate), ("rounded", rounded), ("concise", concise),
            ("scaled", scaled), ("sized", sized),
        )
    }  # fmt: skip
    headlines, common = aligned_lines([line for line in lines if line.result.headline], found["common"])
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
        "first_record": first_record(findings),
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


def _sides(entry: Comparison) -> tuple[Shown, Shown, Shown]:
    unit = entry.display_unit
    return (
        estimate(entry.value_a, entry.u_a, unit),
        estimate(entry.value_b, entry.u_b, unit),
        estimate(entry.difference, entry.u_difference, unit),
    )
