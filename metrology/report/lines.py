"""Results as lines of a table: value, u, U and interval as texts, aligned, and whether they fit their columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite

from metrology.findings import Conformity, Findings, Result, Withheld
from metrology.judged import is_on
from metrology.language import done
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.columns import aligned, width
from metrology.language.display import Shown, estimate, like, rounded
from metrology.methods import METHODS
from metrology.report import consensus

NAMES = {name: output.word for method in METHODS.values() for name, output in method.outputs.items()}
"""Quantities → what they are called."""
WIDEST = 9
"""Characters that a number of the table on page 1 has room for."""


@dataclass(frozen=True)
class Line:
    """One result as a line of a table: texts of the framework (`shown`) and of Monte Carlo, shortest and symmetric.

    `value`, `u`, `low` and `high` are those that are reported, aligned with other lines. `own`: its name in the
    campaign, where another line reads as it does.
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
    own: str = ""

    @property
    def leads(self) -> Shown:
        """By the framework where Monte Carlo confirms it, else by Monte Carlo with the interval that it reports."""
        if self.result.monte_carlo.law_valid:
            return self.shown
        if self.result.monte_carlo.reported == "shortest":
            return self.trials
        return replace(self.trials, low=self.symmetric.low, high=self.symmetric.high)


def all_lines(findings: Findings) -> list[Line]:
    """Every result as a line, in the order of the findings."""
    twice = Counter(sample.name for sample in findings.samples)
    samples = {sample.id: sample.name if twice[sample.name] == 1 else f"{sample.name} ({sample.id})"
               for sample in findings.samples}  # fmt: skip
    lines = [_line(result, f"result-{i}", samples) for i, result in enumerate(findings.results, 1)]
    read = [(line.sample, line.result.quantity, line.name, line.result.method) for line in lines]
    alike = Counter(words for line, words in zip(lines, read, strict=True) if line.result.headline)
    return [replace(line, own=line.result.name) if alike[words] > 1 else line
            for line, words in zip(lines, read, strict=True)]  # fmt: skip


def main_results(findings: Findings) -> list[Line]:
    """The results that page 1 shows, each by itself: value, u and U in its display unit."""
    return [replace(line, expanded=_expanded(line.result)) for line in all_lines(findings) if line.result.headline]


def whose(entry: Conformity | Withheld, lines: Sequence[Line], language: Language = ENGLISH) -> str:
    """Item and method of the result that a requirement is on, where page 1 has others of its symbol.

    Source: ISO/IEC 17025:2017, 7.8.6.2 a.
    """
    alike = [line for line in lines if line.result.quantity.rpartition(".")[2] == entry.quantity]
    found = next((line for line in alike if is_on(entry.result, line.result.name)), None)
    if found is None or len(alike) == 1:
        return ""
    name = found.own or (found.result.quantity if "." in found.result.quantity else "")
    return ", ".join(word for word in (found.sample, name or done.by_method(found.result, language)) if word)


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


def aligned_lines(lines: list[Line], agreed: Sequence[consensus.Group]) -> tuple[list[Line], list[consensus.Group]]:
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
