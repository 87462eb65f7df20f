"""The budgets of the results of a test as one table: a line a component, a pair of columns a result."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import TYPE_CHECKING

from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import number, percent, prefixed, rounded, signed, symbol
from metrology.language.wording import plain_name

if TYPE_CHECKING:
    from metrology.findings import Correlation, Findings, Result
    from metrology.gum.evaluation import BudgetRow

LEAST = 0.01
"""Share of u² from which a component has a line of its own; the rest is one line, and whole in results.json."""
ACROSS = 4
"""Results that one table holds."""
PAIRS = 6
"""Correlated pairs that a budget names; all of them are in results.json."""


@dataclass(frozen=True)
class Share:
    """One component as texts; `cells`: its contribution to each result, and its share of u² in per cent.

    `owner`: the test or sample whose input it is, where that is not the own one.
    """

    name: str
    owner: str
    component: str
    value: str
    u: str
    unit: str
    distribution: str
    cells: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Budget:
    """Results of one test, the components that matter to any of them, largest first, and a sentence on the others.

    `combined`: u of each result by the GUM uncertainty framework, in its display unit; `reported`: u as it is reported
    where that is another one, by the Monte Carlo method, and nothing where no result has another one; `correlated`:
    correlated pairs among the inputs that are listed; `owners`: other tests and samples whose inputs are listed, which
    the table marks by letters in this order.
    """

    key: str
    test: str
    results: tuple[Result, ...]
    rows: tuple[Share, ...]
    rest: str
    combined: tuple[str, ...]
    reported: tuple[str, ...]
    correlated: str
    owners: tuple[str, ...]


@dataclass(frozen=True)
class Source:
    """One component of uncertainty with its origin and the inputs that carry it, once for all results."""

    inputs: str
    component: str
    u: str
    unit: str
    distribution: str
    source: str


def budgets(results: Sequence[Result], pairs: Sequence[Correlation] = (), language: Language = ENGLISH) -> list[Budget]:
    """The budgets of main results, those of one test in one table, with the correlated `pairs` of their inputs."""
    grouped: dict[str, list[Result]] = {}
    for result in results:
        if result.budget:
            grouped.setdefault(result.test or result.name, []).append(result)
    return [
        _budget(key if at == 0 else f"{key}, {own[at].quantity}", own[at : at + ACROSS], pairs, language)
        for key, own in grouped.items()
        for at in range(0, len(own), ACROSS)
    ]


def _budget(key: str, results: Sequence[Result], pairs: Sequence[Correlation], language: Language) -> Budget:
    """Inputs on their own scale, contributions in the display unit of their result."""
    rows: dict[tuple[str, str], list[BudgetRow | None]] = {}
    for place, result in enumerate(results):
        for row in result.budget:
            rows.setdefault((row.input, row.component), [None] * len(results))[place] = row
    ranked = sorted(rows.values(), key=_most, reverse=True)
    kept = [row for row in ranked if _most(row) >= LEAST] or ranked[:1]
    combined = _printed(results, [one.framework.u for one in results])
    reported = _printed(results, [one.u for one in results])
    shares = tuple(_share(results, row, language) for row in kept)
    return Budget(
        key,
        results[0].test,
        tuple(results),
        shares,
        _rest(results, ranked[len(kept) :], language),
        combined,
        tuple("–" if new == old else new for old, new in zip(combined, reported, strict=True))
        if reported != combined
        else (),
        _correlated({one.input for row in kept for one in row if one is not None}, results[0], pairs, language),
        tuple(dict.fromkeys(one.owner for one in shares if one.owner)),
    )


def _printed(results: Sequence[Result], uncertainties: Sequence[float]) -> tuple[str, ...]:
    """A standard uncertainty of each result as text, in its display unit."""
    from metrology.units import factor

    return tuple(rounded(0.0, u / factor(one.display_unit))[1] for one, u in zip(results, uncertainties, strict=True))


def _correlated(inputs: set[str], result: Result, pairs: Sequence[Correlation], language: Language) -> str:
    """Pairs of listed inputs that are correlated, the strongest first (JCGM 100, 7.2.7)."""
    own = [pair for pair in pairs if {pair.a, pair.b} <= inputs and round(abs(pair.coefficient), 2) > 0]
    together = _alike(own)
    every = "{names:comma}, r = {r:figures} between every two"
    said = [
        language.say(every, names=tuple(_named(name, result, language) for name in sorted(group)), r=signed(1.0, 2))
        for group in together
    ]
    own = [pair for pair in own if not any({pair.a, pair.b} <= group for group in together)]
    ranked = sorted(own, key=lambda pair: -abs(pair.coefficient))
    said += [
        language.say(
            "{a} and {b}, r = {r:figures}",
            a=_named(pair.a, result, language),
            b=_named(pair.b, result, language),
            r=signed(pair.coefficient, 2),
        )
        for pair in ranked[:PAIRS]
    ]
    if len(ranked) > PAIRS:
        further, most = len(ranked) - PAIRS, abs(ranked[PAIRS].coefficient)
        said.append(
            language.count(
                "{count} further pair, |r| at most {most:.2f}",
                "{count} further pairs, |r| at most {most:.2f}",
                further,
                most=most,
            )
        )
    return language.word("; ").join(said)


def _alike(pairs: Sequence[Correlation]) -> list[set[str]]:
    """Three inputs and more of which every two are correlated with r = +1.00."""
    whole = [{pair.a, pair.b} for pair in pairs if round(pair.coefficient, 2) == 1.0]
    groups: list[set[str]] = []
    for pair in whole:
        touched = [group for group in groups if group & pair]
        groups = [group for group in groups if group not in touched] + [pair.union(*touched)]
    size = {id(group): sum(pair <= group for pair in whole) for group in groups}
    return [group for group in groups if len(group) > 2 and 2 * size[id(group)] == len(group) * (len(group) - 1)]


def _named(name: str, result: Result, language: Language) -> str:
    return " ".join(_part(symbol(one), language) for one in plain_name(shortened(name, result)).split("."))


def _part(name: str, language: Language) -> str:
    """A part of the name of an input: a known one, or a known word before a name of the campaign, as ``load A``."""
    if (known := language.word(name)) != name:
        return known
    word, space, own = name.rpartition(" ")
    return f"{language.word(word)}{space}{own}"


def _most(row: Sequence[BudgetRow | None]) -> float:
    return max(abs(one.share) for one in row if one is not None)


def sources(findings: Findings, language: Language = ENGLISH) -> list[Source]:
    """Every component of every input once; inputs whose components are alike in all but the value share a line."""
    rows = {(row.input, row.component): row for result in findings.results for row in result.budget}
    shared = Counter(row.cause for row in rows.values())
    grouped: dict[Source, list[str]] = {}
    for row in sorted(rows.values(), key=lambda row: row.input):
        owner = row.input.rpartition(".")[0]
        component = language.spoken(row.component.removesuffix(f" of {owner}"))
        shown = prefixed(0.0 if row.u else row.value, row.u, row.unit)
        source = "" if row.source == row.component else language.spoken(row.source)
        if row.cause and shared[row.cause] > 1:
            shares = "{source}; one unknown value for all inputs with this cause"
            if row.opposite:
                shares = "{source}; one unknown value for all inputs with this cause, of opposite sign here"
            source = language.say(shares, source=source or row.cause)
        made = Source("", component, shown.u, shown.unit, _distribution(row, language), source)
        grouped.setdefault(made, []).append(row.input)
    return [replace(source, inputs=_joined(names)) for source, names in grouped.items()]


def _joined(names: list[str]) -> str:
    """Names of each owner in one go: ``a.load A, a.load B, b.load A`` → ``a.load A, B; b.load A``."""
    owners: dict[str, list[str]] = {}
    for name in names:
        owner, dot, own = name.rpartition(".")
        what, space, which = own.rpartition(" ")
        owners.setdefault(f"{owner}{dot}{what}{space}", []).append(which)
    return "; ".join(f"{owner}{', '.join(own)}" for owner, own in owners.items())


def shortened(text: str, result: Result, *owners: str) -> str:
    """A text of the evaluation for the section of one result: without the names of its test and its sample."""
    for owner in filter(None, (result.test, result.sample, *owners)):
        text = re.sub(rf"(?<![\w-]){re.escape(owner)}\.", "", text)
        text = re.sub(rf"(?: of|,) {re.escape(owner)}(?![\w-])|(?<![\w-]){re.escape(owner)} (?=releases)", "", text)
    return re.sub(r"\bu\((\w+)\)", lambda match: f"u({symbol(match[1]).replace('_n', 'ₙ')})", text)


def _share(results: Sequence[Result], cells: Sequence[BudgetRow | None], language: Language) -> Share:
    place, row = next((place, one) for place, one in enumerate(cells) if one is not None)
    result = results[place]
    shown = prefixed(row.value, row.u, row.unit)
    owners = (row.input.partition(".")[0], row.input.rpartition(".")[0])
    own, component = shortened(row.input, result), shortened(row.component, result, *owners)
    if (spoken := language.spoken(component)) == component:
        # Known with the name of its test alone.
        spoken = shortened(language.spoken(row.component), result, *owners)
    input_name = row.input.removeprefix(f"{owners[0]}.")
    return Share(
        name=_named(input_name, result, language),
        owner=owners[0] if own.startswith(f"{owners[0]}.") else "",
        # An input of a joint fit is called by its component.
        component="" if _named(input_name, result, ENGLISH).endswith(component) else spoken,
        value=shown.value,
        u=shown.u,
        unit=shown.unit,
        distribution=_distribution(row, language),
        cells=tuple(_cell(result, one) for result, one in zip(results, cells, strict=True)),
    )


def _cell(result: Result, row: BudgetRow | None) -> tuple[str, str]:
    from metrology.units import factor

    if row is None:
        return "–", "–"
    # Where inputs are correlated a share can be more than all, or less than nothing.
    wide = row.share >= 0.9995 or row.share <= -0.9995
    share = f"{100 * row.share:.0f}".replace("-", "−") if wide else percent(row.share).removesuffix(" %")
    return number(row.contribution / factor(result.display_unit), 2), share


def _distribution(row: BudgetRow, language: Language) -> str:
    return f"{language.word(row.distribution)}, {row.kind}" + language.figures(freedom(row.dof, ", ν = "))


MANY = 1000.0
"""Degrees of freedom beyond which Student's t is the normal distribution to every digit that is printed."""


def freedom(dof: float | None, head: str = "") -> str:
    """Degrees of freedom in words; beyond `MANY` no more than that; nothing for infinitely many.

    Examples
    --------
    >>> freedom(8.02, "ν = "), freedom(75300.0, "ν = "), freedom(None)
    ('ν = 8.02', 'ν > 1000', '')
    """
    if dof is None:
        return ""
    return head.replace("=", ">") + f"{MANY:.0f}" if dof > MANY else head + number(dof)


def _rest(results: Sequence[Result], rows: Sequence[Sequence[BudgetRow | None]], language: Language) -> str:
    """How many components have no line, and the most that they are of any result."""
    if not rows:
        return ""
    cells = ([row[place] for row in rows] for place in range(len(results)))
    together = [abs(sum(one.share for one in column if one is not None)) for column in cells]
    return language.count(
        "{count} further component, together at most {part:figures} of u²",
        "{count} further components, together at most {part:figures} of u²",
        len(rows),
        part=_small(max(together)),
    )


def _small(share: float) -> str:
    """Share rounded up to a tenth of a per cent."""
    return percent(max(ceil(1e3 * share - 1e-9), 1) / 1e3)
