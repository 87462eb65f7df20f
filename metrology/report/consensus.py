"""The same quantity by several methods, as the report prints it."""

from __future__ import annotations

from dataclasses import dataclass
from math import log, nan
from typing import TYPE_CHECKING, Any

from metrology.language import done
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import Shown, estimate, like, number, symbol
from metrology.units import factor

if TYPE_CHECKING:
    from metrology.consensus import Candidate, Consensus, Member
    from metrology.findings import Findings


@dataclass(frozen=True)
class Row:
    """A result of the table, with value and u as text."""

    member: Member
    test: str
    symbol: str
    shown: Shown
    time: str


@dataclass(frozen=True)
class Group:
    """A quantity of a sample: its results, and the consensus where there is one.

    `expanded` and `factor`: U to the place of u and U/u, a dash where the interval is unknown; `cells`: value, u, U and
    the ends of the interval as they stand in the table of page 1.
    """

    entry: Consensus
    sample: str
    rows: tuple[Row, ...]
    shown: Shown | None
    expanded: str = "–"
    factor: str = "–"
    cells: tuple[str, ...] = ()

    @property
    def counted(self) -> tuple[Row, ...]:
        """Results that count."""
        return tuple(row for row in self.rows if not row.member.why_not)

    @property
    def symbol(self) -> str:
        """Symbol that all results that count have, such as k_t; else that of the quantity."""
        own = {row.symbol for row in self.counted}
        return own.pop() if len(own) == 1 else symbol(self.entry.quantity)

    @property
    def is_a_pair(self) -> bool:
        """Two results that agree: their comparison and the certificate say all that there is."""
        return bool(self.entry.consistent) and len(self.rows) == 2

    @property
    def word(self) -> str:
        """``stiffness``."""
        return WORDS.get(self.entry.quantity, "")


WORDS = {"k": "stiffness", "E": "modulus of elasticity", "c": "damping coefficient"}
"""Quantities of which a campaign may have several results → what they are called."""


def names(findings: Findings, language: Language = ENGLISH) -> dict[str, Any]:
    """Names that the templates use."""
    every = groups(findings, language)
    return {
        "agreed": [group for group in every if not group.is_a_pair],
        "common": [group for group in every if group.entry.consistent],
        "apart": [group for group in every if group.entry.consistent is False],
        "parted": [(one, [(each, _size(each)) for each in one.candidates if each.probability >= 1e-3])
                   for one in findings.disagreements],
    }  # fmt: skip


def groups(findings: Findings, language: Language = ENGLISH) -> list[Group]:
    """Every quantity that several tests give."""
    samples = {sample.id: sample.name for sample in findings.samples}
    return [_group(findings, one, samples.get(one.sample) or one.sample, language) for one in findings.consensus]


def _group(findings: Findings, entry: Consensus, sample: str, language: Language) -> Group:
    called, unit = done.called(findings, language), entry.display_unit
    rows = tuple(
        Row(
            one, called.get(one.test, one.test).removeprefix(f"{sample}, "), symbol(one.result.rpartition(".")[2]),
            estimate(one.value, one.u, unit), "–" if one.seconds is None else f"{number(one.seconds, 2)} s",
        )
        for one in entry.members
    )  # fmt: skip
    if entry.value is None or entry.u is None:
        return Group(entry, sample, rows, None)
    shown = estimate(entry.value, entry.u, unit, (entry.low, entry.high))
    if entry.low is None or entry.high is None or not entry.u > 0:
        return Group(entry, sample, rows, shown)
    expanded = like(0.5 * (entry.high - entry.low) / factor(unit), shown.u)
    return Group(entry, sample, rows, shown, expanded, number(_factor(entry.low, entry.high, entry.u / entry.value)))


def _factor(low: float, high: float, u: float) -> float:
    """Coverage factor of an interval that is symmetric in the logarithm, for a relative u."""
    return 0.5 * log(high / low) / u if low > 0 else nan


def _size(one: Candidate) -> str:
    """``C = 1.77 ± 0.17 µm/N``; a dash where there is no parameter."""
    if one.value is None or one.u is None:
        return "–"
    shown = estimate(one.value, one.u, "um/N" if one.unit == "m/N" else one.unit)
    return f"{one.parameter} = {shown.value} ± {shown.u} {shown.unit}".rstrip()
