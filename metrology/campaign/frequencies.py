"""Frequencies and angular frequencies: both are 1/s, and ω = 2π·f."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from metrology import units
from metrology.declaration.entry import Refusal
from metrology.expression import Expression
from metrology.methods import METHODS
from metrology.units.dimensions import TextError, quoted

if TYPE_CHECKING:
    from metrology.campaign.judgement import Derived
    from metrology.campaign.names import Names
    from metrology.campaign.schema import Campaign
    from metrology.declaration.document import Place
    from metrology.declaration.quantity import Stated

CYCLES, RADIANS = "Hz", "rad/s"
FIX = "ω = 2π·f"
STATED = {"limits": ("lower", "upper"), "prior": ("mean", "standard", "scale", "median", "low", "high")}
STRETCH = 1.5
"""Factor by which quantities are multiplied to see whether a result is in proportion to them; any other would do."""


def check_frequencies(campaign: Campaign, names: Names) -> Iterator[Refusal]:
    """Frequencies in hertz where radians per second are due, and the other way round.

    Parameters
    ----------
    campaign : Campaign
        Checked entry by entry.
    names : Names
        Every name of it, with what the names of its expressions mean.

    Yields
    ------
    Refusal
        With its place from the root of the file.
    """
    due = _due(campaign)
    for index, one in enumerate(campaign.derived):
        yield from _derived(one, names.meanings["derived", index], due, ("derived", index, "unit"))
    yield from _requirements(campaign, due)
    for index, comparison in enumerate(campaign.comparisons):
        sides = [_kind(side.value.unit) if side.value else due.get(side.quantity or "", "") for side in
                 comparison.between]  # fmt: skip
        if set(sides) == {CYCLES, RADIANS}:
            got = "a frequency and an angular frequency"
            yield Refusal(("comparisons", index, "between"), got, "two quantities of one kind", FIX)
    for index, audit in enumerate(campaign.audit):
        yield from _against(due.get(audit.quantity or "", ""), audit.published, ("audit", index, "published"))
    for name, sample in campaign.samples.items():
        tests = [test for test, one in campaign.tests.items() if one.sample == name]
        for key, stated in sample.references.items():
            for kind in {due.get(f"{test}.{key}", "") for test in tests}:
                yield from _against(kind, stated, ("samples", name, "references", key))


def _requirements(campaign: Campaign, due: Mapping[str, str]) -> Iterator[Refusal]:
    for index, requirement in enumerate(campaign.requirements):
        for group, keys in STATED.items():
            for key in keys:
                value = getattr(getattr(requirement, group), key, None)
                yield from _against(due.get(requirement.quantity, ""), value, ("requirements", index, group, key))


def _due(campaign: Campaign) -> dict[str, str]:
    """By name: `CYCLES` or `RADIANS`, of what is one of these."""
    found = {name: stated.unit for name, stated in campaign.quantities.items()}
    for name, test in campaign.tests.items():
        found |= {f"{name}.{key}": unit for key, unit in METHODS[test.method].yields(campaign, test).items()}
    for ensemble in campaign.ensembles.values():
        found |= {name: heading.partition("/")[2].strip() for name, heading in ensemble.columns.items()}
    found |= {one.name: one.unit for one in campaign.derived}
    return {name: kind for name, unit in found.items() if (kind := _kind(unit))}


def _kind(unit: str) -> str:
    try:
        si = units.unit(unit or "1").si
    except TextError:
        return ""
    return si if si in (CYCLES, RADIANS) else ""


def _against(due: str, stated: Stated | None, place: Place) -> Iterator[Refusal]:
    if stated is not None and {due, _kind(stated.unit)} == {CYCLES, RADIANS}:
        got, name = units.unit(stated.unit), units.unit(due).name
        yield Refusal(place, f"{quoted(stated.value)}, {got.name}", f"{name}, in {due}, as the quantity", FIX)


def _derived(derived: Derived, meaning: Mapping[str, str], due: Mapping[str, str], place: Place) -> Iterator[Refusal]:
    """Refuse a unit of one kind for what is in proportion to quantities of the other, without a π in between."""
    kind = _kind(derived.unit)
    others = [name for name, full in meaning.items() if kind and {kind, due.get(full, "")} == {CYCLES, RADIANS}]
    try:
        expression = Expression.parse(derived.expression)
        if not others or expression.names - meaning.keys() or any(step.word == "pi" for step in expression.steps):
            return
        values = {name: 1.0 + 0.1 * at for at, name in enumerate(sorted(meaning), start=1)}
        one = expression.evaluate(values)
        more = expression.evaluate({name: value * (STRETCH if name in others else 1) for name, value in values.items()})
    except (TextError, ArithmeticError, ValueError):
        return
    if one and math.isclose(more / one, STRETCH, rel_tol=1e-9):
        got, name = units.unit(derived.unit), units.unit(due[meaning[others[0]]]).name
        expected = f"a unit of {name}, which the expression gives"
        yield Refusal(place, f"{quoted(derived.unit)}, {got.name}", expected, FIX)
