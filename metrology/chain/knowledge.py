"""Inputs of the campaign's measurement model: what the file states, and what readings of the laboratory's own say."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from metrology.chain.plan import Identity, Plan
from metrology.declaration.quantity import Stated
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Input
from metrology.gum.readings import simultaneous, type_a
from metrology.units import convert

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.fits import Ensemble


def add_stated(plan: Plan, campaign: Campaign) -> None:
    """Add free quantities, properties of samples and corrections of instruments, with their stated correlations."""
    plan.add_inputs(stated.input(name) for name, stated in campaign.quantities.items())
    for sample_name, sample in campaign.samples.items():
        plan.add_inputs(
            stated.input(f"{sample_name}.{key}", f"{key.replace('_', ' ')} of {sample.name or sample_name}")
            for key, stated in sample.properties.items()
        )
    for name, instrument in campaign.instruments.items():
        if instrument.correction is not None and instrument.correction.value is not None:
            plan.add_inputs([instrument.correction.value.input(f"{name}.correction", f"correction of {name}")])
    plan.correlate({correlation.between: correlation.coefficient for correlation in campaign.correlations})


def add_ensembles(plan: Plan, campaign: Campaign) -> None:
    """Add quantities that were read simultaneously; a single column is a plain Type A evaluation."""
    for name, ensemble in campaign.ensembles.items():
        (table,) = campaign.tables["ensembles", name]
        series = {member: table.numbers[heading] for member, heading in ensemble.columns.items()}
        source = ensemble.source or ensemble.readings.name
        means, joint = simultaneous(name, series, source=source)
        for member, heading in ensemble.columns.items():
            unit = table.units[heading]
            quantity = _member(ensemble, member, means[member], unit)
            if len(series) == 1:
                repeatability = type_a("repeatability", series[member], source=source)
                quantity = replace(quantity, components=(repeatability, *quantity.components))
            plan.add_inputs([quantity])
            identity = Identity(member, "derived", display_unit=unit, headline=len(campaign.derived) == 0)
            plan.add_measurand(
                Measurand(f"{name}.{member}", value_of(member), quantity.unit, "mean of the readings"), identity
            )
        if len(series) > 1:
            plan.ensembles.append(joint)


def value_of(name: str) -> Callable[[Mapping[str, Any]], Any]:
    """Return the function that hands an input on as a result."""
    return lambda namespace: namespace[name]


def _member(ensemble: Ensemble, member: str, mean: float, unit: str) -> Input:
    """Return a mean as the file would state it, with the components that the file adds to those of the readings."""
    value = f"{convert(mean, unit)!r} {unit}" if unit != "1" else repr(mean)
    stated = Stated.model_validate({"value": value, "uncertainty": ensemble.uncertainty.get(member, ())})
    return replace(stated.input(member, ensemble.descriptions.get(member, "")), value=mean)
