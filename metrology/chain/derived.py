"""Quantities that the campaign derives itself, by expressions over inputs and results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from metrology import units
from metrology.chain.plan import Identity, Plan
from metrology.expression import Expression
from metrology.gum.evaluation import Measurand
from metrology.message import said
from metrology.sample import area

if TYPE_CHECKING:
    from metrology.campaign.judgement import Derived
    from metrology.campaign.schema import Campaign


def add_areas(plan: Plan, campaign: Campaign) -> None:
    """Add the area of every section as a quantity that others use."""
    for name, sample in campaign.samples.items():
        if sample.section is not None:
            plan.add_measurand(
                area(name, sample.section.shape), Identity("A", "derived", name, "", "mm^2", headline=False)
            )


def add_derived(plan: Plan, campaign: Campaign) -> None:
    """Add every derived quantity after those that it needs; one that needs a failed result fails with it."""
    positions = {derived.name: index for index, derived in enumerate(campaign.derived)}
    for derived in campaign.names.order:
        meaning = campaign.names.meanings["derived", positions[derived.name]]
        if missing := sorted(set(meaning.values()) - plan.names):
            text = "{name} cannot be computed, for want of {missing:comma}."
            plan.failures.append(said(text, name=derived.name, missing=tuple(missing)))
            continue
        plan.add_measurand(_measurand(derived, meaning), _identity(derived))


def _measurand(derived: Derived, meaning: Mapping[str, str]) -> Measurand:
    function = over(derived.expression, meaning)
    return Measurand(derived.name, function, units.si_unit(derived.unit), f"{derived.quantity} = {derived.expression}")


def _identity(derived: Derived) -> Identity:
    return Identity(derived.quantity, "derived", derived.sample or "", "", derived.unit)


def over(expression: str, meaning: Mapping[str, str]) -> Callable[[Mapping[str, Any]], Any]:
    """Return an expression as a function of the campaign's quantities, by the full name of each of its names."""
    parsed = Expression.parse(expression)
    return lambda namespace: parsed.evaluate({name: namespace[full] for name, full in meaning.items()})
