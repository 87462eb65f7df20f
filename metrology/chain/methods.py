"""The tests of a campaign, each by its method: what it puts into the measurement model, and what it shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from metrology import decay, elongation
from metrology.campaign.methods import DecayTest, ElongationTest, ResponseTest
from metrology.chain import diagnosis, response
from metrology.chain.items import test_items
from metrology.chain.plan import Identity, Plan
from metrology.errors import Fault, MetrologyError
from metrology.expression import Expression
from metrology.gum.distributions import Normal, Rectangular
from metrology.gum.inputs import Component, Input
from metrology.sample import modulus
from metrology.timeseries import Channel

if TYPE_CHECKING:
    from metrology.campaign.identity import Instrument
    from metrology.campaign.quantity import Stated
    from metrology.campaign.schema import Campaign
    from metrology.campaign.tables import Table

Progress = Callable[[str], None]
AIR_DENSITY = Input(
    "air density",
    1.20,
    (Component("usual laboratory air", Rectangular(0.10), source="20 °C ± 10 K at 1013 hPa ± 50 hPa"),),
    "kg/m³",
    "density of the air",
)
WEIGHT_DENSITY = Input(
    "weight density",
    8000.0,
    (Component("usual weights", Rectangular(170.0), source="conventional 8000 kg/m³, limits wide enough for steels"),),
    "kg/m³",
    "density of the weights",
)
NO_GRAVITY = Input("gravity", 1.0, (), "m/s²", "local acceleration of free fall")
"""Stands where every load is a force: nothing reads it, and the file must state gravity where loads are masses."""


def add_tests(plan: Plan, campaign: Campaign, progress: Progress) -> None:
    """Add every test: elongation first, since decay takes its stiffness from it, and response both from them."""
    items = {item.id: item for item in test_items(campaign)}
    for name, test in campaign.tests.items():
        if isinstance(test, ElongationTest):
            finding = _add_elongation(plan, campaign, name, test, progress)
            items[name] = replace(items[name], elongation=finding)
    for name, test in campaign.tests.items():
        if isinstance(test, DecayTest):
            items[name] = replace(items[name], decay=_add_decay(plan, campaign, name, test, progress))
    for name, test in campaign.tests.items():
        if isinstance(test, ResponseTest):
            items[name] = replace(items[name], response=response.add_response(plan, campaign, name, test, progress))
    plan.tests.extend(items.values())


def _add_elongation(
    plan: Plan, campaign: Campaign, name: str, test: ElongationTest, progress: Progress
) -> elongation.ElongationFinding:
    prepared = _elongation_test(plan, campaign, name, test)
    analysis = elongation.analyse(prepared)
    plan.add_inputs(analysis.inputs)
    plan.ensembles.extend(analysis.ensembles)
    plan.correlate(analysis.correlations)
    for measurand in analysis.measurands:
        plan.add_measurand(measurand, Identity("k", "elongation", test.sample, name, "N/m"))
    _add_modulus(plan, name, test.sample)
    plan.elongations[name] = prepared
    diagnosis.add_elongation(plan, campaign, prepared, test.sample, progress)
    return analysis.finding


def _add_modulus(plan: Plan, name: str, sample: str) -> None:
    """Add E = k·L/A where section and length of the sample are known."""
    if f"{sample}.A" not in plan.names or f"{sample}.length" not in plan.names:
        return
    measurand = modulus(f"{name}.E", k=f"{name}.k", length=f"{sample}.length", area=f"{sample}.A")
    plan.add_measurand(measurand, Identity("E", "elongation", sample, name, "GPa"))


def _elongation_test(plan: Plan, campaign: Campaign, name: str, test: ElongationTest) -> elongation.ElongationTest:
    indicator = campaign.instruments[test.instruments.extension]
    weights = campaign.instruments[test.instruments.load] if test.instruments.load else None
    (table,) = campaign.tables["tests", name]
    return elongation.ElongationTest(
        name=name,
        loads=tuple(elongation.Load(load_name, _load(name, load_name, test, weights)) for load_name in test.loads),
        readings=_readings(table, _reasons(test)),
        resolution=_resolution(indicator),
        gravity=_shared(plan, name, test.gravity, NO_GRAVITY),
        air_density=_shared(plan, name, test.air_density, AIR_DENSITY),
        weight_density=_shared(plan, name, test.weight_density, WEIGHT_DENSITY),
        weights=_relative_certificate(test.instruments.load, weights),
        indicator=_certificate(indicator, "m"),
        scale=_relative_certificate(test.instruments.extension, indicator),
        correction=_correction(plan, campaign, test.instruments.extension),
    )


def _reasons(test: ElongationTest) -> dict[int, str]:
    return {exclusion.line: exclusion.reason for exclusion in test.exclusions if exclusion.line is not None}


def _shared(plan: Plan, test: str, stated: Stated | None, supposed: Input) -> Input:
    """Return what surrounds a test as an input: one with every other test that states the same, else one of its own."""
    name = supposed.name
    own = stated.input(name, supposed.description) if stated else supposed
    others = (other for key, other in plan.inputs.items() if key == name or key.endswith(f".{name}"))
    same = next((other for other in others if replace(other, name=name, description=own.description) == own), None)
    if same is not None:
        return same
    return replace(own, name=f"{test}.{name}") if name in plan.inputs else own


def _readings(table: Table, excluded: Mapping[int, str]) -> tuple[elongation.Reading, ...]:
    rows = zip(
        table.texts["load"],
        table.texts["repeat"],
        table.texts["direction"],
        table.numbers["reading"].tolist(),
        table.lines.tolist(),
        strict=True,
    )
    return tuple(elongation.Reading(*row, excluded=excluded.get(row[-1], "")) for row in rows)


def _load(test_name: str, name: str, test: ElongationTest, weights: Instrument | None) -> Input:
    stated = test.loads[name].mass or test.loads[name].force
    assert stated is not None
    load = stated.input(f"{test_name}.load {name}", f"load {name}")
    certificate = _certificate(weights, load.unit) if weights else ()
    return replace(load, components=(*load.components, *certificate))


def _resolution(instrument: Instrument) -> Component:
    assert instrument.resolution is not None
    return Component("resolution", Rectangular(instrument.resolution.si / 2), source="division of the instrument")


def _certificate(instrument: Instrument, unit: str) -> tuple[Component, ...]:
    """Return what the certificate says of one indication, where it says it in `unit`."""
    certificate = instrument.certificate
    stated = certificate.expanded_uncertainty if certificate else None
    if certificate is None or stated is None or stated.si_unit != unit:
        return ()
    dof = certificate.dof or float("inf")
    return (Component("certificate", Normal(certificate.u), dof, source=f"certificate {certificate.number}"),)


def _relative_certificate(name: str | None, instrument: Instrument | None) -> Input | None:
    """Return what a certificate says of all indications alike, where it says it as a share of the indication."""
    if instrument is None or not (components := _certificate(instrument, "1")):
        return None
    return Input(f"{name}.scale", 0.0, components, "1", f"relative correction of {name}")


def _correction(plan: Plan, campaign: Campaign, name: str) -> elongation.Correction | None:
    """Return the correction of an instrument's readings: a constant, or a fitted curve at the indication."""
    correction = campaign.instruments[name].correction
    if correction is None:
        return None
    if correction.fit is None:
        key = f"{name}.correction"
        return elongation.Correction(lambda namespace, reading: reading + namespace[key], (plan.inputs[key],))
    fit = campaign.fits[correction.fit]
    _refuse_failed_fit(plan, campaign, name, correction.fit)
    curve = fitted_curve(
        correction.fit, fit.model.expression, fit.parameters, origin=fit.origin.si if fit.origin else 0.0
    )
    parameters = tuple(plan.inputs[f"{correction.fit}.{parameter}"] for parameter in fit.parameters)
    return elongation.Correction(lambda namespace, reading: reading + curve(namespace, reading), parameters)


def _refuse_failed_fit(plan: Plan, campaign: Campaign, instrument: str, fit: str) -> None:
    sentence = next((found.sentence for found in plan.fits if found.name == fit and not found.u), None)
    if sentence is not None:
        where = campaign.at("instruments", instrument, "correction", "fit")
        raise MetrologyError(Fault(where, f"fit '{fit}', which failed", "a fit that did not", sentence))


def fitted_curve(
    name: str, expression: str | None, parameters: tuple[str, ...], *, origin: float = 0.0
) -> Callable[[Mapping[str, Any], Any], Any]:
    """Return the fitted line or curve as a function of a namespace that holds its parameters, and of x in SI."""
    if expression is None:
        return lambda namespace, x: namespace[f"{name}.intercept"] + namespace[f"{name}.slope"] * (x - origin)
    parsed = Expression.parse(expression)

    def curve(namespace: Mapping[str, Any], x: Any) -> Any:
        return parsed.evaluate({"x": x} | {parameter: namespace[f"{name}.{parameter}"] for parameter in parameters})

    return curve


def _add_decay(plan: Plan, campaign: Campaign, name: str, test: DecayTest, progress: Progress) -> decay.DecayFinding:
    prepared = _decay_test(campaign, name, test)
    analysis = decay.analyse(prepared)
    plan.add_inputs(analysis.inputs)
    plan.ensembles.extend(analysis.ensembles)
    plan.correlate(analysis.correlations)
    for measurand in analysis.measurands:
        quantity = measurand.name.rpartition(".")[2]
        unit = "%" if quantity == "zeta" else measurand.unit
        plan.add_measurand(measurand, Identity(quantity, "decay", test.sample, name, unit))
    plan.failures.extend(f"{name}: {sentence}" for sentence in analysis.finding.failures)
    plan.traces.update({f"decay/{name}/{record}": trace for record, trace in analysis.traces.items()})
    diagnosis.add_decay(plan, campaign, prepared, test.sample, progress)
    return analysis.finding


def _decay_test(campaign: Campaign, name: str, test: DecayTest) -> decay.DecayTest:
    instrument = campaign.instruments[test.instruments.displacement]
    static = f"{test.stiffness}.k" if test.stiffness else f"{name}.k"
    mass = test.inert.input(f"{name}.mass", "mass that oscillates" if test.mass else "moment of inertia")
    left_out = {exclusion.file for exclusion in test.exclusions}
    return decay.DecayTest(
        name=name,
        records=tuple(
            _record(table, *test.column)
            for table in campaign.tables["tests", name]
            if table.source.path not in left_out
        ),
        mass=mass,
        stiffness=static,
        scale=_relative_certificate(test.instruments.displacement, instrument),
        mains=test.mains.si,
        expected=2 * pi * test.expected.si if test.expected else None,
    )


def _record(table: Table, column: str, unit: str) -> Channel:
    """Return a release as it was read: a line without a reading is none."""
    time, value = table.numbers["time"], table.numbers[column]
    read = np.isfinite(value)
    return Channel(table.source.path, time[read], value[read], unit)
