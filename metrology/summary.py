"""The summary that ends a run on a terminal: results, verdicts, what needs attention, where the report lies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from metrology.errors import printable
from metrology.units import unit_text

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from metrology.consensus import Consensus
    from metrology.findings import AsStated, Findings, Result

MARKS = {"pass": "green", "conditional pass": "yellow", "conditional fail": "yellow", "fail": "red"}

_UNBOUNDED = 10_000
"""Columns of a terminal in which every table finds room."""

_NAMES = ("sample", "test", "method", "quantity")
"""Headings of what a result is known by."""


def print_summary(findings: Findings, folder: Path, notices: Iterable[tuple[str, str]] = ()) -> None:
    """Print the results of one campaign to stdout.

    Parameters
    ----------
    findings : Findings
    folder : Path
        Where the report lies.
    notices : iterable of (str, str)
        Kind and sentence of what page 1 says of checks, models and comparisons.
    """
    from rich.console import Console

    from metrology.language.notices import WARNS

    console = Console(highlight=False)
    # Lines that go to a file or another program stay whole.
    console.soft_wrap = not console.is_terminal
    results = _results(findings, console)
    # Headings above nothing say no more than the title.
    console.print(results if results.row_count else results.title)
    _print_verdicts(findings, console)
    for sentence in _replaced(findings.results):
        console.print(f"[yellow]model[/] {shown(sentence)}")
    for kind, sentence in notices:
        console.print(f"[yellow]{kind.lower()}[/] {shown(sentence)}")
    for row in findings.audit:
        if not row.agrees:
            console.print(f"[yellow]audit[/] {shown(row.figure)}: {shown(row.sentence)}")
    for sentence in findings.failures:
        console.print(f"[red]failed[/] {shown(sentence)}")
    told = {one.sentence for one in findings.notices if one.kind in WARNS}
    for sentence in (one for one in findings.warnings if one not in told):
        console.print(f"[yellow]note[/] {shown(sentence)}")
    for sentence in missing(findings):
        console.print(f"[yellow]DRAFT[/] {sentence}")
    pdf = folder / "report.pdf"
    console.print(f"written to {shown(str(pdf if pdf.is_file() else folder))}")


def _print_verdicts(findings: Findings, console: Console) -> None:
    for conformity in findings.conformity:
        colour = MARKS[conformity.verdict]
        console.print(
            f"[{colour}]{conformity.verdict}[/] {shown(conformity.requirement)}: {shown(conformity.sentence)}"
        )
    for withheld in findings.withheld:
        reasons = " ".join(withheld.reasons)
        console.print(f"[yellow]not judged[/] {shown(withheld.requirement)}: {shown(reasons)}")


def shown(text: str) -> str:
    """Return a text of the campaign as the terminal shows it: no markup, no control characters."""
    from rich.markup import escape

    return escape(printable(text))


def missing(findings: Findings) -> Iterator[str]:
    """How many items each checklist lacks, for which the report is a draft."""
    from metrology import checklist

    record = checklist.of_findings(findings)
    for standard in findings.campaign.checklists:
        count = sum(row.state == "missing" for row in checklist.rows(record, standard))
        if count:
            yield f"{count} item{'' if count == 1 else 's'} missing for {standard}"


def _results(findings: Findings, console: Console) -> Table:
    """The table of results, without as many columns as a narrow terminal has no room for."""
    interval = f"{findings.campaign.probability:.0%} interval"
    rows = [_row(result) for result in findings.results if result.headline]
    rows += [_agreed(entry) for entry in findings.consensus if entry.consistent is not None]
    rows = rows or list(_fitted(findings))
    for left_out in _left_out(rows, interval):
        table = _table(f"{findings.campaign.id}: {findings.campaign.title}", interval, rows, left_out)
        if console.measure(table, options=console.options.update(max_width=_UNBOUNDED)).maximum <= console.width:
            break
    return table


def _left_out(rows: Sequence[tuple[str, ...]], interval: str) -> Iterator[tuple[str, ...]]:
    """Headings that may be left out, fewest first, for as long as the others tell all results apart."""
    yield ()
    for also in ((), (interval,)):
        for names in (("method",), ("method", "sample"), ("method", "test")):
            kept = [at for at, heading in enumerate(_NAMES) if heading not in names]
            if len({tuple(row[at] for at in kept) for row in rows}) == len({row[: len(_NAMES)] for row in rows}):
                yield *names, *also


def _table(title: str, interval: str, rows: Sequence[tuple[str, ...]], left_out: Sequence[str]) -> Table:
    from rich.table import Table

    table = Table(title=shown(title), title_justify="left")
    headings = (*_NAMES, "value", "u", "unit", interval)
    kept = [at for at, heading in enumerate(headings) if heading not in left_out]
    for at in kept:
        number = headings[at] in {"value", "u"}
        table.add_column(headings[at], justify="right" if number else "left", no_wrap=number)
    for row in rows:
        table.add_row(*(shown(row[at]) for at in kept))
    return table


def _replaced(results: Iterable[Result]) -> Iterator[str]:
    """Why the results of a test are not those of the model as stated, and what that gives; one reason, one sentence."""
    groups: dict[tuple[str, str], list[str]] = {}
    for result in results:
        if result.headline and result.stated is not None:
            groups.setdefault((result.test, result.stated.why), []).append(_stated(result, result.stated))
    for (test, why), values in groups.items():
        yield f"{test}: {why}. The model as stated gives {', '.join(values)}."


def _stated(result: Result, known: AsStated) -> str:
    from metrology.gum.rounding import significant
    from metrology.units import convert, factor

    unit = result.display_unit
    value, u = significant(convert(known.value, unit), known.u / factor(unit))
    return f"{result.quantity} = {value} ± {u} {unit_text(unit)}".rstrip()


def _row(result: Result) -> tuple[str, ...]:
    numbers = _numbers(result.value, result.u, result.display_unit, result.interval)
    return result.sample, result.test, result.method, result.quantity, *numbers


def _fitted(findings: Findings) -> Iterator[tuple[str, ...]]:
    """The parameters of the fits, which are all that a campaign without tests and derived quantities has."""
    fits = {fit.name for fit in findings.fits}
    for result in findings.results:
        if result.test in fits:
            sample, test, _, *rest = _row(result)
            yield sample, test, "fit", *rest


def _agreed(entry: Consensus) -> tuple[str, ...]:
    """The consensus of several tests; that there is none, where they are not consistent."""
    counted = {one.result.rpartition(".")[2] for one in entry.members if not one.why_not}
    head = (entry.sample, "consensus", "", counted.pop() if len(counted) == 1 else entry.quantity)
    if not entry.consistent or entry.value is None or entry.u is None:
        return *head, "–", "–", unit_text(entry.display_unit), "not consistent"
    return *head, *_numbers(entry.value, entry.u, entry.display_unit, (entry.low, entry.high))


def _numbers(value: float, u: float, unit: str, interval: tuple[float | None, float | None]) -> tuple[str, ...]:
    """Value, u, unit and interval as texts: u to two digits, all to the same place; no value has no u either."""
    from metrology.gum.rounding import significant
    from metrology.units import convert, factor

    if not isfinite(value):
        return "undefined", "–", unit_text(unit), "–"
    size = u / factor(unit)
    ends = [significant(convert(end, unit), size)[0] for end in interval if end is not None]
    text = "–" if not ends or "undefined" in ends else f"[{', '.join(ends)}]"
    return *significant(convert(value, unit), size), unit_text(unit), text
