"""Stiffness and damping of a response test by every way that they were estimated, and the one that counts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import number, rounded
from metrology.message import said
from metrology.units import unit_text

if TYPE_CHECKING:
    from metrology.findings import Findings, Result

Pair = tuple[float, float | None]
"""Value and standard uncertainty."""


@dataclass(frozen=True)
class Way:
    """One way: a cell for each quantity, whether it is the result, and why it differs from the others."""

    way: str
    columns: tuple[tuple[str, str], ...]
    cells: tuple[str, ...]
    why: str
    counts: bool


def ways(findings: Findings, test: str, language: Language = ENGLISH) -> list[Way]:
    """K and c as published, by the model as stated, and as reported; empty where there is one way only."""
    results = {one.quantity: one for one in findings.results if one.test == test and one.quantity in ("k", "c")}
    made = list(_ways(findings, test, results))
    columns = tuple((name, unit_text(one.unit)) for name, one in results.items())
    if len(made) < 2 or not columns:
        return []
    return [
        Way(
            language.spoken(way),
            columns,
            tuple(_cell(values.get(name)) for name, _ in columns),
            language.spoken(why),
            counts,
        )
        for way, values, why, counts in made
    ]


def _ways(
    findings: Findings, test: str, results: Mapping[str, Result]
) -> Iterator[tuple[str, Mapping[str, Pair | None], str, bool]]:
    finding = next((one.response for one in findings.tests if one.id == test), None)
    diagnosed = next((one.supported for one in findings.diagnosis if one.test == test), None)
    paper = finding.paper if finding is not None else None
    if paper is not None and paper.k is not None and paper.c is not None:
        known = {"k": (paper.k, paper.k_u), "c": (paper.c, paper.c_u)}
        why = said("every input is taken as exact")
        yield said("Method of the paper: least RMS difference"), known, why, False
    changed = any(one.stated is not None for one in results.values())
    stated = {name: (one.stated.value, one.stated.u) for name, one in results.items() if one.stated is not None}
    identified = said("Model as stated, runs for identification")
    if not changed:
        yield identified, {n: (r.value, r.u) for n, r in results.items()}, "", True
        return
    yield identified, stated, said("lacks what the diagnosis found"), False
    if diagnosed is not None:
        rows = zip(diagnosed.names, diagnosed.stated, diagnosed.stated_u, strict=True)
        yield (
            said("Model as stated, all runs"),
            {name: (value, u) for name, value, u in rows},
            said("lacks what the diagnosis found; u of the noise alone"),
            False,
        )
    reported = {name: (one.value, one.u) for name, one in results.items()}
    yield said("Model that the data support, all runs"), reported, "", True


def _cell(known: Pair | None) -> str:
    if known is None or known[0] != known[0]:
        return "–"
    value, u = known
    return number(value, 5) if u is None else " ± ".join(rounded(value, u))
