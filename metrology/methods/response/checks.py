"""What must hold within a response test, and for the readings of its runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from metrology import units
from metrology.declaration.columns import Table
from metrology.declaration.document import Place, spell
from metrology.declaration.entry import Refusal, from_text, mean
from metrology.declaration.readings import Readings
from metrology.errors import Fault, Notice
from metrology.message import said
from metrology.method import Files, instruments
from metrology.methods.response.schema import Given, ResponseTest, StatedRun, Thrusting
from metrology.methods.response.units import UNITS, WORDS, by_channel, check_units, columns, due, parameter_unit
from metrology.units.dimensions import TextError, quoted

if TYPE_CHECKING:
    from metrology.declaration.quantity import Stated
    from metrology.method.declared import Declared
    from metrology.rig import Parameter

CHANNELS = tuple(UNITS)
MIN_SAMPLES = 20
SHORT = 0.1
"""Part of the longest file of a run that every other file has to last: ms for s makes a thousandth of it."""
STANDS_FOR = {"k": "stiffness", "c": "damping"}
SOURCES = {"stiffness": "elongation", "damping": "decay"}


def check_response(campaign: Declared, name: str, test: ResponseTest) -> Iterator[Refusal]:
    """Everything that is wrong with a response test, with places from the root of the file."""
    place = ("tests", name)
    yield from _sources(campaign, test, place)
    yield from _model(test, place)
    yield from check_units(test, place)
    yield from _weight(campaign, test, place)
    if test.known.clock_rate and "mass.factor" in test.free:
        yield Refusal((*place, "known", "clock_rate"), "the rate of the clock where the mass is sought",
                      "one of the two", "a record tells the mass over the square of the time")  # fmt: skip
    yield from instruments.check_gravity(test.rig.gravity, *place, "rig", "gravity")
    if not test.runs:
        yield Refusal((*place, "runs"), "no run", "at least one")
    if test.free and all(run.purpose != "identification" for run in test.runs.values()):
        yield Refusal((*place, "runs"), "no run for identification", "a run with 'purpose: identification'")
    owners: dict[str, str] = {}
    for run_name, run in test.runs.items():
        yield from _run(run, (*place, "runs", run_name))
        for index, stated in enumerate(run.readings):
            if owners.setdefault(_identity(stated), run_name) != run_name:
                file = stated.name
                got = f"{quoted(file)}, which run '{owners[_identity(stated)]}' has"
                yield Refusal((*place, "runs", run_name, "readings", index), got, "readings of its own for every run")
    if test.free or test.model:
        # Names of the laboratory's own effects are known once their code was run; until then they are not judged.
        unread = bool(campaign.diagnosis.effects) and not campaign.own
        yield from check_parameters(test, place, parameters(campaign), own=unread)


def _sources(campaign: Declared, test: ResponseTest, place: Place) -> Iterator[Refusal]:
    for key, method in SOURCES.items():
        given: Given | None = getattr(test, key)
        if given is None:
            continue
        unit = due("N/m" if key == "stiffness" else "N*s/m", test)
        if given.value is not None:
            try:
                units.parse(given.value.value, expected=unit)
            except TextError as error:
                yield from_text(error, *place, key)
            continue
        choices = [
            other
            for other, stated in campaign.tests.items()
            if stated.method == method and stated.sample == test.sample and test.rig.coordinate == "position"
        ]
        if given.test not in choices:
            near = mean(given.test or "", choices) or f"known are {', '.join(choices) or 'none'}"
            expected = (
                f"{'an' if method[0] == 'e' else 'a'} {method} test of '{test.sample}', or a quantity with its source"
            )
            yield Refusal((*place, key), quoted(given.test or ""), expected, near, given.test or "")


def _model(test: ResponseTest, place: Place) -> Iterator[Refusal]:
    """Stiffness and damping are either sought or given, each once."""
    if test.rig.attachment == "none":
        for key, word in STANDS_FOR.items():
            if key in test.free or getattr(test, word) is not None:
                yield Refusal(
                    place, f"'{word}' without a line", "no stiffness and no damping where 'attachment' is none"
                )
        return
    for key, word in STANDS_FOR.items():
        given = getattr(test, word) is not None
        if given and key in test.free:
            yield Refusal((*place, word), f"'{word}', and {key} free in 'identification'", "one of the two")
        elif not given and key not in test.free:
            yield Refusal(place, f"no '{word}'", f"'{word}', or {key} among 'free' in 'identification'")
    if "k" in test.free and test.identification and test.identification.start.k is None:
        yield Refusal(
            (*place, "identification"), "no start value of k", "where the search begins, such as 'start: {k: 150 N/m}'"
        )
    for index, name in enumerate(test.free):
        if name in test.free[:index]:
            yield Refusal((*place, "identification", "free", index), f"'{name}' a second time", "every parameter once")


def _weight(campaign: Declared, test: ResponseTest, place: Place) -> Iterator[Refusal]:
    sample = campaign.samples.get(test.sample)
    if test.rig.line_weight == "none" or sample is None:
        return
    if test.rig.attachment != "tether":
        got = f"'{test.rig.line_weight}' with a line attached '{test.rig.attachment}'"
        yield Refusal((*place, "rig", "line_weight"), got, "a line that only pulls")
    for key in ("length", "linear_density"):
        if getattr(sample, key) is None:
            got = f"'{test.rig.line_weight}' without '{key}' of sample '{test.sample}'"
            yield Refusal((*place, "rig", "line_weight"), got, f"'{key}', which the weight of the line needs")


def parameters(campaign: Declared) -> Mapping[str, Parameter]:
    """Parameters of the rig, and those of the campaign's own forces after them."""
    from metrology.rig import PARAMETERS

    own = [one for effect in campaign.own if effect.force for one in effect.entry.parameters]
    return {**PARAMETERS, **{one.name: one for one in own}}


def check_parameters(
    test: ResponseTest, place: Place, known: Mapping[str, Parameter], *, own: bool = False
) -> Iterator[Refusal]:
    """What is wrong with the parameters that a test seeks or carries.

    `known`: those there are. `own`: others may be effects of the laboratory's own, whose names nobody knows before
    their code is run.
    """
    from metrology.rig.model import STRAIGHT

    turns = test.rig.coordinate == "angle"
    bounds = test.identification.bounds if test.identification else {}
    named: list[tuple[str, Place, Sequence[Stated]]] = [
        (name, (*place, "identification", "free", index), ()) for index, name in enumerate(test.free)
    ]
    named += [(name, (*place, "model", name), (value,)) for name, value in test.model.items()]
    named += [(name, (*place, "identification", "bounds", name), ends) for name, ends in bounds.items()]
    for name, where, values in named:
        if turns and name.split(".")[0] in STRAIGHT:
            yield Refusal(where, f"'{name}'", "no effect of a straight path for a rig that turns")
            continue
        if name not in known:
            if own and "." in name:
                continue
            near = mean(name, list(known)) or "docs/model.md lists them"
            yield Refusal(where, f"'{name}', an unknown parameter", "a parameter of the equation of motion", near, name)
            continue
        for value in values:
            try:
                units.parse(value.value, expected=parameter_unit(name, test, known))
            except TextError as error:
                yield from_text(error, *where)
        if name in test.model and where[2] == "model":
            yield from _carried(test, replace(known[name], unit=parameter_unit(name, test, known)), where)


def _carried(test: ResponseTest, entry: Parameter, place: Place) -> Iterator[Refusal]:
    """What is wrong with an effect that the model is to carry."""
    from metrology.rig.parameters import BASE

    name, value = entry.name, test.model[entry.name]
    if name in {one.name for one in BASE}:
        yield Refusal(place, f"'{name}', which every model has", "a parameter of an effect", "", name)
    elif name in test.free:
        yield Refusal(place, f"'{name}', and {name} free in 'identification'", "one of the two", "", name)
    elif not entry.low <= value.si <= entry.high:
        ends = f"from {entry.low:g} to {entry.high:g} {entry.unit}".replace("from -inf to inf ", "of any size in ")
        yield Refusal(place, quoted(value.value), f"a value {ends}".replace("to inf", "up, in"))


def _identity(stated: Readings) -> str:
    """What tells one entry of readings from another: also its columns, as a file may hold channels of several runs."""
    return stated.model_dump_json()


def _run(run: StatedRun, place: Place) -> Iterator[Refusal]:
    if not run.readings:
        yield Refusal((*place, "readings"), "an empty list", "at least one file")
    for index, stated in enumerate(run.readings):
        if stated in run.readings[:index]:
            yield Refusal((*place, "readings", index), f"{quoted(stated.name)} a second time", "every file once")
    if run.held_until is not None and run.start.velocity.si != 0:
        got = f"'{run.start.velocity.value}' for a module that is held until '{run.held_until.value}'"
        yield Refusal((*place, "start", "velocity"), got, "0 m/s, or no 'held_until'")
    for index, part in enumerate(run.thrust or ()):
        yield from _thrust(run.thrust or (), index, part, (*place, "thrust", index))


def _thrust(parts: Sequence[Thrusting], index: int, part: Thrusting, place: Place) -> Iterator[Refusal]:
    if part.to is not None and part.to.si <= part.from_.si:
        yield Refusal(
            (*place, "to"), f"'{part.to.value}', not after '{part.from_.value}'", "an end after the beginning"
        )
    if index == 0:
        return
    before = parts[index - 1]
    if before.to is None:
        yield Refusal((*place, "from"), "a stretch after one without end", "'to' in the stretch before")
    elif part.from_.si < before.to.si:
        got = f"'{part.from_.value}', before the stretch before it ends at '{before.to.value}'"
        yield Refusal((*place, "from"), got, "stretches in order of time that do not overlap")


def readings(name: str, test: ResponseTest) -> Iterator[Files]:
    """The files of every run, which are judged together; the tables of the test stand in the order of its runs."""
    for run_name, run in test.runs.items():
        place: Place = ("tests", name, "runs", run_name)
        files = [((*place, "readings", index), file) for index, file in enumerate(run.readings)]
        yield Files(files, columns(test), partial(_faults, test, run, place))


def _faults(
    test: ResponseTest, run: StatedRun, place: Place, tables: Sequence[Table]
) -> Iterator[Refusal | Fault | Notice]:
    """What is wrong between a run and its readings: faults of the files, and refusals of the campaign file."""
    words, tables = WORDS[test.rig.coordinate], [by_channel(table, test) for table in tables]
    if not tables:
        return
    seen: dict[str, str] = {}
    for table in tables:
        if len(table) < MIN_SAMPLES:
            yield Fault(str(table.path), f"{len(table)} samples", f"at least {MIN_SAMPLES}")
        for channel in (*CHANNELS, "F"):
            if channel not in table.numbers:
                continue
            if channel in seen:
                got = f"'{words[channel]}', which {seen[channel]} has as well"
                yield Fault(f"{table.path}:{table.lines[0] - 1}", got, "every channel of a run in one file")
            seen.setdefault(channel, str(table.name))
    if not set(seen) & set(CHANNELS):
        headings = " or ".join(f"'{words[name]} / {due(unit, test)}'" for name, unit in UNITS.items())
        yield Refusal((*place, "readings"), "no channel", f"a column {headings} in one of the files")
    if run.thrust is not None and "F" in seen:
        yield Refusal((*place, "thrust"), f"'thrust', and a column '{words['F']}' in {seen['F']}", "one of the two")
    yield from _spans(tables)
    yield from _times(run, tables, place)


def _spans(tables: Sequence[Table]) -> Iterator[Fault]:
    """Files of one run that last far from alike: a recorder may begin late or end early, by less than that."""
    lasts = [float(table.numbers["time"][-1] - table.numbers["time"][0]) for table in tables]
    for table, span in zip(tables, lasts, strict=True):
        if span < SHORT * max(lasts):
            got = f"{span:.4g} s, in a run with another file of {max(lasts):.4g} s"
            yield Fault(str(table.path), got, "files of one run over about the same time", "check the unit of time")


def _times(run: StatedRun, tables: Sequence[Table], place: Place) -> Iterator[Refusal | Notice]:
    begin = min(float(table.numbers["time"][0]) for table in tables)
    end, step = max(
        (time[-1], time[-1] - (time[-2] if len(time) > 1 else time[-1]))
        for time in (table.numbers["time"].tolist() for table in tables)
    )
    record = f"within the record, {begin:g} s to {end:g} s"
    if run.held_until is not None and not begin <= run.held_until.si <= end:
        yield Refusal((*place, "held_until"), quoted(run.held_until.value), f"a time {record}")
    for index, part in enumerate(run.thrust or ()):
        if part.to is not None and end < part.to.si <= end + step:
            where = spell((*place, "thrust", index, "to"))
            text = "'{value}' is after the last sample, at {end:g} s, by one sample at most."
            yield Notice(where, said(text, value=part.to.value, end=float(end)))
        elif part.to is not None and part.to.si > end:
            got = f"'{part.to.value}', after the record ends at {end:g} s"
            fix = "leave 'to' out where the thrust goes on, or look for the rest of the record"
            yield Refusal((*place, "thrust", index, "to"), got, "a thrust profile no longer than the record", fix)
        if not begin <= part.from_.si <= end:
            yield Refusal((*place, "thrust", index, "from"), quoted(part.from_.value), f"a time {record}")


def run_tables(tables: Sequence[Table], test: ResponseTest) -> dict[str, tuple[Table, ...]]:
    """Tables of each run by its name, columns by their channels, from those of the whole test in order."""
    found, first = {}, 0
    for name, run in test.runs.items():
        found[name] = tuple(by_channel(table, test) for table in tables[first : first + len(run.readings)])
        first += len(run.readings)
    return found
