"""`metrology diagnose`: where the models of campaigns are wrong, why, what an extension gains, and what to do next."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli import campaigns, run
from metrology.cli.campaigns import each_campaign

if TYPE_CHECKING:
    from metrology.diagnosis import Cause, Diagnosis, Shift
    from metrology.findings import Findings

COLOURS = {
    "nothing missing": "green", "explained": "yellow", "explained in the main": "yellow", "ambiguous": "yellow",
    "unexplained": "red", "not testable": "red", "not finished": "red",
}  # fmt: skip
MOST = 6
"""Smallest detectable sizes that are printed; `results.json` has all."""


def add(commands: Any) -> None:
    """Declare the command."""
    parser = campaigns.add(commands, "diagnose", diagnose, "show what models miss, why, and what to do about it")
    campaigns.add_output(parser)
    campaigns.add_code(parser)


def diagnose(options: argparse.Namespace) -> int:
    """Evaluate every file, write what `run` writes, and print what was diagnosed test by test."""
    return each_campaign(options, run.write, print_diagnoses)


def print_diagnoses(findings: Findings, folder: Path) -> None:
    """Print the diagnoses of one campaign to stdout."""
    from rich.console import Console

    from metrology.summary import shown

    console = Console(highlight=False, soft_wrap=True)
    for found in findings.diagnosis:
        heading = shown(f"{found.test} ({found.sample}, {found.method})")
        console.print(f"[bold]{heading}[/]: [{COLOURS[found.verdict]}]{found.verdict}[/]")
        for label, text in block(found, findings):
            console.print(f"  {label:<11}{shown(text)}")
    if not findings.diagnosis:
        console.print(shown(f"{findings.campaign.id}: nothing was diagnosed"))
    for sentence in findings.failures:
        console.print(f"[red]failed[/] {shown(sentence)}")
    for sentence in findings.warnings:
        if "diagnosed" in sentence:
            console.print(f"[yellow]note[/] {shown(sentence)}")
    console.print(f"written to {shown(str(folder))}")


def block(found: Diagnosis, findings: Findings) -> Iterator[tuple[str, str]]:
    """Lines of one diagnosis: a word that says what the line tells, and the line."""
    yield "what", found.sentence
    named = [cause for cause in found.causes if cause.verdict in ("supported", "indistinguishable")]
    for cause in named:
        yield "why", _why(cause)
        for value in cause.parameters:
            yield "", f"{value.name} = {_size(value.value, value.u, value.unit)}"
    for channel, gain in found.gain.items():
        yield (
            "gain",
            f"{channel}, runs left out: residuals over noise {gain.before:.3g} → {gain.after:.3g}, "
            f"ratio {gain.ratio:.3g} [{gain.low:.3g}, {gain.high:.3g}]",
        )
    for shift in found.shifts:
        yield "changed", _changed(shift)
        if shift.name == "k":
            yield from _modulus(found, shift, findings)
    for apart in found.discriminating_tests:
        yield "to tell", f"{apart.measurement}{f' ({apart.power})' if apart.power else ''}"
    for cause in named:
        yield "do next", f"{cause.title}: {cause.advice}"
    if found.verdict == "unexplained" and not named:
        yield "do next", "look at the residuals by phase and at what is missing in the report before k and c are used"
    yield "would show", _detectable(found)
    for sentence in (*found.notes, *found.failures):
        yield "note", sentence


def _why(cause: Cause) -> str:
    worth = ", real but negligible" if cause.negligible else ""
    return f"{cause.effect}: {cause.title}, probability {cause.probability:.2f}{worth}. {cause.sentence}"


def _size(value: float, u: float, unit: str) -> str:
    from metrology.gum.rounding import significant

    unit = "" if unit == "1" else f" {unit}"
    if not math.isfinite(u) or u <= 0:
        return f"{value:.3g}{unit}"
    rounded, of_u = significant(value, u)
    return f"{rounded} ± {of_u}{unit}"


def _changed(shift: Shift) -> str:
    before, after = _size(shift.before, shift.u_before, ""), _size(shift.after, shift.u_after, shift.unit)
    return f"{shift.name}: {before.strip()} → {after}, by {shift.shift:+.1f} u"


def _modulus(found: Diagnosis, shift: Shift, findings: Findings) -> Iterator[tuple[str, str]]:
    """E goes with k, where the test gives one."""
    for result in findings.results:
        if (result.test, result.quantity) == (found.test, "E") and shift.before:
            moved = result.value * (shift.after / shift.before - 1)
            yield "changed", f"E: with k, by {moved / result.value:+.2%} ({moved / result.u:+.1f} u)"


def _detectable(found: Diagnosis) -> str:
    """Smallest sizes that these data show, of some of the causes."""
    sized = [one for one in found.detectable if one.size is not None]
    if not sized:
        return "nothing that could be stated beforehand"
    text = ", ".join(
        f"{one.parameter} {f'off by {one.size:.2g}' if one.unit == '1' else f'{one.size:.2g} {one.unit}'}"
        for one in sized[:MOST]
    )
    rest = len(sized) - MOST
    return f"from {text}{f'; {rest} more in results.json' if rest > 0 else ''}"
