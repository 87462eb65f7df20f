"""From what a campaign file declares of a relaxation test to what is evaluated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from metrology import relaxation
from metrology.gum.inputs import Input
from metrology.message import said
from metrology.method import Task, instruments
from metrology.method.model import Identity
from metrology.methods.tension.preparation import CELL, EXTENSOMETER
from metrology.relaxation.model import Facts
from metrology.sample import area
from metrology.tension.model import class_scale

if TYPE_CHECKING:
    from metrology.declaration.columns import Table
    from metrology.method.declared import Declared
    from metrology.methods.relaxation.schema import RelaxationSpecimen, RelaxationTest


def facts(campaign: Declared, test: RelaxationTest) -> Facts:
    """What a test declares, by which its results are known."""
    sample = campaign.samples.get(test.sample)
    left_out = {exclusion.file for exclusion in test.exclusions}
    specimens = [one for one in test.specimens.values() if one.readings.name not in left_out]
    own = sample.length if sample is not None else None
    section = sample.section if sample is not None else None
    return Facts(
        by_strain=test.instruments.crosshead is None,
        length=all((one.length or own) is not None for one in specimens),
        area=all((one.section or section) is not None for one in specimens),
        at=test.at is not None,
    )


def prepared(task: Task[RelaxationTest]) -> relaxation.RelaxationTest:
    """The test as it is evaluated; sections of specimens join the model."""
    name, test = task.name, task.test
    tables = task.campaign.tables["tests", name]
    left_out = {exclusion.file for exclusion in test.exclusions}
    column, reader = test.instruments.reader
    used = task.campaign.instruments
    gauge = test.gauge_length.input(f"{name}.gauge", said("gauge length")) if test.gauge_length else None
    setup = (
        test.setup_compliance.input(f"{name}.setup", said("compliance of the set-up"))
        if test.setup_compliance
        else None
    )
    over = gauge.value if column == "extension" and gauge is not None else 1.0
    mountings = tuple(
        _mounting(task, (specimen, stated, table), over, setup)
        for (specimen, stated), table in zip(test.specimens.items(), tables, strict=False)
        if table.name not in left_out
    )
    force, stretch = (used[each].resolution for each in (test.instruments.force, reader))
    return relaxation.RelaxationTest(
        name=name,
        mountings=mountings,
        held=test.held,
        by_strain=column != "crosshead",
        at=test.at.si if test.at is not None else None,
        branches=test.branches,
        force_scale=_scale(task, test.instruments.force, "ISO 7500-1:2018", CELL),
        stretch_scale=_scale(task, reader, "ISO 9513:2012", {cls: limit for cls, (limit, _) in EXTENSOMETER.items()}),
        gauge=gauge if column == "extension" else None,
        setup=setup,
        force_division=force.si if force is not None else 0.0,
        stretch_division=stretch.si / over if stretch is not None else 0.0,
        dma=_sweep(tables[-1]) if test.dma is not None else None,
    )


def _scale(task: Task[RelaxationTest], instrument: str, standard: str, limits: Mapping[str, float]) -> Input | None:
    """Relative correction of an instrument, by its certificate or by its class."""
    stated = task.campaign.instruments[instrument]
    known = instruments.of_all_indications(instrument, stated)
    if (known is not None and known.components) or stated.class_ not in limits:
        return known
    return class_scale(f"{instrument}.scale", stated.class_, standard, limits[stated.class_])


def _mounting(
    task: Task[RelaxationTest], of: tuple[str, RelaxationSpecimen, Table], gauge: float, setup: Input | None
) -> relaxation.Mounting:
    specimen, stated, table = of
    column, _ = task.test.instruments.reader
    force = np.asarray(table.numbers["force"])
    shown = np.asarray(table.numbers[column]) / gauge
    seen = np.isfinite(force) & np.isfinite(shown)
    length = task.model.inputs.get(f"{task.test.sample}.length")
    if stated.length is not None:
        length = stated.length.input(
            f"{task.name}.{specimen}.length", said("free length of {specimen}", specimen=specimen)
        )
    section = _section(task, specimen, stated)
    time = np.asarray(table.numbers["time"])
    return relaxation.Mounting(
        specimen,
        time[seen],
        force[seen],
        shown[seen],
        length,
        section,
        values(task).get(section, float("nan")),
        setup.value if setup is not None else 0.0,
    )


def _section(task: Task[RelaxationTest], specimen: str, stated: RelaxationSpecimen) -> str:
    """Name of the area of a specimen."""
    model, own, shared = task.model, f"{task.name}.{specimen}", f"{task.test.sample}.A"
    if stated.section is None:
        return shared if shared in model.names else ""
    for key in type(stated.section).model_fields:
        if key != "shape":
            model.add_inputs(
                [getattr(stated.section, key).input(f"{own}.{key}", said("{what} of {item}", what=key, item=specimen))]
            )
    identity = Identity("A", "derived", task.test.sample, "", "mm^2", headline=False)
    model.add_measurand(area(own, stated.section.shape), identity)
    return f"{own}.A"


def _sweep(table: Table) -> relaxation.Sweep:
    numbers = {name: np.asarray(column) for name, column in table.numbers.items()}
    return relaxation.Sweep(
        numbers["frequency"], numbers["storage"], numbers["loss"], numbers.get("u storage"), numbers.get("u loss")
    )


def values(task: Task[RelaxationTest], moved: Mapping[str, float] | None = None) -> dict[str, float]:
    """Values of everything that the model holds already; with some inputs moved."""
    known = {name: one.value for name, one in task.model.inputs.items()} | dict(moved or {})
    for one in task.model.measurands:
        if one.name.endswith(".A"):
            known[one.name] = float(one.function(known))
    return known


def shared(task: Task[RelaxationTest], ready: relaxation.RelaxationTest) -> float:
    """Relative standard uncertainty of scales, lengths and sections, as one number for the bands of the moduli."""
    found = [one.u**2 for one in (ready.force_scale, ready.stretch_scale) if one is not None]
    if ready.gauge is not None:
        found.append((ready.gauge.u / ready.gauge.value) ** 2)
    first = ready.mountings[0]
    if first.length is not None and (not ready.by_strain or not first.area):
        found.append((first.length.u / first.length.value) ** 2)
    if first.area:
        at = values(task)[first.area]
        for name, one in task.model.inputs.items():
            if one.u > 0:
                found.append((values(task, {name: one.value + one.u})[first.area] / at - 1) ** 2)
    if ready.setup is not None:
        # k/(1 − k·ΔC): the largest stiffness counts.
        stiff = max(float(np.ptp(one.force) / np.ptp(one.stretch)) for one in ready.mountings)
        found.append((stiff * ready.setup.u) ** 2)
    return float(np.sqrt(sum(found)))
