"""The same quantity by several methods, as the report prints it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from metrology.report import done
from metrology.report.display import Shown, estimate, number, symbol

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
    """A quantity of a sample: its results, and the consensus where there is one."""

    entry: Consensus
    sample: str
    rows: tuple[Row, ...]
    shown: Shown | None

    @property
    def is_a_pair(self) -> bool:
        """Two results that agree: their comparison and the certificate say all that there is."""
        return bool(self.entry.consistent) and len(self.rows) == 2

    @property
    def name(self) -> str:
        """``k of Al-1100 tape``."""
        return f"{symbol(self.entry.quantity)} of {self.sample}"


def names(findings: Findings) -> dict[str, Any]:
    """Names that the templates use."""
    every = groups(findings)
    return {
        "agreed": [group for group in every if not group.is_a_pair],
        "common": [group for group in every if group.entry.consistent],
        "parted": [(one, [(each, _size(each)) for each in one.candidates if each.probability >= 1e-3])
                   for one in findings.disagreements],
    }  # fmt: skip


def groups(findings: Findings) -> list[Group]:
    """Every quantity that several tests give."""
    samples = {sample.id: sample.name for sample in findings.samples}
    return [_group(findings, one, samples.get(one.sample) or one.sample) for one in findings.consensus]


def _group(findings: Findings, entry: Consensus, sample: str) -> Group:
    called, unit = done.called(findings), entry.display_unit
    rows = tuple(
        Row(
            one, called.get(one.test, one.test).removeprefix(f"{sample}, "), symbol(one.result.rpartition(".")[2]),
            estimate(one.value, one.u, unit), "–" if one.seconds is None else f"{number(one.seconds, 2)} s",
        )
        for one in entry.members
    )  # fmt: skip
    shown = None
    if entry.value is not None and entry.u is not None:
        shown = estimate(entry.value, entry.u, unit, (entry.low, entry.high))
    return Group(entry, sample, rows, shown)


def _size(one: Candidate) -> str:
    """``C = 1.77 ± 0.17 µm/N``; a dash where there is no parameter."""
    if one.value is None or one.u is None:
        return "–"
    shown = estimate(one.value, one.u, "um/N" if one.unit == "m/N" else one.unit)
    return f"{one.parameter} = {shown.value} ± {shown.u} {shown.unit}".rstrip()
