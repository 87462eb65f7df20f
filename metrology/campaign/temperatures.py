"""Temperatures and differences of temperatures: degrees Celsius and Fahrenheit have a zero of their own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from metrology import units
from metrology.declaration.entry import Refusal
from metrology.expression import Expression
from metrology.units.dimensions import TextError, quoted

if TYPE_CHECKING:
    from metrology.campaign.judgement import Derived
    from metrology.campaign.names import Names
    from metrology.campaign.schema import Campaign
    from metrology.declaration.document import Place
    from metrology.declaration.quantity import Stated

KELVIN = units.dimension("K")


def check_temperatures(campaign: Campaign, names: Names) -> Iterator[Refusal]:
    """Differences that are stated, or limited, in a unit with a zero of its own: 0.5 °C is 273.65 K.

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
    # A result of another campaign is entered in kelvin, and meant as its own report shows it.
    shown = {one.about: one.display_unit for one in campaign.imported if one.display_unit}
    stated = {
        name: shown.get(one.source, one.unit) for name, one in campaign.quantities.items() if one.dimension == KELVIN
    }
    stated |= {one.name: one.unit for one in campaign.derived if names.dimensions.get(one.name) == KELVIN}
    for index, one in enumerate(campaign.derived):
        if stated.get(one.name) == one.unit and _has_zero(one.unit):
            yield from _derived(one, names.meanings["derived", index], stated, ("derived", index, "unit"))
    place: Place
    for index, requirement in enumerate(campaign.requirements):
        for key in ("lower", "upper"):
            place = ("requirements", index, "limits", key)
            yield from _against(stated.get(requirement.quantity), getattr(requirement.limits, key), place)
    for index, comparison in enumerate(campaign.comparisons):
        for number, side in enumerate(comparison.between):
            other = comparison.between[1 - number]
            yield from _against(stated.get(other.quantity or ""), side.value, ("comparisons", index, "between", number))


def _has_zero(unit: str) -> bool:
    return units.convert(0.0, unit) != 0.0


def _derived(one: Derived, meaning: dict[str, str], stated: dict[str, str], place: Place) -> Iterator[Refusal]:
    """A temperature moves by a degree when all temperatures do of which it is made; their difference does not."""
    temperatures = [name for name, full in meaning.items() if full in stated]
    moved = [name for name in temperatures if _has_zero(stated[meaning[name]])] or temperatures
    if not moved:
        return
    # Any numbers: where the result is a temperature, none of them matters.
    values = {name: 1.0 + 0.37 * at for at, name in enumerate(meaning)} | {
        name: 290.0 + 7.0 * at for at, name in enumerate(temperatures)
    }
    try:
        expression = Expression.parse(one.expression)
        by = [float(expression.evaluate(values | {name: values[name] + by for name in moved})) for by in (0.0, 1.0)]
    except (TextError, ArithmeticError):
        return
    if not np.isclose(by[1] - by[0], 1.0, rtol=0.0, atol=1e-6):
        got = f"{quoted(one.unit)} of a result that is no temperature: it does not rise by 1 K when its temperatures do"
        yield Refusal(place, got, "a unit of a difference", "state it in K")


def _against(unit: str | None, stated: Stated | None, place: Place) -> Iterator[Refusal]:
    if unit is not None and stated is not None and _has_zero(stated.unit) and not _has_zero(unit):
        got = f"'{stated.value}', a temperature, which is {stated.si:g} K, of a quantity in {unit}"
        fix = "state the difference in K, or the quantity, if it is a temperature, in degC"
        yield Refusal(place, got, f"a value in {unit}", fix)
