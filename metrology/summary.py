"""The summary that ends a run on a terminal: results, verdicts, what needs attention, where the report lies."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from metrology.findings import Findings, Result

MARKS = {"pass": "green", "conditional pass": "yellow", "conditional fail": "yellow", "fail": "red"}


def print_summary(findings: Findings, folder: Path) -> None:
    """Print the results of one campaign to stdout."""
    from rich.console import Console
    from rich.markup import escape

    console = Console(highlight=False, soft_wrap=True)
    console.print(_results(findings))
    for conformity in findings.conformity:
        colour = MARKS[conformity.verdict]
        console.print(
            f"[{colour}]{conformity.verdict}[/] {escape(conformity.requirement)}: {escape(conformity.sentence)}"
        )
    for row in findings.audit:
        if not row.agrees:
            console.print(f"[yellow]audit[/] {escape(row.figure)}: {escape(row.sentence)}")
    for sentence in findings.failures:
        console.print(f"[red]failed[/] {escape(sentence)}")
    for sentence in findings.warnings:
        console.print(f"[yellow]note[/] {escape(sentence)}")
    console.print(f"written to {escape(str(folder))}")


def _results(findings: Findings) -> Table:
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(f"{findings.campaign.id}: {findings.campaign.title}"), title_justify="left")
    for heading in (
        "sample",
        "method",
        "quantity",
        "value",
        "u",
        "unit",
        f"{findings.campaign.probability:.0%} interval",
    ):
        table.add_column(heading, justify="right" if heading in {"value", "u"} else "left")
    for result in findings.results:
        if result.headline:
            table.add_row(*(escape(cell) for cell in _row(result)))
    return table


def _row(result: Result) -> tuple[str, ...]:
    from metrology.gum.rounding import significant
    from metrology.units import convert, factor

    unit = result.display_unit
    value, u = significant(convert(result.value, unit), result.u / factor(unit))
    low, high = result.interval
    decimals = len(value.partition(".")[2])
    interval = "–"
    if low is not None and high is not None:
        interval = f"[{convert(low, unit):.{decimals}f}, {convert(high, unit):.{decimals}f}]"
    return result.sample, result.method, result.quantity, value, u, unit, interval
