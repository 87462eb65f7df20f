"""From what a campaign file declares of a tension test to what is evaluated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from metrology import tension
from metrology.gum.bounded import Rectangular
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Component, Input
from metrology.message import said
from metrology.method import Task, instruments
from metrology.method.model import Identity
from metrology.sample import area
from metrology.tension.model import class_scale
from metrology.tension.results import Facts
from metrology.tension.slope import Array

if TYPE_CHECKING:
    from metrology.declaration.columns import Table
    from metrology.declaration.identity import Instrument
    from metrology.method.declared import Declared
    from metrology.methods.tension.schema import TensionSpecimen, TensionTest

CELL = {"0.5": 0.005, "1": 0.01, "2": 0.02, "3": 0.03}
"""Class → limit of the relative error of indication (ISO 7500-1:2018, table 2)."""
EXTENSOMETER = {"0.2": (0.002, 0.6e-6), "0.5": (0.005, 1.5e-6), "1": (0.01, 3e-6), "2": (0.02, 6e-6)}
"""Class → limit of the relative error, and of the error / m where that is larger (ISO 9513:2012, table 2)."""
UNKNOWN = 0.01
"""Tolerance of straightness where no class is stated: that of class 1."""


def facts(campaign: Declared, test: TensionTest) -> Facts:
    """What a test declares, by which its results are known."""
    sample = campaign.samples.get(test.sample)
    left_out = {exclusion.file for exclusion in test.exclusions}
    specimens = [one for one in test.specimens.values() if one.readings.name not in left_out]
    own = sample.length if sample is not None else None
    lengths = [stated for one in specimens if (stated := one.length or own or test.gauge_length) is not None]
    known = len(lengths) == len(specimens)
    sections = [one.section or (sample.section if sample else None) for one in specimens]
    fibre = sample is not None and sample.linear_density is not None
    return Facts(
        strain=(test.instruments.extension or test.instruments.strain) is not None,
        crosshead=test.instruments.crosshead is not None,
        lengths=len({one.si for one in lengths}) if known else 0,
        sample_length=own is not None,
        area=all(one is not None for one in sections) or (fibre and test.density is not None),
        linear_density=fibre,
        setup=test.setup_compliance is not None,
        to_break=test.to_break,
        secant=test.secant is not None,
        tangent=test.tangent is not None,
    )


def prepared(task: Task[TensionTest]) -> tension.TensionTest:
    """The test as it is evaluated; sections of specimens join the model."""
    name, test, model = task.name, task.test, task.model
    sample = f"{test.sample}.length"
    gauge = _gauge(task)
    left_out = {exclusion.file for exclusion in test.exclusions}
    mountings = tuple(
        _mounting(task, (specimen, stated, table), gauge)
        for (specimen, stated), table in zip(test.specimens.items(), task.campaign.tables["tests", name], strict=True)
        if table.name not in left_out
    )
    used, by = task.campaign.instruments, test.instruments
    reader = by.extension or by.strain
    chosen = tension.Range() if test.range is None else tension.Range(*test.range.ends, test.range.loading)
    ready = tension.TensionTest(
        name=name,
        mountings=mountings,
        range=chosen,
        secant=None if test.secant is None else tension.Range(*test.secant.ends, chosen.passage),
        tangent=None if test.tangent is None else tension.Range(*test.tangent.ends, chosen.passage),
        force_scale=_cell(by.force, used[by.force]),
        crosshead_scale=_crosshead(by.crosshead, used),
        gauge=gauge if by.extension else None,
        setup=test.setup_compliance.input(f"{name}.setup", said("compliance of the set-up"))
        if test.setup_compliance
        else None,
        sample_length=sample if sample in model.inputs else "",
        linear_density=f"{test.sample}.linear_density",
        to_break=test.to_break,
        tolerance=_tolerance(task),
        fall=CELL.get(used[by.force].class_, UNKNOWN),
        divisions=tuple(_divisions(task, gauge)),
    )
    if reader is None:
        return ready
    return replace(ready, strain_scale=_extensometer(f"{name}.{reader}.scale", used[reader], ready))


def _gauge(task: Task[TensionTest]) -> Input | None:
    """Gauge length; where no uncertainty is stated, within what the class of the extensometer allows."""
    stated, reader = task.test.gauge_length, task.test.instruments.extension
    if stated is None:
        return None
    found = stated.input(f"{task.name}.gauge", said("gauge length"))
    cls = task.campaign.instruments[reader].class_ if reader else ""
    if found.components or cls not in EXTENSOMETER:
        return found
    limit = Rectangular(EXTENSOMETER[cls][0] * stated.si)
    source = said("limit of error of the gauge length, class {name}, {standard}", name=cls, standard="ISO 9513:2012")
    return replace(found, components=(Component(said("class {name}", name=cls), limit, source=source),))


def _mounting(task: Task[TensionTest], of: tuple[str, TensionSpecimen, Table], gauge: Input | None) -> tension.Mounting:
    specimen, stated, table = of
    numbers, model = table.numbers, task.model
    strains = _strains(table, gauge.value if gauge is not None and task.test.instruments.extension else 1.0)
    length = model.inputs.get(f"{task.test.sample}.length") or gauge
    if stated.length is not None:
        length = stated.length.input(
            f"{task.name}.{specimen}.length", said("free length of {specimen}", specimen=specimen)
        )
    section, value, u = _section(task, specimen, stated)
    return tension.Mounting(
        specimen, numbers["force"], numbers.get("time"), numbers.get("crosshead"), strains, length, section, value, u
    )


def _strains(table: Table, gauge: float) -> tuple[Array, ...]:
    found = [table.numbers[name] / gauge for name in ("extension", "extension 2") if name in table.numbers]
    return tuple(np.asarray(one) for one in found) or tuple(
        table.numbers[name] for name in ("strain", "strain 2") if name in table.numbers
    )


def _section(task: Task[TensionTest], specimen: str, stated: TensionSpecimen) -> tuple[str, float, float]:
    """Name of the area of a specimen, its value, and the part of its uncertainty that is the specimen's own."""
    model, own = task.model, f"{task.name}.{specimen}"
    if stated.section is None:
        name = _shared_area(task)
        return (name, value(task, name), 0.0) if name else ("", float("nan"), 0.0)
    dimensions = [key for key in type(stated.section).model_fields if key != "shape"]
    for key in dimensions:
        one = getattr(stated.section, key)
        model.add_inputs([one.input(f"{own}.{key}", said("{what} of {item}", what=key, item=specimen))])
    model.add_measurand(area(own, stated.section.shape), Identity("A", "derived", task.test.sample, "", "mm^2",
                                                                  headline=False))  # fmt: skip
    at = value(task, f"{own}.A")
    shares = [getattr(stated.section, key) for key in dimensions]
    twice = 2.0 if stated.section.shape == "round" else 1.0
    return f"{own}.A", at, at * twice * float(np.sqrt(sum((one.u / one.si) ** 2 for one in shares)))


def _shared_area(task: Task[TensionTest]) -> str:
    """Area of the sample's section; of a fibre, mass per length by density."""
    model, sample = task.model, task.test.sample
    if f"{sample}.A" in model.names:
        return f"{sample}.A"
    line, name = f"{sample}.linear_density", f"{task.name}.A"
    if task.test.density is None or line not in model.inputs:
        return ""
    if name not in model.names:
        density = task.test.density.input(f"{task.name}.density", said("density of the material"))
        model.add_inputs([density])
        measurand = Measurand(name, lambda n: n[line] / n[density.name], "m²", "A = λ/ρ")
        model.add_measurand(measurand, Identity("A", "derived", sample, "", "mm^2", headline=False))
    return name


def values(task: Task[TensionTest]) -> Mapping[str, float]:
    """Values of everything that the model holds already."""
    known = {name: one.value for name, one in task.model.inputs.items()}
    for one in task.model.measurands:
        if one.name.endswith(".A"):
            known[one.name] = float(one.function(known))
    return known


def value(task: Task[TensionTest], name: str) -> float:
    """Value of an area."""
    return values(task)[name]


# ---- instruments ----------------------------------------------------------------------------------------------------
def _cell(name: str, instrument: Instrument) -> Input | None:
    """Relative correction of the forces, by the certificate or by the class of the machine."""
    stated = instruments.of_all_indications(name, instrument)
    if (stated is not None and stated.components) or instrument.class_ not in CELL:
        return stated
    return class_scale(f"{name}.scale", instrument.class_, "ISO 7500-1:2018", CELL[instrument.class_])


def _crosshead(name: str | None, used: Mapping[str, Instrument]) -> Input | None:
    if name is None:
        return None
    instrument = used[name]
    stated = instruments.of_all_indications(name, instrument)
    if (stated is not None and stated.components) or instrument.class_ not in EXTENSOMETER:
        return stated
    return class_scale(f"{name}.scale", instrument.class_, "ISO 9513:2012", EXTENSOMETER[instrument.class_][0])


def _extensometer(name: str, instrument: Instrument, ready: tension.TensionTest) -> Input | None:
    """Relative correction of the strains; a short stretch is within the class by its absolute limit."""
    stated = instruments.of_all_indications(name.removesuffix(".scale"), instrument)
    if (stated is not None and stated.components) or instrument.class_ not in EXTENSOMETER:
        return stated
    relative, absolute = EXTENSOMETER[instrument.class_]
    if ready.gauge is not None:
        most = min(float(np.nanmax(one.strain)) for one in ready.mountings if one.strain is not None)
        top = ready.range.high if ready.range.by == "strain" else most
        relative = max(relative, absolute / (min(top, most) * ready.gauge.value))
    return class_scale(name, instrument.class_, "ISO 9513:2012", relative)


def _tolerance(task: Task[TensionTest]) -> float:
    """Deviation from a line that the classes of cell and extensometer allow."""
    used, by = task.campaign.instruments, task.test.instruments
    reader = by.extension or by.strain or by.crosshead
    cell = CELL.get(used[by.force].class_, UNKNOWN)
    cls = used[reader].class_ if reader else ""
    return cell + (EXTENSOMETER[cls][0] if cls in EXTENSOMETER else UNKNOWN)


def _divisions(task: Task[TensionTest], gauge: Input | None) -> list[tuple[str, float]]:
    """Smallest differences of the readings: of an extension as a strain."""
    used, by, found = task.campaign.instruments, task.test.instruments, []
    for column, name, scale in (
        ("crosshead", by.crosshead, 1.0), ("strain", by.strain, 1.0),
        ("strain", by.extension, 1.0 / gauge.value if gauge is not None else 1.0),
    ):  # fmt: skip
        resolution = used[name].resolution if name else None
        if resolution is not None:
            found.append((column, resolution.si * scale))
    return found
