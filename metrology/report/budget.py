"""The budget of a result as a table: one line a component, names short within their section, bars for the shares."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from metrology.report.display import aligned, number, percent, prefixed, symbol

if TYPE_CHECKING:
    from metrology.findings import Findings, Result
    from metrology.gum.evaluation import BudgetRow

LEAST = 0.0005
"""Share of u² from which a component has a line of its own; the rest is one line, and whole in results.json."""


@dataclass(frozen=True)
class Share:
    """One component as texts; `bar` is the length of its bar in steps of 2 % of u²."""

    name: str
    component: str
    value: str
    u: str
    unit: str
    distribution: str
    sensitivity: str
    contribution: str
    share: str
    bar: int
    negative: bool


@dataclass(frozen=True)
class Budget:
    """The rows that matter, largest first, and one sentence on the others."""

    rows: tuple[Share, ...]
    rest: str


@dataclass(frozen=True)
class Source:
    """One component of uncertainty with its origin and the inputs that carry it: told once for all results."""

    inputs: str
    component: str
    u: str
    unit: str
    distribution: str
    source: str


def budget(result: Result) -> Budget:
    """Rows of a result's budget: inputs on their own scale, contributions in the result's display unit."""
    from metrology.units import factor

    size = factor(result.display_unit)
    ranked = sorted(result.budget, key=lambda row: -abs(row.share))
    kept = [row for row in ranked if abs(row.share) >= LEAST] or ranked[:1]
    contributions = aligned([number(row.contribution / size, 2) for row in kept])
    shares = _padded(aligned([percent(row.share).removesuffix(" %") for row in kept]))
    rows = [_share(result, row, *texts) for row, *texts in zip(kept, contributions, shares, strict=True)]
    return Budget(tuple(rows), _rest(ranked[len(kept) :]))


def sources(findings: Findings) -> list[Source]:
    """Every component of every input once; inputs whose components are alike in all but the value share a line."""
    rows = {(row.input, row.component): row for result in findings.results for row in result.budget}
    grouped: dict[Source, list[str]] = {}
    for row in sorted(rows.values(), key=lambda row: row.input):
        owner = row.input.rpartition(".")[0]
        component = row.component.removesuffix(f" of {owner}")
        shown = prefixed(0.0 if row.u else row.value, row.u, row.unit)
        source = "" if row.source == row.component else row.source
        if row.cause:
            source = f"{source or row.cause}; one unknown value for all inputs with this cause"
        grouped.setdefault(Source("", component, shown.u, shown.unit, _distribution(row), source), []).append(row.input)
    return [replace(source, inputs=_joined(names)) for source, names in grouped.items()]


def _joined(names: list[str]) -> str:
    """Names of one owner in one go: ``a.load A, a.load B`` → ``a.load A, load B``."""
    owner = names[0].rpartition(".")[0]
    return ", ".join([names[0], *(name.removeprefix(f"{owner}.") for name in names[1:])])


def shortened(text: str, result: Result, *owners: str) -> str:
    """A text of the evaluation for the section of one result: without the names of its test and its sample."""
    for owner in filter(None, (result.test, result.sample, *owners)):
        text = re.sub(rf"(?<![\w-]){re.escape(owner)}\.", "", text)
        text = re.sub(rf" of {re.escape(owner)}(?![\w-])|(?<![\w-]){re.escape(owner)} (?=releases)", "", text)
    return re.sub(r"\bu\((\w+)\)", lambda match: f"u({symbol(match[1]).replace('_n', 'ₙ')})", text)


def _share(result: Result, row: BudgetRow, contribution: str, share: str) -> Share:
    shown = prefixed(row.value, row.u, row.unit)
    return Share(
        name=" ".join(symbol(part) for part in shortened(row.input, result).split(".")),
        component=shortened(row.component, result, row.input.rpartition(".")[0]),
        value=shown.value,
        u=shown.u,
        unit=shown.unit,
        distribution=_distribution(row),
        sensitivity=number(row.sensitivity, 3),
        contribution=contribution,
        share=share,
        bar=min(round(50 * abs(row.share)), 50),
        negative=row.share < 0,
    )


def _distribution(row: BudgetRow) -> str:
    return f"{row.distribution}, {row.kind}" + ("" if row.dof is None else f", ν = {number(row.dof)}")


def _padded(texts: list[str]) -> list[str]:
    """Texts as wide as the widest, so that what follows them begins at one place."""
    widest = max(map(len, texts), default=0)
    return [text.rjust(widest, "\N{FIGURE SPACE}") for text in texts]


def _rest(rows: list[BudgetRow]) -> str:
    if not rows:
        return ""
    together = sum(row.share for row in rows)
    share = "less than 0.1 %" if abs(together) < LEAST else percent(together)
    return f"{len(rows)} further component{'s' if len(rows) > 1 else ''}, together {share}"
