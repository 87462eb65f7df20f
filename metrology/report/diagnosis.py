"""The chapter on what the model lacks: one page in plain sentences for each diagnosed test, then its tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import TYPE_CHECKING

from metrology.diagnosis import Cause, Detectable, Diagnosis, Explanation, Gain, Part, Shift
from metrology.effects import shown
from metrology.language import answers, diagnosis_figures
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import chance, number, rounded
from metrology.report.figures.diagnosis import rows as pictures_of
from metrology.units import unit_text

if TYPE_CHECKING:
    from metrology.findings import Findings

MARKS = {
    "nothing missing": "✓", "explained": "●", "explained in the main": "◕", "ambiguous": "◐", "unexplained": "✗",
    "not testable": "○", "not finished": "…",
}  # fmt: skip
"""Verdict → a mark that differs in shape, so that it survives grey print."""
SHOWING = shown()
"""Picture → the effects that it shows best."""
SHOWN = {"1": (0.01, "%"), "m": (1e-3, "mm"), "m/N": (1e-9, "nm/N"), "Pa": (1e9, "GPa"), "m²": (1e-6, "mm²")}
"""SI unit of what a cause would need → its size in SI, and the unit in which it is shown."""
PICTURES, NEXT = 2, 3
"""Pictures in the annex for a test; effects that are not supported in the table of the annex. The records have all."""
PLAIN = ("force-velocity", "rate", "load", "spectrum", "history", "order")
"""Pictures to show where no effect is named, the first that there is."""


@dataclass(frozen=True)
class Row:
    """One cause as a line of the table."""

    cause: Cause
    probability: str
    evidence: str
    score: str
    parameters: tuple[str, ...]
    smallest: str


@dataclass(frozen=True)
class Worth:
    """Held-out residuals over noise of one channel, before and after; `ratio` with its interval."""

    channel: str
    before: str
    after: str
    ratio: str


@dataclass(frozen=True)
class Apart:
    """One cause that could part a result from its reference, as a line of the table; `tension` in σ."""

    title: str
    needed: str
    tension: str
    judgement: str
    why: str
    decides: str


@dataclass(frozen=True)
class Chapter:
    """One diagnosed test.

    `answers`: question and answer, in short. `shown`: the pictures that go with them, two at most; `wide` and `narrow`:
    the others, across the page and two side by side. `likely`: the supported effects and the next ones.
    """

    finding: Diagnosis
    anchor: str
    title: str
    mark: str
    answers: tuple[tuple[str, str], ...]
    shown: tuple[str, ...]
    wide: tuple[str, ...]
    narrow: tuple[str, ...]
    likely: tuple[Row, ...]
    fitted: tuple[Row, ...]
    looked: tuple[Row, ...]
    untested: tuple[Cause, ...]
    worth: tuple[Worth, ...]
    channels: tuple[str, ...]
    phases: tuple[tuple[str, tuple[str, ...]], ...]
    shifts: tuple[tuple[str, ...], ...]
    extended: tuple[tuple[str, str], ...]
    apart: tuple[Apart, ...]
    titles: Mapping[str, str]


def chapters(findings: Findings, language: Language = ENGLISH) -> list[Chapter]:
    """Every diagnosed test in the order of the results."""
    titles = {test.id: test.title for test in findings.tests}
    samples = {sample.id: sample.name for sample in findings.samples}
    return [
        _chapter(finding, f"diagnosis-{at}", _title(finding, titles, samples, language), language)
        for at, finding in enumerate(findings.diagnosis, 1)
    ]


def _title(finding: Diagnosis, titles: Mapping[str, str], samples: Mapping[str, str], language: Language) -> str:
    sample = samples.get(finding.sample, finding.sample)
    method = titles.get(finding.test, finding.method.capitalize()).removesuffix(f": {sample}")
    return f"{language.word(method)}{language.word(': ')}{sample}"


def _chapter(finding: Diagnosis, anchor: str, title: str, language: Language) -> Chapter:
    pictures = pictures_of(finding)
    names = list(pictures) + (["missing"] if finding.missing is not None else [])
    shown = _shown(finding, names, {name for name in names if len(pictures.get(name, ())) < 2})
    others = [name for name in names if name not in shown]
    wide = tuple(name for name in others if len(pictures.get(name, ())) > 1)
    sizes = {one.effect: one for one in finding.detectable}
    causes = [_row(one, sizes.get(one.effect), language) for one in _ranked(finding.causes)]
    channels = tuple(dict.fromkeys(part.channel for part in finding.residuals))
    fitted = tuple(row for row in causes if row.probability != "–")
    supported = sum(row.cause.verdict != "not supported" for row in fitted)
    return Chapter(
        finding, anchor, title, MARKS[finding.verdict], answers.answers(finding, language), shown,
        wide, tuple(name for name in others if name not in wide),
        fitted[: supported + NEXT] if finding.verdict != "nothing missing" else (), fitted,
        tuple(row for row in causes if row.probability == "–"),
        tuple(one for one in finding.causes if one.verdict == "not testable"),
        tuple(_gain(answers.channel(finding, name, language), one, language) for name, one in finding.gain.items()),
        tuple(answers.channel(finding, name, language) for name in channels), _phases(finding, channels),
        tuple(_shift(one) for one in finding.shifts),
        tuple((name, language.figures(number(value, 6))) for name, value in finding.extended_model.items()),
        tuple(_apart(one, language) for one in finding.discrepancy.explanations) if finding.discrepancy else (),
        {one.effect: language.word(one.title) for one in finding.causes},
    )  # fmt: skip


def _ranked(causes: Sequence[Cause]) -> list[Cause]:
    """Those that could be tested: named ones first, then by evidence and score."""
    order = ("supported", "indistinguishable", "not supported")
    return sorted(
        (one for one in causes if one.verdict in order),
        key=lambda one: (order.index(one.verdict), -(one.log_bayes or 0.0), -(one.score or 0.0)),
    )


def _shown(finding: Diagnosis, names: Sequence[str], narrow: set[str]) -> tuple[str, ...]:
    """Two pictures that stand side by side: what is missing or shows the named effects, then the plain ones.

    None where nothing is missing, or it is not decided whether anything is but what was taken out of the records, which
    show it: what the fit finds has evidence there.
    """
    # What was taken out of the records, and not fitted, has sizes without u.
    fitted = {
        one.effect for one in finding.causes
        if (one.log_bayes or 0.0) > 0 and any(isfinite(size.u) for size in one.parameters)
    } & set(finding.possible)  # fmt: skip
    if finding.verdict == "nothing missing" or (finding.undecided and fitted <= set(finding.undecided)):
        return ()
    wanted = [key for effect in finding.possible for key, effects in SHOWING.items() if effect in effects]
    missing = ["missing"] if finding.verdict == "unexplained" else []
    found = dict.fromkeys(name for name in (*missing, *wanted, *PLAIN, *names) if name in narrow)
    return tuple(found)[:PICTURES]


# ---- tables -------------------------------------------------------------------------------------------------------
def _row(cause: Cause, size: Detectable | None, language: Language) -> Row:
    tried = cause.log_bayes is not None or cause.verdict in ("supported", "indistinguishable")
    smallest = "–" if size is None else diagnosis_figures.smallest(size, language)
    return Row(
        cause, chance(cause.probability) if tried else "–", diagnosis_figures.evidence(cause, language),
        "–" if cause.score is None else number(cause.score, 2),
        tuple(diagnosis_figures.parameter(one, language) for one in cause.parameters), smallest,
    )  # fmt: skip


def _apart(one: Explanation, language: Language) -> Apart:
    size, unit = SHOWN.get(one.unit, (1.0, unit_text(one.unit)))
    value, u = rounded(one.needed / size, one.needed_u / size)
    needed = f"{value} ± {u} {unit}"
    tension = "–" if one.tension is None else number(one.tension, 2)
    why = language.say("{reasons}.", reasons=one.evidence)
    decides = language.say("{measurement}: {power}.", measurement=one.measurement, power=one.power)
    return Apart(one.title, needed, tension, one.judgement, why, decides)


def _gain(channel: str, one: Gain, language: Language) -> Worth:
    return Worth(channel, number(one.before), number(one.after), diagnosis_figures.ratio(one, language))


def _phases(finding: Diagnosis, channels: Sequence[str]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Root mean squares over all runs: a row a phase, a cell a channel."""
    grouped: dict[str, dict[str, list[Part]]] = {}
    for part in finding.residuals:
        grouped.setdefault(part.phase, {}).setdefault(part.channel, []).append(part)
    extended = bool(finding.gain)
    return tuple(
        (phase, tuple(_cell(own.get(name, ()), extended=extended) for name in channels))
        for phase, own in grouped.items()
    )


def _cell(parts: Sequence[Part], *, extended: bool) -> str:
    count = sum(part.count for part in parts)
    if not count:
        return "–"
    before, after = (
        number(sqrt(sum(part.count * getattr(part, name) ** 2 for part in parts) / count))
        for name in ("before", "after")
    )
    return f"{before} → {after}" if extended else before


def _shift(one: Shift) -> tuple[str, ...]:
    return (
        one.name, *rounded(one.before, one.u_before), *rounded(one.after, one.u_after), unit_text(one.unit),
        number(one.shift, 2),
    )  # fmt: skip
