"""Method `elongation`: extension under dead loads, from the readings of a campaign into the model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from metrology import elongation
from metrology.declaration.columns import Column, Table
from metrology.declaration.entry import Refusal, mean
from metrology.errors import Fault, MetrologyError
from metrology.gum.bounded import Rectangular
from metrology.gum.inputs import Component, Input
from metrology.message import said
from metrology.method import Analysed, Files, Loading, Method, Output, Task, instruments
from metrology.method.model import HeldParameter
from metrology.methods.elongation.places import at, places
from metrology.methods.elongation.schema import ElongationInstruments, ElongationTest, Load
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    import numpy as np

    from metrology.declaration.identity import Instrument
    from metrology.diagnosis import Diagnosis, Discrepancy
    from metrology.diagnostics.discrepancy_setting import Setting
    from metrology.gum.evaluation import Contribution
    from metrology.method.declared import Declared
    from metrology.method.model import Model

COLUMNS = (
    Column("load", kind="text"),
    Column("repeat", kind="text", required=False),
    Column("direction", kind="text", required=False, choices=elongation.DIRECTIONS),
    Column("reading", "m", varies=True),
)
AIR_DENSITY = Input(
    "air density",
    1.20,
    (Component(said("usual laboratory air"), Rectangular(0.10), source=said("20 °C ± 10 K at 1013 hPa ± 50 hPa")),),
    "kg/m³",
    said("density of the air"),
)
WEIGHT_DENSITY = Input(
    "weight density",
    8000.0,
    (
        Component(
            said("usual weights"),
            Rectangular(170.0),
            source=said("conventional 8000 kg/m³, limits wide enough for steels"),
        ),
    ),
    "kg/m³",
    said("density of the weights"),
)
NO_GRAVITY = Input("gravity", 1.0, (), "m/s²", said("local acceleration of free fall"))
"""Stands where every load is a force: nothing reads it, and the file must state gravity where loads are masses."""

ONE_ORDER = (
    "Every repeat takes the loads in one order, so that a drift looks like extension and no reading shows it: read "
    "them on the way back as well."
)


def readings(name: str, test: ElongationTest) -> Iterator[Files]:
    """One file: every load, repeat and direction with its reading."""
    yield Files(
        [(("tests", name, "readings"), test.readings)],
        COLUMNS,
        lambda tables: _faults(tables[0], test),
        {"reading": test.instruments.extension},
        "reading",
    )


def _faults(table: Table, test: ElongationTest) -> Iterator[Fault]:
    loads, repeats, directions = _keys(table)
    seen: dict[tuple[str, str, str], int] = {}
    strange: set[str] = set()
    for row, key in enumerate(zip(loads, repeats, directions, strict=True)):
        if key[0] not in test.loads and key[0] not in strange:
            strange.add(key[0])
            near = mean(key[0], list(test.loads))
            yield Fault(
                table.at(row, "load"), quoted(key[0]), f"one of the declared loads {', '.join(test.loads)}", near
            )
        if key in seen:
            got = f"load {key[0]}, repeat {key[1]}, {key[2]} a second time (first in line {table.lines[seen[key]]})"
            yield Fault(table.at(row), got, "every reading once", "number the repeats")
        seen.setdefault(key, row)
    for load in test.loads:
        if load not in loads:
            yield Fault(str(table.path), f"no reading of load '{load}'", "at least one reading of every load")
    if (fault := elongation.too_few(str(table.path), len(loads), len(set(repeats)))) is not None:
        yield fault


def _keys(table: Table) -> tuple[Sequence[str], Sequence[str], Sequence[str]]:
    """Load, repeat and direction of every reading: one repeat, and loading, where the file has no such column."""
    loads = table.texts["load"]
    return (
        loads,
        table.texts.get("repeat", ("1",) * len(loads)),
        table.texts.get("direction", ("loading",) * len(loads)),
    )


def check(campaign: Declared, name: str, test: ElongationTest) -> Iterator[Refusal]:
    """Loads that a line can be drawn through, and an indicator with a resolution."""
    place = ("tests", name)
    if (count := len(test.loads)) < elongation.LEAST_LOADS:
        got = f"{count or 'no'} load{'' if count == 1 else 's'}"
        yield Refusal((*place, "loads"), got, "at least three loads")
    by_mass = [load for load in test.loads.values() if load.mass is not None]
    if by_mass and test.gravity is None:
        expected = "'gravity', such as '9.8060(5) m/s^2', or loads as forces"
        yield Refusal(place, "loads as masses without 'gravity'", expected)
    yield from instruments.check_gravity(test.gravity, *place, "gravity")
    seen: dict[tuple[bool, float], str] = {}
    for load, stated in test.loads.items():
        quantity = stated.mass or stated.force
        key = (stated.mass is not None, quantity.si if quantity else 0.0)
        if key in seen:
            yield Refusal((*place, "loads", load), f"the load of '{seen[key]}' a second time", "loads that differ")
        seen.setdefault(key, load)
    yield from instruments.check_reads(campaign, test.instruments.extension, "m", *place, "instruments", "extension")


def analyse(task: Task[ElongationTest]) -> Analysed[elongation.ElongationTest]:
    """Put k into the model, and E = k·L/A where section and length of the sample are known."""
    prepared = _prepared(task)
    analysis = elongation.analyse(prepared)
    task.model.add(analysis.contribution)
    for measurand in analysis.measurands:
        task.add(measurand)
    task.model.held.extend(_drift(task.name, prepared))
    instruments.add_modulus(task)
    return Analysed(analysis.finding, prepared, analysis.contribution)


def _drift(name: str, test: elongation.ElongationTest) -> Iterator[HeldParameter]:
    """A steady drift that no reading shows, since all repeats take the loads in one order."""
    found = elongation.by_drift(test)
    if found is not None:
        slope, step = found
        yield HeldParameter(
            name, "drift", said("steady drift of the reading, from each reading to the next"), "m", 0.0, 0.5 * step,
            {f"{name}.k": slope}, said(ONE_ORDER),
        )  # fmt: skip


def _prepared(task: Task[ElongationTest]) -> elongation.ElongationTest:
    name, test, model = task.name, task.test, task.model
    used = task.campaign.instruments
    indicator = used[test.instruments.extension]
    weights = used[test.instruments.load] if test.instruments.load else None
    scale = instruments.of_all_indications(test.instruments.load, weights)
    (table,) = task.campaign.tables["tests", name]
    return elongation.ElongationTest(
        name=name,
        loads=tuple(elongation.Load(load_name, _load(name, load_name, test, weights)) for load_name in test.loads),
        readings=_readings(table, _reasons(test)),
        resolution=instruments.resolution(indicator),
        gravity=instruments.shared(model, name, test.gravity, NO_GRAVITY),
        air_density=instruments.shared(model, name, test.air_density, AIR_DENSITY),
        weight_density=instruments.shared(model, name, test.weight_density, WEIGHT_DENSITY),
        # Without a certificate of the weights the loads are as well known as each of them is stated.
        weights=scale if scale is not None and scale.components else None,
        indicator=instruments.of_indication(indicator, "m"),
        scale=instruments.of_all_indications(test.instruments.extension, indicator),
        correction=_correction(model, task.campaign, test.instruments.extension),
        places=places(task.campaign, name),
    )


def _reasons(test: ElongationTest) -> dict[int, str]:
    return {exclusion.line: exclusion.reason for exclusion in test.exclusions if exclusion.line is not None}


def _readings(table: Table, excluded: Mapping[int, str]) -> tuple[elongation.Reading, ...]:
    rows = zip(*_keys(table), table.numbers["reading"].tolist(), table.lines.tolist(), strict=True)
    return tuple(elongation.Reading(*row, excluded=excluded.get(row[-1], "")) for row in rows)


def _load(test_name: str, name: str, test: ElongationTest, weights: Instrument | None) -> Input:
    stated = test.loads[name].mass or test.loads[name].force
    assert stated is not None
    load = stated.input(f"{test_name}.load {name}", said("load {name}", name=name))
    known = instruments.of_indication(weights, load.unit) if weights else ()
    # One set of weights is off by the same at the same load in every test.
    place = at(test.instruments.load or "", weights, f"{load.value:.6g} {load.unit}") if weights else ""
    known = tuple(replace(one, cause=one.cause or f"{one.name}, {place}") for one in known)
    return replace(load, components=(*load.components, *known))


def _correction(model: Model, campaign: Declared, name: str) -> elongation.Correction | None:
    """Return the correction of an instrument's readings: a constant, or a fitted curve at the indication."""
    correction = campaign.instruments[name].correction
    if correction is None:
        return None
    if correction.fit is None:
        key = f"{name}.correction"
        return elongation.Correction(lambda namespace, reading: reading + namespace[key], (model.inputs[key],))
    fit = campaign.fits[correction.fit]
    _refuse_failed_fit(model, campaign, name, correction.fit)
    curve = instruments.fitted_curve(
        correction.fit, fit.model.expression, fit.parameters, origin=fit.origin.si if fit.origin else 0.0
    )
    parameters = tuple(model.inputs[f"{correction.fit}.{parameter}"] for parameter in fit.parameters)
    return elongation.Correction(lambda namespace, reading: reading + curve(namespace, reading), parameters)


def _refuse_failed_fit(model: Model, campaign: Declared, instrument: str, fit: str) -> None:
    if (sentence := model.failed_fits.get(fit)) is not None:
        where = campaign.at("instruments", instrument, "correction", "fit")
        raise MetrologyError(Fault(where, f"fit '{fit}', which failed", "a fit that did not", sentence))


def diagnose(task: Task[ElongationTest], ready: elongation.ElongationTest, rng: np.random.Generator) -> Diagnosis:
    """What the line through load and extension lacks."""
    from metrology.diagnostics import elongation as diagnosed

    return task.model.once(diagnosed, ready, rng=rng, sample=task.test.sample, own=task.campaign.own)


def corrected(
    task: Task[ElongationTest], ready: elongation.ElongationTest, _stated: Contribution, found: Diagnosis
) -> Contribution:
    """K by the line that the data support: k = 1/(b + Δb), b by the line through all readings."""
    from metrology.elongation.correction import corrected

    return corrected(ready, task.model.inputs, found)


def explain(ready: elongation.ElongationTest, setting: Setting) -> Discrepancy:
    """What could part the stiffness or modulus from its reference."""
    from metrology.diagnostics import discrepancy

    return discrepancy.explain(ready, setting)


def yields(campaign: Declared, test: ElongationTest) -> dict[str, str]:
    """Return k, and E where it can be computed."""
    wanted = ("k", "E") if instruments.has_modulus(campaign, test) else ("k",)
    return {name: OUTPUTS[name].unit for name in wanted}


def loading(_campaign: Declared, _name: str, _test: ElongationTest, _finding: object) -> Loading:
    """A minute under each load, as it takes to put it on and read; the file does not say."""
    return Loading(60.0)


OUTPUTS = {"k": Output("N/m", "N/m", "stiffness"), "E": Output("Pa", "GPa", "modulus of elasticity")}
METHOD = Method(
    title="Elongation under dead loads",
    standard="Laboratory method, docs/methods/elongation.md; JCGM 100:2008",
    shown="What an elongation test showed.",
    columns="`load` (a name of `loads`), `repeat` and `direction` (`loading` or `unloading`) where there are several, "
    "`reading / mm`",
    remark="`E` exists where length and section of the sample are given.",
    references=("paper",),
    test=ElongationTest,
    entries=(ElongationInstruments, Load),
    outputs=OUTPUTS,
    yields=yields,
    takes=(),
    whole="",
    readings=readings,
    check=check,
    analyse=analyse,
    finding=elongation.ElongationFinding,
    diagnose=diagnose,
    corrected=corrected,
    explain=explain,
    loading=loading,
    carried=None,
)
