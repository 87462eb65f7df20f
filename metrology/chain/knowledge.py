"""Inputs of the campaign's measurement model: what the file states, and what readings of the laboratory's own say."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from math import inf, isclose
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology.chain import independence
from metrology.chain.plan import Identity, Plan, Suspect
from metrology.declaration.quantity import Stated
from metrology.errors import faults_at
from metrology.gum import anova, functions
from metrology.gum.distributions import MeanSquare, Normal
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Component, Ensemble, Input
from metrology.gum.readings import simultaneous, type_a
from metrology.gum.rounding import readable
from metrology.message import counted, said
from metrology.units import convert, si_unit

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration import ensembles


def _property(key: str, sample: str) -> str:
    return said("{what} of {item}", what=key.replace("_", " "), item=sample)


def add_stated(plan: Plan, campaign: Campaign) -> None:
    """Add free quantities, properties of samples and corrections of instruments, with their stated correlations."""
    plan.add_inputs(stated.input(name) for name, stated in campaign.quantities.items())
    for sample_name, sample in campaign.samples.items():
        plan.add_inputs(
            stated.input(f"{sample_name}.{key}", _property(key, sample.name or sample_name))
            for key, stated in sample.properties.items()
        )
    for name, instrument in campaign.instruments.items():
        if instrument.correction is not None and instrument.correction.value is not None:
            plan.add_inputs(
                [instrument.correction.value.input(f"{name}.correction", said("correction of {name}", name=name))]
            )
    plan.correlate({correlation.between: correlation.coefficient for correlation in campaign.correlations})


def add_ensembles(plan: Plan, campaign: Campaign) -> None:
    """Add quantities that were read simultaneously; a single column is a plain Type A evaluation."""
    for name, ensemble in campaign.ensembles.items():
        if ensemble.factors:
            _add_groups(plan, campaign, name)
            continue
        (table,) = campaign.tables["ensembles", name]
        series = {member: table.numbers[heading] for member, heading in ensemble.columns.items()}
        source = ensemble.source or ensemble.readings.name
        means, joint = simultaneous(name, series, source=source)
        for member, heading in ensemble.columns.items():
            unit = table.units[heading]
            quantity = stated = _member(ensemble, member, means[member], unit)
            if len(series) == 1:
                repeatability = type_a(said("repeatability"), series[member], source=source)
                quantity = replace(quantity, components=(repeatability, *quantity.components))
            plan.add_inputs([quantity])
            found = independence.faults(series[member], resolved=stated.u)
            _suspect(plan, ensemble, member, series[member], found)
            identity = Identity(member, "derived", display_unit=unit, headline=len(campaign.derived) == 0)
            plan.add_measurand(
                Measurand(f"{name}.{member}", value_of(member), quantity.unit, said("mean of the readings")), identity
            )
        if len(series) > 1:
            plan.ensembles.append(joint)


def join_imported(plan: Plan, campaign: Campaign) -> None:
    """Note which inputs are results of other campaigns, and give those of one file the covariance that they have."""
    for one in campaign.imported:
        plan.imported[one.about] = tuple(
            name for name, quantity in plan.inputs.items()
            if any(part.source.endswith(one.about) for part in quantity.components)
        )  # fmt: skip
    for joint in campaign.together:
        # An input is one of the results, or a sum of masses of which several may be.
        weights: dict[str, list[float]] = {}
        for row, (about, component) in enumerate(zip(joint.about, joint.component, strict=True)):
            for name in plan.imported[about]:
                item = plan.inputs[name]
                rest = tuple(part for part in item.components if part.name != component)
                if len(rest) < len(item.components):
                    weights.setdefault(name, [0.0] * len(joint.about))[row] = 1.0
                    plan.inputs[name] = replace(item, components=rest)
        added = np.array(list(weights.values()))
        covariance = added @ np.array(joint.covariance) @ added.T
        source = joint.about[0].partition("; ")[2]
        plan.ensembles.append(Ensemble(joint.name, tuple(weights), covariance, joint.dof, source))


def _add_groups(plan: Plan, campaign: Campaign, name: str) -> None:
    """Add the mean of readings in groups, and the standard deviation by each source of scatter."""
    ensemble = campaign.ensembles[name]
    (table,) = campaign.tables["ensembles", name]
    ((member, heading),) = ensemble.columns.items()
    groups, unit = [table.texts[factor] for factor in ensemble.factors], table.units[heading]
    way = anova.nested if ensemble.nested else anova.crossed
    with faults_at(str(table.path)):
        found = way(table.numbers[heading], groups, ensemble.factors)
    stated = _member(ensemble, member, found.mean, unit)
    source = f"{ensemble.source or ensemble.readings.name}: {'; '.join(_sources(found, unit))}"
    label = (
        said("between {factor}s", factor=ensemble.nested[0])
        if ensemble.nested
        else said("{first} and {second}, crossed", first=ensemble.crossed[0], second=ensemble.crossed[1])
    )
    cells = ["\0".join(names) for names in zip(*groups, strict=True)]
    wrong = independence.grouped(table.numbers[heading], cells, resolved=stated.u)
    _suspect(plan, ensemble, member, table.numbers[heading], wrong, found.u)
    scatter = Component(label, Normal(found.u), found.dof, "A", source)
    plan.add_inputs([replace(stated, components=(scatter, *stated.components))])
    shown = Identity(member, "derived", display_unit=unit, headline=len(campaign.derived) == 0)
    plan.add_measurand(Measurand(f"{name}.{member}", value_of(member), stated.unit, said("mean of the groups")), shown)
    squares = {one.name: f"{name}.MS_{one.name}" for one in found.strata}
    for one in found.strata:
        known = MeanSquare(one.mean_square, one.dof)
        source = counted("1 degree of freedom", "{count} degrees of freedom", one.dof)
        part = Component(said("mean square"), known, inf, "A", source)
        square = si_unit(f"({si_unit(unit)})^2")
        plan.add_inputs(
            [Input(squares[one.name], one.mean_square, (part,), square, said("mean square, {name}", name=one.name))]
        )
    for one in found.strata:
        parts = {squares[other]: part for other, part in one.variance.items()}
        measurand = Measurand(f"{name}.s_{one.name}", _deviation(parts), stated.unit, _equation(one))
        plan.add_measurand(measurand, Identity(f"s_{one.name}", "derived", display_unit=unit, headline=False))


def _suspect(
    plan: Plan, ensemble: ensembles.Ensemble, member: str, values: Any, found: Iterator[str], u: float = 1.0
) -> None:
    """Note what forbids that readings are taken as they stand; `u`: their scatter, zero of groups that are alike."""
    faults = tuple(found)
    if not u and np.ptp(values) and not ensemble.uncertainty.get(member):
        faults = (*faults, said("the means of the groups do not scatter, and no resolution is stated"))
    if faults:
        sentence = said("{name}: {found}.", name=member, found=faults)
        plan.suspect[member] = (Suspect(sentence, ensemble.accepted),)


def _equation(one: anova.Stratum) -> str:
    """Variance of a source by mean squares: of groups of one size a difference over how many readings they have."""
    if not one.rest:
        return "s² = MS"
    rest = "".join(f" {'−' if part > 0 else '+'} {_factor(abs(part))}MS_{name}" for name, part in one.rest.items())
    return f"s² = (MS{rest})/{one.count:.4g}"


def _factor(part: float) -> str:
    return "" if isclose(part, 1.0, rel_tol=1e-9) else f"{part:.4g}·"


def _sources(found: anova.Anova, unit: str) -> Iterator[str]:
    """Where the scatter comes from, in words."""
    for one in found.strata:
        s = readable(found.s(one.name), unit)
        if one.rest:
            ratio, dof, p = found.test(one.name)
            yield f"s({one.name}) = {s}, F({one.dof}, {round(dof, 1):g}) = {ratio:.3g}, p = {p:.2g}"
        else:
            yield f"s({one.name}) = {s}, ν = {one.dof}"


def _deviation(parts: Mapping[str, float]) -> Callable[[Mapping[str, Any]], Any]:
    """Standard deviation by one source; zero where its mean square is no larger than what it is compared with."""

    def function(known: Mapping[str, Any]) -> Any:
        variance = sum(part * known[name] for name, part in parts.items())
        if isinstance(variance, np.ndarray):
            return np.sqrt(np.maximum(variance, 0.0))
        return functions.sqrt(variance) if getattr(variance, "nominal_value", variance) > 0 else 0.0 * variance

    return function


def value_of(name: str) -> Callable[[Mapping[str, Any]], Any]:
    """Return the function that hands an input on as a result."""
    return lambda namespace: namespace[name]


def _member(ensemble: ensembles.Ensemble, member: str, mean: float, unit: str) -> Input:
    """Return a mean as the file would state it, with the components that the file adds to those of the readings."""
    value = f"{convert(mean, unit)!r} {unit}" if unit != "1" else repr(mean)
    stated = Stated.model_validate({"value": value, "uncertainty": ensemble.uncertainty.get(member, ())})
    return replace(stated.input(member, ensemble.descriptions.get(member, "")), value=mean)
